#include "evaluate/baselines.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace pleat::evaluate {
namespace {

Eigen::Quaterniond quaternion(const Eigen::Ref<const Eigen::RowVector3d>& axis_angle) {
  const double angle = axis_angle.norm();
  if (angle == 0) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis_angle.transpose() / angle));
}

// q = turn about y, then the rest: the rest.
Eigen::Quaterniond without_heading(const Eigen::Quaterniond& q) {
  const double length = std::hypot(q.w(), q.y());
  if (length < 1e-12) return q;
  const Eigen::Quaterniond heading(q.w() / length, 0, q.y() / length, 0);
  return heading.conjugate() * q;
}

double design_distance(const garment::Design& a, const garment::Design& b) {
  return Vec<3>(a.length - b.length, a.sleeve - b.sleeve, a.cleavage - b.cleavage).norm();
}

}  // namespace

encode::Texture mean_training_texture(const encode::Dataset& dataset) {
  const int size = dataset.contents().texture_size;
  std::vector<double> sum(3 * dataset.contents().mask.size(), 0.0);
  int64_t count = 0;
  for (int64_t row = 0; row < dataset.row_count(); ++row) {
    if (dataset.row(row).split != encode::kTrain) continue;
    const encode::Texture texture = dataset.texture(row);
    for (size_t i = 0; i < sum.size(); ++i) sum[i] += static_cast<double>(texture.values[i]);
    ++count;
  }
  encode::Texture mean{size, std::vector<float>(sum.size(), 0.0f)};
  for (size_t i = 0; i < sum.size() && count > 0; ++i) {
    mean.values[i] = static_cast<float>(sum[i] / static_cast<double>(count));
  }
  return mean;
}

NearestPose::NearestPose(const encode::Dataset& dataset) : dataset_(dataset) {
  rotations_.reserve(static_cast<size_t>(dataset.row_count()));
  for (const encode::DatasetRow& row : dataset.contents().rows) {
    Quaternions rotations;
    for (int j = 0; j < body::kJoints; ++j) {
      Eigen::Quaterniond q = quaternion(row.pose.rotations.row(j));
      if (j == 0) q = without_heading(q);
      rotations.row(j) << q.w(), q.x(), q.y(), q.z();
    }
    rotations_.push_back(rotations);
  }
}

std::optional<int64_t> NearestPose::row(int64_t query) const {
  const encode::DatasetRow& wanted = dataset_.row(query);
  const garment::Design& design = dataset_.garment(query).design;
  const Quaternions& rotations = rotations_[static_cast<size_t>(query)];
  std::optional<int64_t> best;
  double best_design = std::numeric_limits<double>::infinity(), best_pose = best_design;
  for (int64_t row = 0; row < dataset_.row_count(); ++row) {
    const encode::DatasetRow& candidate = dataset_.row(row);
    if (candidate.split != encode::kTrain || candidate.clip_key == wanted.clip_key) continue;
    const double of_design = design_distance(design, dataset_.garment(row).design);
    if (of_design > best_design) continue;
    double of_pose = 0;  // squared angles, rad^2
    for (int j = 0; j < body::kJoints; ++j) {
      const double cosine =
          std::abs(rotations.row(j).dot(rotations_[static_cast<size_t>(row)].row(j)));
      const double angle = 2 * std::acos(std::min(1.0, cosine));
      of_pose += angle * angle;
    }
    if (of_design < best_design || of_pose < best_pose) {
      best_design = of_design;
      best_pose = of_pose;
      best = row;
    }
  }
  return best;
}

}  // namespace pleat::evaluate
