// Room for cloth where a posed body touches or passes through itself: in the armpit, between the
// thighs, where a hand rests on a hip.
//
// Trunk, arms and legs press one another's skin in, as flesh does, until a gap is left between
// them. The pose stays as it is. A function of the pose alone: it does not depend on how it was
// reached. docs/solver.md tells why.
#pragma once

#include <array>
#include <vector>

#include "body/body_model.h"
#include "core/proximity.h"

namespace pleat::sim {

class BodyOpener {
 public:
  static constexpr int kParts = 10;

  explicit BodyOpener(const body::BodyModel& model);

  // posed: #V x 3, m. Returns where the skin is when it has given way.
  Points3 open(const Eigen::Ref<const Points3>& posed);

 private:
  // How the vertices want to move for room from other parts that come within max_distance.
  Points3 press(const std::vector<int>& vertices, double max_distance) const;
  void refit(const Points3& vertices, const std::vector<char>& has_moved);

  Faces faces_;
  Points3 vertices_, normals_;  // where they stand at the moment
  std::vector<int> part_;       // of each vertex
  Eigen::VectorXd softness_;    // the same: what moves is shared out by it
  std::vector<Faces> part_faces_;
  std::vector<SurfaceTree> parts_;  // of faces whose corners are all in the part
  Eigen::Matrix<float, Eigen::Dynamic, kParts>
      apart_;  // #V, m: distance to each part in the T-pose
  std::vector<std::vector<int>> neighbours_;
};

}  // namespace pleat::sim
