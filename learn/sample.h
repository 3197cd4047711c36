// Checkpoints at work: textures for conditions, templates for designs.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/provenance.h"
#include "core/types.h"
#include "learn/condition.h"
#include "learn/config.h"

namespace pleat::learn {

// p(y | c), loaded once.
class DiffusionModel {
 public:
  explicit DiffusionModel(
      const std::string& checkpoint);  // InputError: missing, truncated, another's file
  DiffusionModel(DiffusionModel&&) noexcept;
  ~DiffusionModel();

  int resolution() const;  // R
  int64_t joints() const;  // a condition's pose rows
  int64_t shape_count() const;

  // One texture a condition: [K, 3, R, R], row-major, m, 0 outside the mask. The noise of sample k
  // comes from the random stream (config.seed, streams[k]) alone: the same stream and condition
  // give the same texture in any batch.
  std::vector<float> sample(const std::vector<Condition>& conditions,
                            const std::vector<std::string>& streams,
                            const SampleConfig& config) const;

 private:
  struct Model;
  std::unique_ptr<Model> model_;
};

// Samples for rows of a dataset, samples_per_row each, into samples.h5: `textures` float32 [K, 3,
// R, R] (m), `row` and `draw` int32 [K]. Stops at Ctrl-C without writing; says whether it finished.
bool sample_textures(const std::string& checkpoint, const std::string& dataset,
                     const std::vector<int64_t>& rows, const SampleConfig& config,
                     const std::string& output, const Provenance& provenance);

// At most `count` rows of the dataset's `split` (0 .. 3: docs/dataset.md), evenly spread.
std::vector<int64_t> rows_of_split(const std::string& dataset, int split, int64_t count);

struct DesignShape {
  Points3 vertices;  // N x 3, template in the T-pose, m
  Points2 uv;        // M x 2, in [0, 1]^2
};
// G_design of a checkpoint for rows p = (length, sleeve, cleavage) in [0, 1]^3.
std::vector<DesignShape> predict_design(const std::string& checkpoint,
                                        const std::vector<Vec<3>>& designs);

}  // namespace pleat::learn
