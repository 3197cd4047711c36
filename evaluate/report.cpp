#include "evaluate/report.h"

#include <cstdio>
#include <nlohmann/json.hpp>

namespace pleat::evaluate {
namespace {

using Json = nlohmann::ordered_json;

Json to_json(const VertexError& error) {
  return {{"mean_mm", error.mean_mm}, {"p95_mm", error.p95_mm}, {"max_mm", error.max_mm}};
}

Json to_json(const Plausibility& one) {
  return {{"inside_share", one.inside_share},      {"mean_depth_mm", one.mean_depth_mm},
          {"max_depth_mm", one.max_depth_mm},      {"body_intersections", one.body_intersections},
          {"strain_95", one.strain.percentile_95}, {"max_strain", one.strain.max}};
}

Json to_json(const PlausibilitySummary& summary) {
  if (summary.count == 0) return nullptr;
  return {{"count", summary.count},
          {"inside_share", summary.inside_share},
          {"mean_depth_mm", summary.mean_depth_mm},
          {"max_depth_mm", summary.max_depth_mm},
          {"body_intersections", summary.body_intersections},
          {"strain_95", summary.strain_95},
          {"max_strain", summary.max_strain}};
}

Json to_json(double number) { return number; }

template <typename T>
Json to_json(const std::optional<T>& value) {
  return value ? to_json(*value) : Json(nullptr);
}

Json to_json(const SplitEvaluation& split) {
  Json json = {{"split", split.split}, {"rows", split.rows}, {"samples", split.samples}};
  json["error"] = to_json(split.error);
  json["velocity_pairs"] = split.velocity_pairs;
  json["velocity_error_mm_per_s"] =
      split.velocity_pairs ? Json(split.velocity_error_mm_per_s) : Json(nullptr);
  json["spread_rows"] = split.spread_rows;
  json["spread_mm"] = split.spread_rows ? Json(split.spread_mm) : Json(nullptr);
  json["plausibility"] = {{"sampled", to_json(split.sampled)},
                          {"reference", to_json(split.reference)}};
  json["baselines"] = {
      {"mean_texture", to_json(split.mean_texture)},
      {"nearest_pose", split.nearest_pose_rows ? to_json(split.nearest_pose) : Json(nullptr)}};
  return json;
}

Json to_json(const RowEvaluation& row) {
  Json json = {{"row", row.row},
               {"split", encode::split_name(row.split)},
               {"design", row.design},
               {"sequence", row.sequence},
               {"frame", row.frame}};
  json["samples"] = Json::array();
  for (const SampleEvaluation& sample : row.samples) {
    json["samples"].push_back({{"sample", sample.sample},
                               {"error", to_json(sample.error)},
                               {"velocity_error_mm_per_s", to_json(sample.velocity_error_mm_per_s)},
                               {"plausibility", to_json(sample.plausibility)}});
  }
  json["spread_mm"] = to_json(row.spread_mm);
  json["reference"] = to_json(row.reference);
  json["baselines"] = {{"mean_texture", to_json(row.mean_texture)},
                       {"nearest_pose", to_json(row.nearest_pose)}};
  return json;
}

}  // namespace

std::string report_json(const Evaluation& evaluation, const Provenance& provenance) {
  Json json = {{"schema_version", 1},
               {"dataset", evaluation.dataset_file},
               {"samples", evaluation.samples_file},
               {"is_complete", !evaluation.is_interrupted}};
  json["splits"] = Json::array();
  for (const SplitEvaluation& split : evaluation.splits) json["splits"].push_back(to_json(split));
  json["rows"] = Json::array();
  for (const RowEvaluation& row : evaluation.rows) json["rows"].push_back(to_json(row));
  json["provenance"] = Json::parse(provenance_json(provenance));
  return json.dump(1) + "\n";
}

void write_report(const std::string& path, const Evaluation& evaluation,
                  const Provenance& provenance) {
  write_file_atomically(path, report_json(evaluation, provenance));
}

std::string summary(const Evaluation& evaluation) {
  const auto number = [](double value, bool is_measured) {
    char text[24] = "              -";
    if (is_measured) std::snprintf(text, sizeof text, "%15.3f", value);
    return std::string(text);
  };
  std::string text =
      "split                samples        mean mm         p95 mm         max mm  velocity mm/s  "
      "spread mm      "
      "mean texture   nearest pose\n";
  for (const SplitEvaluation& split : evaluation.splits) {
    char head[64];
    std::snprintf(head, sizeof head, "%-18s %9lld", split.split.c_str(),
                  static_cast<long long>(split.samples));
    text += head;
    for (const double mm : {split.error.mean_mm, split.error.p95_mm, split.error.max_mm})
      text += number(mm, true);
    text += number(split.velocity_error_mm_per_s, split.velocity_pairs > 0);
    text += number(split.spread_mm, split.spread_rows > 0);
    text += number(split.mean_texture.mean_mm, true) +
            number(split.nearest_pose.mean_mm, split.nearest_pose_rows > 0);
    text += "\n";
  }
  return text;
}

}  // namespace pleat::evaluate
