#include "core/proximity.h"

// clang-format off: the model below uses fit() from the first header without including it
#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/math/bv/utility.h>
// clang-format on

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "core/exact_predicates.h"

namespace pleat {
namespace {

using Box = fcl::AABB<double>;
using FclNode = fcl::BVNode<Box>;
using Tree = fcl::BVHModel<Box>;
using Pairs = std::vector<std::array<int, 2>>;

std::vector<Vec<3>> point_list(const Eigen::Ref<const Points3>& points) {
  std::vector<Vec<3>> list(points.rows());
  for (int v = 0; v < points.rows(); ++v) list[v] = points.row(v);
  return list;
}

std::array<Vec<3>, 3> corners(const Points3& vertices, const Faces& faces, int f) {
  return {vertices.row(faces(f, 0)), vertices.row(faces(f, 1)), vertices.row(faces(f, 2))};
}

double squared_distance(const Vec<3>& p, const Box& box) {
  double sum = 0;
  for (int k = 0; k < 3; ++k) {
    const double beyond = std::max(std::max(box.min_[k] - p[k], p[k] - box.max_[k]), 0.0);
    sum += beyond * beyond;
  }
  return sum;
}

// Branch and bound: the nearer child first, and none that lies beyond the best face so far.
struct ClosestSearch {
  const Tree& tree;
  const Points3& vertices;
  const Faces& faces;
  const char* is_allowed;  // null: all are
  const Vec<3> query;
  ClosestPoint best;

  void descend(const FclNode& node) {
    if (node.isLeaf()) {
      visit(node.primitiveId());
      return;
    }
    const FclNode* near = &tree.getBV(node.leftChild());
    const FclNode* far = &tree.getBV(node.rightChild());
    double near_distance = squared_distance(query, near->bv);
    double far_distance = squared_distance(query, far->bv);
    if (far_distance < near_distance) {
      std::swap(near, far);
      std::swap(near_distance, far_distance);
    }
    if (near_distance <= best.squared_distance) descend(*near);
    if (far_distance <= best.squared_distance) descend(*far);
  }

  // Among equally near faces the lowest index wins, whatever the shape of the tree.
  void visit(int face) {
    if (is_allowed != nullptr && !is_allowed[face]) return;
    const auto [a, b, c] = corners(vertices, faces, face);
    const Vec<3> barycentric = closest_on_triangle(query, a, b, c);
    const Vec<3> point = barycentric[0] * a + barycentric[1] * b + barycentric[2] * c;
    const double distance = (point - query).squaredNorm();
    if (distance < best.squared_distance ||
        (distance == best.squared_distance &&
         static_cast<unsigned>(face) < static_cast<unsigned>(best.face))) {
      best = {face, barycentric, point, distance};
    }
  }
};

// Leaves of two trees (or of two parts of one) whose boxes overlap.
void overlapping_leaves(const Tree& a, const FclNode& a_node, const Tree& b, const FclNode& b_node,
                        Pairs& pairs) {
  if (!a_node.bv.overlap(b_node.bv)) return;
  if (a_node.isLeaf() && b_node.isLeaf()) {
    pairs.push_back({a_node.primitiveId(), b_node.primitiveId()});
  } else if (b_node.isLeaf() || (!a_node.isLeaf() && a_node.bv.size() > b_node.bv.size())) {
    overlapping_leaves(a, a.getBV(a_node.leftChild()), b, b_node, pairs);
    overlapping_leaves(a, a.getBV(a_node.rightChild()), b, b_node, pairs);
  } else {
    overlapping_leaves(a, a_node, b, b.getBV(b_node.leftChild()), pairs);
    overlapping_leaves(a, a_node, b, b.getBV(b_node.rightChild()), pairs);
  }
}

void overlapping_leaves(const Tree& tree, const FclNode& node, Pairs& pairs) {
  if (node.isLeaf()) return;
  const FclNode& left = tree.getBV(node.leftChild());
  const FclNode& right = tree.getBV(node.rightChild());
  overlapping_leaves(tree, left, pairs);
  overlapping_leaves(tree, right, pairs);
  overlapping_leaves(tree, left, tree, right, pairs);
}

bool has_shared_vertex(const Faces& faces, int f, int g) {
  for (int k = 0; k < 3; ++k) {
    if ((faces.row(g).array() == faces(f, k)).any()) return true;
  }
  return false;
}

Vec<3> closest_on_edges(const Vec<3>& p, const std::array<Vec<3>, 3>& corners) {
  Vec<3> best = Vec<3>::Zero();
  double best_distance = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const int next = (k + 1) % 3;
    const Vec<3> edge = corners[next] - corners[k];
    const double length = edge.squaredNorm();
    const double t = length > 0 ? std::clamp((p - corners[k]).dot(edge) / length, 0.0, 1.0) : 0.0;
    const double distance = (corners[k] + t * edge - p).squaredNorm();
    if (distance < best_distance) {
      best_distance = distance;
      best.setZero();
      best[k] = 1 - t;
      best[next] = t;
    }
  }
  return best;
}

}  // namespace

