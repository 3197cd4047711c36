#include "evaluate/evaluate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "evaluate/report.h"
#include "tests/evaluate/small_dataset.h"

namespace pleat::evaluate {
namespace {

constexpr double kFloat = 1e-4;  // mm: textures are float, and poses pass through float

const SplitEvaluation& split(const Evaluation& evaluation, const std::string& name) {
  for (const SplitEvaluation& split : evaluation.splits) {
    if (split.split == name) return split;
  }
  throw std::runtime_error("no split " + name);
}

TEST(Evaluate, FindsNoErrorInTheDatasetsOwnTextures) {
  const SmallDataset small;
  small.write_samples({4, 5, 6, 7, 8}, {0, 0, 0, 0, 0});
  const Evaluation evaluation =
      evaluate(small.dataset_file, small.samples_file, small.body_file, {});
  ASSERT_EQ(evaluation.rows.size(), 5u);
  for (const RowEvaluation& row : evaluation.rows) {
    ASSERT_EQ(row.samples.size(), 1u);
    EXPECT_EQ(row.samples[0].error.max_mm, 0);
    EXPECT_GT(row.mean_texture.mean_mm, 0.1);
    EXPECT_GT(row.nearest_pose.value().mean_mm, 0.1);
    EXPECT_EQ(row.samples[0].plausibility.value().strain.max, row.reference.value().strain.max);
  }
  EXPECT_EQ(evaluation.splits.size(), 3u);
  EXPECT_EQ(split(evaluation, "held_out_sequence").samples, 4);
  EXPECT_EQ(split(evaluation, "held_out_sequence").velocity_pairs, 3);
  EXPECT_EQ(split(evaluation, "held_out_sequence").velocity_error_mm_per_s, 0);
  EXPECT_EQ(split(evaluation, "held_out_design").samples, 1);
  EXPECT_EQ(split(evaluation, "held_out_design").velocity_pairs, 0);
  EXPECT_EQ(split(evaluation, "all").samples, 5);
  EXPECT_EQ(split(evaluation, "all").error.mean_mm, 0);
}

TEST(Evaluate, FindsAKnownShiftInMillimetres) {
  const SmallDataset small;
  small.write_samples({4, 5, 9}, {0.005f, 0.005f, 0.002f});
  const Evaluation evaluation =
      evaluate(small.dataset_file, small.samples_file, small.body_file, {});
  EXPECT_NEAR(evaluation.rows[0].samples[0].error.mean_mm, 5, kFloat);
  EXPECT_NEAR(evaluation.rows[0].samples[0].error.p95_mm, 5, kFloat);
  EXPECT_NEAR(evaluation.rows[2].samples[0].error.max_mm, 2, kFloat);
  EXPECT_NEAR(split(evaluation, "all").error.mean_mm, 4, kFloat);
  // The shift turns with the root between rows 4 and 5, by 0.3 rad about y and 0.02 about x.
  const double turned = 2 * 5 * std::sin(0.15) * 30;
  EXPECT_NEAR(evaluation.rows[1].samples[0].velocity_error_mm_per_s.value(), turned, 0.01 * turned);
  EXPECT_FALSE(evaluation.rows[0].samples[0].velocity_error_mm_per_s.has_value());
}

TEST(Evaluate, MeasuresTheSpreadOfSeveralSamples) {
  const SmallDataset small;
  small.write_samples({6, 4, 6}, {0.003f, 0.0f, -0.003f});
  const Evaluation evaluation =
      evaluate(small.dataset_file, small.samples_file, small.body_file, {});
  ASSERT_EQ(evaluation.rows.size(), 2u);
  EXPECT_FALSE(evaluation.rows[0].spread_mm.has_value());
  EXPECT_NEAR(evaluation.rows[1].spread_mm.value(), 3, kFloat);
  EXPECT_EQ(evaluation.rows[1].samples[1].sample, 2);
  EXPECT_NEAR(split(evaluation, "all").spread_mm, 3, kFloat);
}

TEST(Evaluate, TestsAgainstTheBodyAtTheStrideAskedFor) {
  const SmallDataset small;
  small.write_samples({4, 5, 6, 7}, {0, 0, 0, 0});
  EvaluateConfig config;
  config.plausibility_stride = 3;
  const Evaluation every_third =
      evaluate(small.dataset_file, small.samples_file, small.body_file, config);
  EXPECT_TRUE(every_third.rows[0].reference.has_value());
  EXPECT_FALSE(every_third.rows[1].reference.has_value());
  EXPECT_TRUE(every_third.rows[3].reference.has_value());
  EXPECT_EQ(split(every_third, "all").sampled.count, 2);
  config.plausibility_stride = 0;
  const Evaluation none = evaluate(small.dataset_file, small.samples_file, small.body_file, config);
  EXPECT_EQ(split(none, "all").sampled.count, 0);
}

TEST(Evaluate, RefusesAnotherBody) {
  const SmallDataset small;
  small.write_samples({4}, {0});
  body::BodyModel other = small.model;
  other.template_vertices.col(0) *= 1.1;
  body::write_body(small.body_file, other);
  EXPECT_THROW(evaluate(small.dataset_file, small.samples_file, small.body_file, {}), InputError);
}

TEST(Evaluate, RefusesSamplesThatAreNotFinite) {
  const SmallDataset small;
  small.write_samples({4}, {std::nanf("")});
  EXPECT_THROW(evaluate(small.dataset_file, small.samples_file, small.body_file, {}), InputError);
}

TEST(Evaluate, ConfigNamesTheWrongKey) {
  EvaluateConfig config;
  config.plausibility_stride = -1;
  try {
    validate(config);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("evaluate.plausibility_stride"));
  }
}

TEST(Report, SaysNullWhereNothingWasMeasured) {
  const SmallDataset small;
  small.write_samples({1, 4}, {0.001f, 0.001f});
  EvaluateConfig config;
  config.plausibility_stride = 0;
  const Evaluation evaluation =
      evaluate(small.dataset_file, small.samples_file, small.body_file, config);
  write_report(small.folder / "report.json", evaluation, {"evaluate", "", 0, {}});
  std::ifstream file(small.folder / "report.json");
  const nlohmann::json report = nlohmann::json::parse(file);
  EXPECT_EQ(report["is_complete"], true);
  ASSERT_EQ(report["splits"].size(), 3u);  // train, held_out_sequence, all
  EXPECT_EQ(report["splits"][0]["split"], "train");
  EXPECT_NEAR(report["splits"][0]["error"]["mean_mm"].get<double>(), 1, kFloat);
  EXPECT_TRUE(report["splits"][0]["velocity_error_mm_per_s"].is_null());
  EXPECT_TRUE(report["splits"][0]["plausibility"]["sampled"].is_null());
  EXPECT_TRUE(report["splits"][0]["baselines"]["nearest_pose"].is_null());
  EXPECT_TRUE(report["splits"][1]["baselines"]["nearest_pose"]["mean_mm"].is_number());
  EXPECT_TRUE(report["rows"][0]["spread_mm"].is_null());
  EXPECT_EQ(report["rows"][1]["sequence"], "jump");
  EXPECT_EQ(report["provenance"]["stage"], "evaluate");
  EXPECT_THAT(summary(evaluation), testing::HasSubstr("held_out_sequence"));
}

}  // namespace
}  // namespace pleat::evaluate
