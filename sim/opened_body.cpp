#include "sim/opened_body.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "body/skinning.h"
#include "core/mesh.h"

namespace pleat::sim {
namespace {

constexpr double kGap = 0.012;  // m, between parts: two layers of cloth and what keeps them off
constexpr double kSlope =
    0.3;  // near where parts join the gap is at most this share of the T-pose's
constexpr double kDeepest = 0.03;  // m: parts that pass deeper into one another are not parted
constexpr double kJoined = 0.02;   // m: nearer in the T-pose, parts belong together
constexpr int kRounds = 12;
constexpr int kRings = 3;  // of skin around what is pressed that follow smoothly

std::vector<int> parts_of(const body::BodyModel& model) {
  // 0 trunk; left and right: 1, 2 upper arm, 3, 4 forearm, 5, 6 thigh, 7, 8 lower leg; 9 head.
  constexpr std::array<int, body::kJoints> kPartOfJoint = {0, 5, 6, 0, 7, 8, 0, 7, 8, 0, 7, 8,
                                                           0, 0, 0, 9, 1, 2, 3, 4, 3, 4, 3, 4};
  std::vector<int> parts(model.template_vertices.rows());
  for (size_t v = 0; v < parts.size(); ++v) {
    std::array<double, BodyOpener::kParts> weight = {};
    for (SkinWeights::InnerIterator w(model.weights, static_cast<Eigen::Index>(v)); w; ++w) {
      int joint = static_cast<int>(w.col());
      while (joint >= body::kJoints) joint = model.parents[joint];
      weight[kPartOfJoint[joint]] += w.value();
    }
    parts[v] = static_cast<int>(std::max_element(weight.begin(), weight.end()) - weight.begin());
  }
  return parts;
}

// How readily the skin of each vertex gives way, against that of another part: a hand hardly. It
// is so thin that pressed in by half of what is lacking its fingers would fold.
Eigen::VectorXd softness_of(const body::BodyModel& model) {
  constexpr int kFirstOfHands = 20;  // wrists, hands and all that hangs on them
  constexpr double kSoftness = 1, kOfHands = 0.1;
  Eigen::VectorXd softness = Eigen::VectorXd::Constant(model.template_vertices.rows(), kSoftness);
  for (Eigen::Index v = 0; v < softness.size(); ++v)
    for (SkinWeights::InnerIterator w(model.weights, v); w; ++w) {
      int joint = static_cast<int>(w.col());
      while (joint >= body::kJoints) joint = model.parents[joint];
      if (joint >= kFirstOfHands) softness[v] -= (kSoftness - kOfHands) * w.value();
    }
  return softness;
}

Points3 t_pose(const body::BodyModel& model) {
  const Eigen::VectorXd mean = Eigen::VectorXd::Zero(model.shape_directions.size());
  return body::pose_body(model, body::shape_body(model, mean), body::Pose{});
}

}  // namespace

BodyOpener::BodyOpener(const body::BodyModel& model)
    : faces_(model.faces),
      vertices_(t_pose(model)),
      part_(parts_of(model)),
      softness_(softness_of(model)),
      neighbours_(vertex_neighbours(faces_, vertices_.rows())) {
  normals_.resize(vertices_.rows(), 3);
  apart_.resize(part_.size(), kParts);
  constexpr double kFar = 0.1;
  for (int q = 0; q < kParts; ++q) {
    std::vector<int> mine;
    for (int f = 0; f < faces_.rows(); ++f)
      if (part_[faces_(f, 0)] == q && part_[faces_(f, 1)] == q && part_[faces_(f, 2)] == q)
        mine.push_back(f);
    part_faces_.push_back(faces_(mine, Eigen::all));
    parts_.emplace_back(vertices_, part_faces_.back());
    for (size_t v = 0; v < part_.size(); ++v) {
      const ClosestPoint nearest = parts_[q].closest(vertices_.row(v).transpose(), kFar);
      apart_(v, q) =
          static_cast<float>(nearest.face < 0 ? kFar : std::sqrt(nearest.squared_distance));
    }
  }
}

// Not all vertices move; those of other parts, and normals elsewhere, are as they were.
void BodyOpener::refit(const Points3& vertices, const std::vector<char>& has_moved) {
  std::vector<char> is_asked = has_moved;
  std::array<bool, kParts> is_touched = {};
  for (size_t v = 0; v < has_moved.size(); ++v) {
    if (!has_moved[v]) continue;
    is_touched[part_[v]] = true;
    for (int n : neighbours_[v]) is_asked[n] = 1;
  }
  vertices_ = vertices;
  update_vertex_normals(vertices_, faces_, is_asked, normals_);
  for (int q = 0; q < kParts; ++q)
    if (is_touched[q]) parts_[q].refit(vertices_);
}

// Two parts that lack room share what is lacking by how soft they are.
Points3 BodyOpener::press(const std::vector<int>& vertices, double max_distance) const {
  Points3 moves = Points3::Zero(vertices_.rows(), 3);
  for (int v : vertices) {
    const Vec<3> place = vertices_.row(v).transpose(), normal = normals_.row(v).transpose();
    double most = 0;
    for (int q = 0; q < kParts; ++q) {
      if (q == part_[v] || apart_(v, q) < kJoined / 2) continue;
      const ClosestPoint nearest = parts_[q].closest(place, max_distance);
      if (nearest.face < 0) continue;
      Vec<3> outward = Vec<3>::Zero();
      double other = 0, softness = 0;
      for (int c = 0; c < 3; ++c) {
        const int corner = part_faces_[q](nearest.face, c);
        outward += nearest.barycentric[c] * normals_.row(corner).transpose();
        other += nearest.barycentric[c] * apart_(corner, part_[v]);
        softness += nearest.barycentric[c] * softness_[corner];
      }
      outward.normalize();
      const double apart = std::min<double>(apart_(v, q), other);
      const double opposed = std::clamp(-2 * normal.dot(outward), 0.0, 1.0);
      const double joined = std::clamp(2 * apart / kJoined - 1, 0.0, 1.0);
      const double lack = std::min(kGap, kSlope * apart) - outward.dot(place - nearest.point);
      const double share = softness_[v] / (softness_[v] + softness);
      const double push = share * opposed * joined * lack;
      if (push <= most) continue;
      most = push;
      moves.row(v) = push * outward.transpose();
    }
  }
  return moves;
}

Points3 BodyOpener::open(const Eigen::Ref<const Points3>& posed) {
  refit(posed, std::vector<char>(part_.size(), 1));
  std::vector<int> active(part_.size());
  std::iota(active.begin(), active.end(), 0);
  for (int round = 0; round < kRounds; ++round) {
    // What lies deep is reached from where the parts touch, ring by ring.
    Points3 moves = press(active, round == 0 ? kGap : kDeepest);
    std::vector<int> around;
    std::vector<char> is_around(part_.size(), 0);
    for (int v : active)
      if (!moves.row(v).isZero(0)) is_around[v] = 1, around.push_back(v);
    if (around.empty()) break;
    for (int ring = 0; ring < kRings; ++ring)
      for (size_t i = 0, count = around.size(); i < count; ++i)
        for (int n : neighbours_[around[i]])
          if (!is_around[n]) is_around[n] = 1, around.push_back(n);
    for (int pass = 0; pass < kRings; ++pass) {
      const Points3 before = moves;
      for (int v : around) {
        Vec<3> mean = Vec<3>::Zero();
        for (int n : neighbours_[v]) mean += before.row(n).transpose();
        mean /= static_cast<double>(neighbours_[v].size());
        moves.row(v) = 0.5 * (before.row(v) + mean.transpose());
      }
    }
    refit(vertices_ + moves, is_around);
    active = std::move(around);
    std::sort(active.begin(), active.end());
  }
  return vertices_;
}

}  // namespace pleat::sim
