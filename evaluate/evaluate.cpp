#include "evaluate/evaluate.h"

#include <algorithm>
#include <map>

#include "core/error.h"
#include "core/progress.h"
#include "evaluate/baselines.h"
#include "evaluate/diversity.h"
#include "evaluate/velocity_error.h"

namespace pleat::evaluate {
namespace {

// Everything a row is measured with.
struct Bench {
  encode::Dataset dataset;
  body::BodyModel model;
  encode::Samples samples;
  std::map<int64_t, std::vector<int64_t>> samples_of_row;
  encode::Texture mean_texture;
};

// Of one split, while rows come in.
struct Tally {
  int64_t rows = 0, samples = 0;
  encode::ErrorSummary error, mean_texture, nearest_pose;
  int64_t nearest_pose_rows = 0;
  int64_t velocity_pairs = 0;
  double velocity_sum = 0;
  int64_t spread_rows = 0;
  double spread_sum = 0;
  PlausibilitySummary sampled, reference;  // sums, until finished
};

void add_errors(encode::ErrorSummary& summary, const Points3& vertices, const Points3& truth) {
  for (const double error : encode::vertex_distances_mm(vertices, truth)) summary.add(error);
}

void add(PlausibilitySummary& sum, const Plausibility& one) {
  ++sum.count;
  sum.inside_share += one.inside_share;
  sum.mean_depth_mm += one.mean_depth_mm;
  sum.max_depth_mm = std::max(sum.max_depth_mm, one.max_depth_mm);
  sum.body_intersections += one.body_intersections;
  sum.strain_95 += one.strain.percentile_95;
  sum.max_strain = std::max(sum.max_strain, one.strain.max);
}

void add(PlausibilitySummary& sum, const PlausibilitySummary& other) {
  sum.count += other.count;
  sum.inside_share += other.inside_share;
  sum.mean_depth_mm += other.mean_depth_mm;
  sum.max_depth_mm = std::max(sum.max_depth_mm, other.max_depth_mm);
  sum.body_intersections += other.body_intersections;
  sum.strain_95 += other.strain_95;
  sum.max_strain = std::max(sum.max_strain, other.max_strain);
}

PlausibilitySummary mean(PlausibilitySummary sum) {
  const double count = static_cast<double>(std::max<int64_t>(1, sum.count));
  sum.inside_share /= count;
  sum.mean_depth_mm /= count;
  sum.body_intersections /= count;
  sum.strain_95 /= count;
  return sum;
}

void add(Tally& sum, const Tally& other) {
  sum.rows += other.rows;
  sum.samples += other.samples;
  sum.error.add(other.error);
  sum.mean_texture.add(other.mean_texture);
  sum.nearest_pose.add(other.nearest_pose);
  sum.nearest_pose_rows += other.nearest_pose_rows;
  sum.velocity_pairs += other.velocity_pairs;
  sum.velocity_sum += other.velocity_sum;
  sum.spread_rows += other.spread_rows;
  sum.spread_sum += other.spread_sum;
  add(sum.sampled, other.sampled);
  add(sum.reference, other.reference);
}

SplitEvaluation finish(const std::string& name, const Tally& tally) {
  SplitEvaluation result;
  result.split = name;
  result.rows = tally.rows;
  result.samples = tally.samples;
  result.error = vertex_error(tally.error);
  result.mean_texture = vertex_error(tally.mean_texture);
  result.nearest_pose = vertex_error(tally.nearest_pose);
  result.nearest_pose_rows = tally.nearest_pose_rows;
  result.velocity_pairs = tally.velocity_pairs;
  if (tally.velocity_pairs) {
    result.velocity_error_mm_per_s = tally.velocity_sum / static_cast<double>(tally.velocity_pairs);
  }
  result.spread_rows = tally.spread_rows;
  if (tally.spread_rows)
    result.spread_mm = tally.spread_sum / static_cast<double>(tally.spread_rows);
  result.sampled = mean(tally.sampled);
  result.reference = mean(tally.reference);
  return result;
}

// The velocity errors of a row's samples: the k-th sample of a row follows the k-th sample of the
// row before.
void measure_velocity(const Bench& bench, const std::vector<Points3>& sampled, const Points3& truth,
                      RowEvaluation& result) {
  const int64_t previous = bench.dataset.row(result.row).previous;
  const auto found = bench.samples_of_row.find(previous);
  if (previous < 0 || found == bench.samples_of_row.end()) return;
  const double rate = bench.dataset.contents()
                          .sequences[static_cast<size_t>(bench.dataset.row(result.row).sequence)]
                          .frame_rate_hz;
  const Points3 previous_truth =
      encode::decode_posed(bench.dataset, previous, bench.dataset.texture(previous), bench.model);
  for (size_t k = 0; k < sampled.size() && k < found->second.size(); ++k) {
    const Points3 before = encode::decode_posed(
        bench.dataset, previous, bench.samples.texture(found->second[k]), bench.model);
    result.samples[k].velocity_error_mm_per_s =
        velocity_error_mm_per_s(before, sampled[k], previous_truth, truth, rate);
  }
}

RowEvaluation evaluate_row(const Bench& bench, const NearestPose& nearest, int64_t row,
                           bool with_body, const EvaluateConfig& config, Tally& tally) {
  const encode::Dataset& dataset = bench.dataset;
  const encode::DatasetRow& frame = dataset.row(row);
  const garment::Garment& garment = dataset.garment(row);
  const auto posed = [&](const encode::Texture& texture) {
    return encode::decode_posed(dataset, row, texture, bench.model);
  };
  RowEvaluation result;
  result.row = row;
  result.split = frame.split;
  result.design = garment.design.name;
  result.sequence = dataset.contents().sequences[static_cast<size_t>(frame.sequence)].name;
  result.frame = frame.frame;
  const Points3 truth = posed(dataset.texture(row));

  std::vector<Points3> sampled;
  for (const int64_t sample : bench.samples_of_row.at(row)) {
    sampled.push_back(posed(bench.samples.texture(sample)));
    result.samples.push_back(
        {sample, vertex_error(sampled.back(), truth), std::nullopt, std::nullopt});
    add_errors(tally.error, sampled.back(), truth);
  }
  measure_velocity(bench, sampled, truth, result);
  if (sampled.size() > 1) result.spread_mm = spread_mm(sampled);

  const Points3 mean = posed(bench.mean_texture);
  result.mean_texture = vertex_error(mean, truth);
  add_errors(tally.mean_texture, mean, truth);
  if (const std::optional<int64_t> near = nearest.row(row)) {
    const Points3 copied = posed(dataset.texture(*near));
    result.nearest_pose = vertex_error(copied, truth);
    add_errors(tally.nearest_pose, copied, truth);
    ++tally.nearest_pose_rows;
  }
  if (with_body) {
    const SurfaceTree body(encode::posed_body(dataset, row, bench.model), bench.model.faces);
    result.reference = plausibility(garment, truth, body, config.search_distance_m);
    add(tally.reference, *result.reference);
    for (size_t k = 0; k < sampled.size(); ++k) {
      result.samples[k].plausibility =
          plausibility(garment, sampled[k], body, config.search_distance_m);
      add(tally.sampled, *result.samples[k].plausibility);
    }
  }

  ++tally.rows;
  tally.samples += static_cast<int64_t>(sampled.size());
  for (const SampleEvaluation& sample : result.samples) {
    if (!sample.velocity_error_mm_per_s) continue;
    ++tally.velocity_pairs;
    tally.velocity_sum += *sample.velocity_error_mm_per_s;
  }
  if (result.spread_mm) {
    ++tally.spread_rows;
    tally.spread_sum += *result.spread_mm;
  }
  return result;
}

Bench open_bench(const std::string& dataset_file, const std::string& samples_file,
                 const std::string& body_file) {
  encode::Dataset dataset(dataset_file);
  body::BodyModel model = encode::read_body_of(dataset, body_file);
  encode::Samples samples(samples_file, dataset);
  std::map<int64_t, std::vector<int64_t>> samples_of_row;
  for (int64_t sample = 0; sample < samples.count(); ++sample)
    samples_of_row[samples.row(sample)].push_back(sample);
  encode::Texture mean = mean_training_texture(dataset);
  return {std::move(dataset), std::move(model), std::move(samples), std::move(samples_of_row),
          std::move(mean)};
}

}  // namespace

void validate(const EvaluateConfig& config) {
  if (config.plausibility_stride < 0) {
    throw InputError("evaluate.plausibility_stride = " +
                     std::to_string(config.plausibility_stride) + "; expected >= 0");
  }
  if (!(config.search_distance_m > 0 && config.search_distance_m <= 1)) {
    throw InputError("evaluate.search_distance_m = " + std::to_string(config.search_distance_m) +
                     "; expected > 0 and at most 1");
  }
}

Evaluation evaluate(const std::string& dataset_file, const std::string& samples_file,
                    const std::string& body_file, const EvaluateConfig& config) {
  validate(config);
  const Bench bench = open_bench(dataset_file, samples_file, body_file);
  const NearestPose nearest(bench.dataset);

  Evaluation evaluation{dataset_file, samples_file, {}, {}, false};
  std::array<Tally, encode::kSplits> tallies;
  Progress progress("evaluate", static_cast<int64_t>(bench.samples_of_row.size()), "rows");
  for (const auto& entry : bench.samples_of_row) {
    if (is_interrupted()) {
      evaluation.is_interrupted = true;
      break;
    }
    const int stride = config.plausibility_stride;
    const bool with_body = stride > 0 && evaluation.rows.size() % static_cast<size_t>(stride) == 0;
    Tally& tally = tallies[bench.dataset.row(entry.first).split];
    evaluation.rows.push_back(evaluate_row(bench, nearest, entry.first, with_body, config, tally));
    progress.advance();
  }

  Tally all;
  for (int split = 0; split < encode::kSplits; ++split) {
    const Tally& tally = tallies[static_cast<size_t>(split)];
    if (tally.rows == 0) continue;
    evaluation.splits.push_back(finish(encode::split_name(split), tally));
    add(all, tally);
  }
  evaluation.splits.push_back(finish("all", all));
  return evaluation;
}

}  // namespace pleat::evaluate
