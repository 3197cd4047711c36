// Closest points and overlaps between meshes, over the trees that FCL builds (only user of FCL and
// libccd).
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "core/types.h"

namespace pleat {

struct ClosestPoint {
  int face = -1;                // -1: nothing within the distance asked for
  Vec<3> barycentric;           // of the closest point, on `face`
  Vec<3> point;                 // m
  double squared_distance = 0;  // m^2
};

// A triangle surface that moves but keeps its faces. The tree's topology is built once, its boxes
// are refitted.
class SurfaceTree {
 public:
  SurfaceTree(const Eigen::Ref<const Points3>& vertices, const Faces& faces);
  ~SurfaceTree();
  SurfaceTree(SurfaceTree&&) noexcept;

  void refit(const Eigen::Ref<const Points3>& vertices);
  // Exact closest point within max_distance (m); face -1 where there is none. Safe to call from
  // many threads. Own descent over FCL's BVHModel<AABB> nodes; FCL's own point queries are inexact
  // (docs/architecture.md).
  ClosestPoint closest(const Vec<3>& query, double max_distance) const;
  // The same over faces for which is_allowed[face] is non-zero.
  ClosestPoint closest(const Vec<3>& query, double max_distance,
                       const std::vector<char>& is_allowed) const;

  const Points3& vertices() const;
  const Faces& faces() const;

 private:
  friend std::vector<std::array<int, 2>> intersecting_faces(const SurfaceTree&, const SurfaceTree&);
  friend std::vector<std::array<int, 2>> self_intersecting_faces(const SurfaceTree&);

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Pairs (face of a, face of b) whose triangles cross or touch, ascending. Exact test by own
// predicates on FCL's candidates.
std::vector<std::array<int, 2>> intersecting_faces(const SurfaceTree& a, const SurfaceTree& b);
// Pairs within one surface, each once with the lower index first; pairs that share a vertex are
// left out.
std::vector<std::array<int, 2>> self_intersecting_faces(const SurfaceTree& a);

// Closest point of triangle (a, b, c) to p, as barycentric coordinates.
Vec<3> closest_on_triangle(const Vec<3>& p, const Vec<3>& a, const Vec<3>& b, const Vec<3>& c);

// How often a ray from each query crosses the closed surface, as inside or outside (odd or even),
// by generalized winding number > 1/2 (Jacobson et al. 2013). A body that overlaps itself counts as
// inside where the number is >= 1/2. result[i] is the winding number of query i.
Eigen::VectorXd winding_numbers(const SurfaceTree& surface,
                                const Eigen::Ref<const Points3>& queries);

}  // namespace pleat
