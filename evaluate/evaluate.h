// The stage `evaluate`: sampled textures against the dataset's own, as garments on bodies.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "encode/dataset.h"
#include "evaluate/plausibility.h"
#include "evaluate/vertex_error.h"

namespace pleat::evaluate {

struct EvaluateConfig {         // section `evaluate`
  int plausibility_stride = 1;  // every how many-th sampled row is tested against the body; 0: none
  double search_distance_m = 0.05;  // up to which depths inside the body are exact
};
void validate(const EvaluateConfig& config);  // throws InputError naming the key

struct SampleEvaluation {
  int64_t sample = 0;  // in the samples' file
  VertexError error;   // against the dataset's texture of the row, both decoded and posed
  std::optional<double> velocity_error_mm_per_s;  // where the frame before was sampled too
  std::optional<Plausibility> plausibility;
};

// One row of the dataset that was sampled.
struct RowEvaluation {
  int64_t row = 0;
  encode::Split split = encode::kTrain;
  std::string design, sequence;
  int frame = 0;
  std::vector<SampleEvaluation> samples;
  std::optional<double> spread_mm;  // where there are several samples
  VertexError mean_texture;         // baselines
  std::optional<VertexError> nearest_pose;
  std::optional<Plausibility> reference;  // of the dataset's own garment, through the codec as well
};

// Means over samples, except where the name says max; the errors over all vertices of all samples.
struct PlausibilitySummary {
  int64_t count = 0;
  double inside_share = 0, mean_depth_mm = 0, max_depth_mm = 0, body_intersections = 0;
  double strain_95 = 0, max_strain = 0;
};
struct SplitEvaluation {
  std::string split;  // or "all"
  int64_t rows = 0, samples = 0;
  VertexError error, mean_texture, nearest_pose;
  int64_t nearest_pose_rows = 0;
  int64_t velocity_pairs = 0;
  double velocity_error_mm_per_s = 0;
  int64_t spread_rows = 0;
  double spread_mm = 0;
  PlausibilitySummary sampled, reference;
};

struct Evaluation {
  std::string dataset_file, samples_file;
  std::vector<RowEvaluation> rows;      // ascending
  std::vector<SplitEvaluation> splits;  // those with samples, then "all"
  bool is_interrupted = false;          // by the user: rows are missing
};

Evaluation evaluate(const std::string& dataset_file, const std::string& samples_file,
                    const std::string& body_file, const EvaluateConfig& config);

}  // namespace pleat::evaluate
