// What a model must beat: predictors that look the answer up in the training split.
#pragma once

#include <optional>
#include <vector>

#include "encode/dataset.h"

namespace pleat::evaluate {

// The mean texture of the training split, whatever the pose, shape and design.
encode::Texture mean_training_texture(const encode::Dataset& dataset);

// The training row of the nearest pose among those of the nearest design. Rows of the query's own
// clip do not count, since the frame before is always near.
class NearestPose {
 public:
  explicit NearestPose(const encode::Dataset& dataset);
  std::optional<int64_t> row(
      int64_t query) const;  // none where all training rows are of the query's clip

 private:
  // Joint rotations as unit quaternions; the root's turn about the vertical axis is left out, since
  // gravity does not see it.
  using Quaternions = Eigen::Matrix<double, body::kJoints, 4, Eigen::RowMajor>;
  const encode::Dataset& dataset_;
  std::vector<Quaternions> rotations_;  // of every row
};

}  // namespace pleat::evaluate