struct SurfaceTree::Impl {
  Points3 vertices;
  Faces faces;
  Tree tree;
};

SurfaceTree::SurfaceTree(const Eigen::Ref<const Points3>& vertices, const Faces& faces)
    : impl_(std::make_unique<Impl>()) {
  impl_->vertices = vertices;
  impl_->faces = faces;
  if (faces.rows() == 0) return;
  std::vector<fcl::Triangle> triangles;
  for (int f = 0; f < faces.rows(); ++f) {
    triangles.emplace_back(faces(f, 0), faces(f, 1), faces(f, 2));
  }
  impl_->tree.beginModel(static_cast<int>(faces.rows()), static_cast<int>(vertices.rows()));
  impl_->tree.addSubModel(point_list(vertices), triangles);
  impl_->tree.endModel();
}

SurfaceTree::~SurfaceTree() = default;
SurfaceTree::SurfaceTree(SurfaceTree&&) noexcept = default;

// beginReplaceModel keeps the tree; beginUpdateModel would sweep the boxes from pose to pose.
void SurfaceTree::refit(const Eigen::Ref<const Points3>& vertices) {
  assert(vertices.rows() == impl_->vertices.rows());
  impl_->vertices = vertices;
  if (impl_->faces.rows() == 0) return;
  impl_->tree.beginReplaceModel();
  impl_->tree.replaceSubModel(point_list(vertices));
  impl_->tree.endReplaceModel(/*refit=*/true, /*bottomup=*/true);
}

ClosestPoint SurfaceTree::closest(const Vec<3>& query, double max_distance) const {
  return closest(query, max_distance, {});
}

ClosestPoint SurfaceTree::closest(const Vec<3>& query, double max_distance,
                                  const std::vector<char>& is_allowed) const {
  assert(is_allowed.empty() || static_cast<Eigen::Index>(is_allowed.size()) == faces().rows());
  ClosestSearch search{impl_->tree,  impl_->vertices,
                       impl_->faces, is_allowed.empty() ? nullptr : is_allowed.data(),
                       query,        {}};
  search.best.squared_distance = max_distance * max_distance;
  if (impl_->faces.rows() > 0) search.descend(impl_->tree.getBV(0));
  return search.best;
}

const Points3& SurfaceTree::vertices() const { return impl_->vertices; }
const Faces& SurfaceTree::faces() const { return impl_->faces; }

SweptTree::SweptTree(const SurfaceTree& surface) : faces_(surface.faces()) {
  if (faces_.rows() == 0) return;
  const Tree& tree = surface.impl_->tree;
  nodes_.resize(tree.getNumBVs());
  is_marked_.assign(nodes_.size(), 1);
  for (size_t i = 0; i < nodes_.size(); ++i) {
    const FclNode& leaf = tree.getBV(static_cast<int>(i));
    nodes_[i].child = leaf.isLeaf() ? -1 : leaf.leftChild();
    nodes_[i].face = leaf.isLeaf() ? leaf.primitiveId() : -1;
    assert(leaf.isLeaf() ||
           (leaf.leftChild() > static_cast<int>(i) && leaf.rightChild() == leaf.leftChild() + 1));
  }
}

namespace {

// The next float outwards, so that rounding never makes a box smaller.
float below(double x) {
  const float f = static_cast<float>(x);
  return f <= x ? f : std::nextafter(f, -std::numeric_limits<float>::infinity());
}
float above(double x) {
  const float f = static_cast<float>(x);
  return f >= x ? f : std::nextafter(f, std::numeric_limits<float>::infinity());
}

}  // namespace

void SweptTree::refit(const Eigen::Ref<const Points3>& vertices, const Eigen::VectorXd& reach,
                      const Points3& motion) {
  assert(reach.size() == vertices.rows());
  const bool moves = motion.rows() > 0;
  motions_.resize(moves ? nodes_.size() : 0);
  for (int i = static_cast<int>(nodes_.size()) - 1; i >= 0; --i) {
    Node& node = nodes_[i];
    if (node.child < 0) {
      const int a = faces_(node.face, 0), b = faces_(node.face, 1), c = faces_(node.face, 2);
      const double r[3] = {reach[a], reach[b], reach[c]};
      for (int k = 0; k < 3; ++k) {
        const double x[3] = {vertices(a, k), vertices(b, k), vertices(c, k)};
        node.low[k] = below(std::min({x[0] - r[0], x[1] - r[1], x[2] - r[2]}));
        node.high[k] = above(std::max({x[0] + r[0], x[1] + r[1], x[2] + r[2]}));
        if (!moves) continue;
        motions_[i].low[k] = below(std::min({motion(a, k), motion(b, k), motion(c, k)}));
        motions_[i].high[k] = above(std::max({motion(a, k), motion(b, k), motion(c, k)}));
      }
    } else {
      const Node &left = nodes_[node.child], &right = nodes_[node.child + 1];
      for (int k = 0; k < 3; ++k) {
        node.low[k] = std::min(left.low[k], right.low[k]);
        node.high[k] = std::max(left.high[k], right.high[k]);
        if (!moves) continue;
        const Motion &u = motions_[node.child], &v = motions_[node.child + 1];
        motions_[i].low[k] = std::min(u.low[k], v.low[k]);
        motions_[i].high[k] = std::max(u.high[k], v.high[k]);
      }
    }
  }
}

