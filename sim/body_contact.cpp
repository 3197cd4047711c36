#include "sim/body_contact.h"

#include <algorithm>
#include <array>

#include "core/mesh.h"

namespace pleat::sim {
namespace {

constexpr double kOutsideStep =
    0.0005;  // m: how far off the surface a vertex is asked whether it lies inside the body

constexpr double kRim = 0.02;  // m: an edge of coarse cloth

}  // namespace

BodyCollider::BodyCollider(const Eigen::Ref<const Points3>& vertices, const Faces& faces,
                           std::vector<int> part)
    : tree_(vertices, faces), faces_of_vertex_(vertices.rows()), part_(std::move(part)) {
  if (part_.empty()) part_.assign(faces.rows(), 0);
  is_active_in_part_.resize(1 + *std::max_element(part_.begin(), part_.end()));
  for (int f = 0; f < faces.rows(); ++f)
    for (int c = 0; c < 3; ++c) faces_of_vertex_[faces(f, c)].push_back(f);
  move_to(vertices);
}

void BodyCollider::move_to(const Eigen::Ref<const Points3>& vertices) {
  tree_.refit(vertices);
  normals_ = vertex_normals(vertices, faces());
  switch_off_overlaps();
  find_rim();
  for (int p = 0; p < part_count(); ++p) {
    is_active_in_part_[p] = is_active_;
    for (size_t f = 0; f < part_.size(); ++f)
      if (part_[f] != p) is_active_in_part_[p][f] = 0;
  }
}

Vec<3> BodyCollider::normal(int face, const Vec<3>& barycentric) const {
  Vec<3> blend = Vec<3>::Zero();
  for (int c = 0; c < 3; ++c) blend += barycentric[c] * normals_.row(faces()(face, c)).transpose();
  return blend.normalized();
}

Vec<3> BodyCollider::point(int face, const Vec<3>& barycentric) const {
  Vec<3> blend = Vec<3>::Zero();
  for (int c = 0; c < 3; ++c)
    blend += barycentric[c] * vertices().row(faces()(face, c)).transpose();
  return blend;
}

// Spreads from the faces that cross one another over the vertices that lie inside the body.
void BodyCollider::switch_off_overlaps() {
  is_active_.assign(faces().rows(), 1);
  std::vector<char> is_asked(vertices().rows(), 0);
  std::vector<int> front;
  const auto ask_corners = [&](int face) {
    is_active_[face] = 0;
    for (int c = 0; c < 3; ++c) {
      const int v = faces()(face, c);
      if (!is_asked[v]) front.push_back(v);
      is_asked[v] = 1;
    }
  };
  for (const auto& [a, b] : self_intersecting_faces(tree_)) {
    ask_corners(a);
    ask_corners(b);
  }
  while (!front.empty()) {
    Points3 queries(front.size(), 3);
    for (size_t i = 0; i < front.size(); ++i)
      queries.row(i) = vertices().row(front[i]) + kOutsideStep * normals_.row(front[i]);
    const Eigen::VectorXd winding = winding_numbers(tree_, queries);
    std::vector<int> inside;
    for (size_t i = 0; i < front.size(); ++i)
      if (winding[i] > 0.5) inside.push_back(front[i]);
    front.clear();
    for (int v : inside)
      for (int face : faces_of_vertex_[v]) ask_corners(face);
  }
}

void BodyCollider::find_rim() {
  is_near_overlap_.assign(faces().rows(), 0);
  Points3 off(3 * faces().rows(), 3);  // corners of the faces that are switched off
  Eigen::Index count = 0;
  for (Eigen::Index f = 0; f < faces().rows(); ++f)
    for (int c = 0; c < 3 && !is_active_[f]; ++c) off.row(count++) = vertices().row(faces()(f, c));
  if (count == 0) return;
  const Vec<3> low = off.topRows(count).colwise().minCoeff(),
               high = off.topRows(count).colwise().maxCoeff();
  std::vector<char> is_near(vertices().rows(), 0);
  for (Eigen::Index v = 0; v < vertices().rows(); ++v) {
    const Vec<3> x = vertices().row(v);
    if ((x.array() < low.array() - kRim).any() || (x.array() > high.array() + kRim).any()) continue;
    is_near[v] = (off.topRows(count).rowwise() - x.transpose()).rowwise().squaredNorm().minCoeff() <
                 kRim * kRim;
  }
  for (Eigen::Index f = 0; f < faces().rows(); ++f)
    is_near_overlap_[f] = !is_active_[f] || is_near[faces()(f, 0)] || is_near[faces()(f, 1)] ||
                          is_near[faces()(f, 2)];
}

std::vector<int> body_parts(const body::BodyModel& model) {
  enum { kTrunk, kLeftArm, kRightArm, kLeftLeg, kRightLeg };
  constexpr std::array<int, body::kJoints> kPartOfJoint = {
      kTrunk,    kLeftLeg,  kRightLeg, kTrunk,    kLeftLeg, kRightLeg, kTrunk,   kLeftLeg,
      kRightLeg, kTrunk,    kLeftLeg,  kRightLeg, kTrunk,   kTrunk,    kTrunk,   kTrunk,
      kLeftArm,  kRightArm, kLeftArm,  kRightArm, kLeftArm, kRightArm, kLeftArm, kRightArm};
  std::vector<int> parts(model.faces.rows());
  for (Eigen::Index f = 0; f < model.faces.rows(); ++f) {
    std::array<double, 5> weight = {};
    for (int c = 0; c < 3; ++c)
      for (SkinWeights::InnerIterator w(model.weights, model.faces(f, c)); w; ++w) {
        int joint = static_cast<int>(w.col());
        while (joint >= body::kJoints) joint = model.parents[joint];
        weight[kPartOfJoint[joint]] += w.value();
      }
    parts[f] = static_cast<int>(std::max_element(weight.begin(), weight.end()) - weight.begin());
  }
  return parts;
}

}  // namespace pleat::sim