void SweptTree::mark(const std::vector<char>& faces) {
  for (int i = static_cast<int>(nodes_.size()) - 1; i >= 0; --i) {
    const Node& node = nodes_[i];
    is_marked_[i] = node.child >= 0 ? is_marked_[node.child] || is_marked_[node.child + 1]
                                    : faces.empty() || faces[node.face];
  }
}

// Along each axis: the smallest and the largest difference of a point of one and one of the other,
// at any time.
template <bool kMoves>
bool SweptTree::may_meet(int i, const SweptTree& other, int j) const {
  const Node &a = nodes_[i], &b = other.nodes_[j];
  for (int k = 0; k < 3; ++k) {
    float least = a.low[k] - b.high[k], most = a.high[k] - b.low[k];
    if (kMoves) {
      const Motion &u = motions_[i], &v = other.motions_[j];
      least += std::min(u.low[k] - v.high[k], 0.0f);
      most += std::max(u.high[k] - v.low[k], 0.0f);
    }
    if (least > 0 || most < 0) return false;
  }
  return true;
}

// The stack holds pairs of nodes that are still to be looked at; within one tree, a pair of a node
// with itself stands for all pairs in it.
template <bool kMoves>
void SweptTree::descend(const SweptTree& other, Pairs& pairs) const {
  const auto size = [](const Node& n) {
    return (n.high[0] - n.low[0]) + (n.high[1] - n.low[1]) + (n.high[2] - n.low[2]);
  };
  Pairs stack = {{0, 0}};
  while (!stack.empty()) {
    const auto [i, j] = stack.back();
    stack.pop_back();
    const Node &left = nodes_[i], &right = other.nodes_[j];
    if (!is_marked_[i] && !other.is_marked_[j]) continue;
    if (this == &other && i == j) {
      if (left.child < 0) continue;
      stack.push_back({left.child, left.child + 1});
      stack.push_back({left.child + 1, left.child + 1});
      stack.push_back({left.child, left.child});
      continue;
    }
    if (!may_meet<kMoves>(i, other, j)) continue;
    if (left.child < 0 && right.child < 0) {
      pairs.push_back({left.face, right.face});
    } else if (right.child < 0 || (left.child >= 0 && size(left) > size(right))) {
      stack.push_back({left.child + 1, j});
      stack.push_back({left.child, j});
    } else {
      stack.push_back({i, right.child + 1});
      stack.push_back({i, right.child});
    }
  }
}

std::vector<std::array<int, 2>> meeting_faces(const SweptTree& a, const SweptTree& b) {
  Pairs pairs;
  if (a.nodes_.empty() || b.nodes_.empty()) return pairs;
  assert(a.motions_.empty() == b.motions_.empty());
  if (a.motions_.empty())
    a.descend<false>(b, pairs);
  else
    a.descend<true>(b, pairs);
  return pairs;
}

std::vector<std::array<int, 2>> meeting_faces(const SweptTree& a) { return meeting_faces(a, a); }

std::vector<std::array<int, 2>> intersecting_faces(const SurfaceTree& a, const SurfaceTree& b) {
  Pairs pairs;
  if (a.faces().rows() == 0 || b.faces().rows() == 0) return pairs;
  const Tree &a_tree = a.impl_->tree, &b_tree = b.impl_->tree;
  overlapping_leaves(a_tree, a_tree.getBV(0), b_tree, b_tree.getBV(0), pairs);
  const auto is_apart = [&](const std::array<int, 2>& pair) {
    return !triangles_meet(corners(a.vertices(), a.faces(), pair[0]),
                           corners(b.vertices(), b.faces(), pair[1]));
  };
  pairs.erase(std::remove_if(pairs.begin(), pairs.end(), is_apart), pairs.end());
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

std::vector<std::array<int, 2>> self_intersecting_faces(const SurfaceTree& a) {
  Pairs pairs;
  if (a.faces().rows() == 0) return pairs;
  overlapping_leaves(a.impl_->tree, a.impl_->tree.getBV(0), pairs);
  const auto is_apart = [&](const std::array<int, 2>& pair) {
    return has_shared_vertex(a.faces(), pair[0], pair[1]) ||
           !triangles_meet(corners(a.vertices(), a.faces(), pair[0]),
                           corners(a.vertices(), a.faces(), pair[1]));
  };
  pairs.erase(std::remove_if(pairs.begin(), pairs.end(), is_apart), pairs.end());
  for (std::array<int, 2>& pair : pairs) std::sort(pair.begin(), pair.end());
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

// By the Voronoi regions of corners, edges and face: Ericson 2005, "Real-Time Collision Detection",
// section 5.1.5. Coordinates on a corner or an edge are exactly 0 or 1 there.
Vec<3> closest_on_triangle(const Vec<3>& p, const Vec<3>& a, const Vec<3>& b, const Vec<3>& c) {
  const Vec<3> ab = b - a, ac = c - a;
  // Flatter than rounding can tell from a segment: the edges are all there is.
  if (ab.cross(ac).squaredNorm() <= 1e-24 * ab.squaredNorm() * ac.squaredNorm()) {
    return closest_on_edges(p, {a, b, c});
  }
  const Vec<3> ap = p - a, bp = p - b, cp = p - c;
  const double ap_ab = ap.dot(ab), ap_ac = ap.dot(ac);
  if (ap_ab <= 0 && ap_ac <= 0) return {1, 0, 0};
  const double bp_ab = bp.dot(ab), bp_ac = bp.dot(ac);
  if (bp_ab >= 0 && bp_ac <= bp_ab) return {0, 1, 0};
  const double cp_ab = cp.dot(ab), cp_ac = cp.dot(ac);
  if (cp_ac >= 0 && cp_ab <= cp_ac) return {0, 0, 1};

  const double area_c = ap_ab * bp_ac - bp_ab * ap_ac;  // twice squared areas, opposite each corner
  if (area_c <= 0 && ap_ab >= 0 && bp_ab <= 0) {
    const double t = ap_ab / (ap_ab - bp_ab);
    return {1 - t, t, 0};
  }
  const double area_b = cp_ab * ap_ac - ap_ab * cp_ac;
  if (area_b <= 0 && ap_ac >= 0 && cp_ac <= 0) {
    const double t = ap_ac / (ap_ac - cp_ac);
    return {1 - t, 0, t};
  }
  const double area_a = bp_ab * cp_ac - cp_ab * bp_ac;
  const double from_b = bp_ac - bp_ab, from_c = cp_ab - cp_ac;
  if (area_a <= 0 && from_b >= 0 && from_c >= 0) {
    const double t = from_b / (from_b + from_c);
    return {0, 1 - t, t};
  }
  const double sum = area_a + area_b + area_c;
  const double v = area_b / sum, w = area_c / sum;
  return {1 - v - w, v, w};
}

// Solid angle of each triangle: van Oosterom and Strackee 1983, "The Solid Angle of a Plane
// Triangle". Half of it is the argument of a complex number, so the product of these numbers adds
// the angles up, with one arctangent at the end instead of one a triangle; whole turns are counted.
Eigen::VectorXd winding_numbers(const SurfaceTree& surface,
                                const Eigen::Ref<const Points3>& queries) {
  const Points3& vertices = surface.vertices();
  const Faces& faces = surface.faces();
  Eigen::VectorXd result(queries.rows());
#pragma omp parallel
  {
    Points3 to_vertex(vertices.rows(), 3);
    Eigen::VectorXd length(vertices.rows());
#pragma omp for schedule(static)
    for (Eigen::Index q = 0; q < queries.rows(); ++q) {
      to_vertex = vertices.rowwise() - queries.row(q);
      length = to_vertex.rowwise().norm();
      double re = 1, im = 0;  // the product so far, argument in (-pi, pi]
      int turns = 0;
      for (int f = 0; f < faces.rows(); ++f) {
        const int i = faces(f, 0), j = faces(f, 1), k = faces(f, 2);
        const Vec<3> a = to_vertex.row(i), b = to_vertex.row(j), c = to_vertex.row(k);
        const double x = length[i] * length[j] * length[k] + a.dot(b) * length[k] +
                         b.dot(c) * length[i] + c.dot(a) * length[j];
        const double y = a.dot(b.cross(c));
        const double new_re = re * x - im * y, new_im = re * y + im * x;
        const double size = std::abs(new_re) + std::abs(new_im);
        if (!(size > 0)) continue;  // the query is a corner: no angle is defined
        if (im >= 0 && y >= 0 && new_im < 0) ++turns;
        if (im < 0 && y < 0 && new_im >= 0) --turns;
        re = new_re / size;
        im = new_im / size;
      }
      result[q] = turns + std::atan2(im, re) / (2 * 3.14159265358979323846);
    }
  }
  return result;
}

}  // namespace pleat
