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
  friend class SweptTree;

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Boxes around the faces of a surface whose vertices are somewhere near or on the move, over the
// tree that FCL built for it.
class SweptTree {
 public:
  explicit SweptTree(const SurfaceTree& surface);

  // Vertex v lies within reach[v] (m) of a point that runs straight from row v of `vertices` to row
  // v of vertices + motion. An empty motion: all stay.
  void refit(const Eigen::Ref<const Points3>& vertices, const Eigen::VectorXd& reach,
             const Points3& motion);
  // Pairs of faces neither of which is marked are of no interest. Empty: all are, as at first.
  void mark(const std::vector<char>& faces);

 private:
  friend std::vector<std::array<int, 2>> meeting_faces(const SweptTree&, const SweptTree&);
  friend std::vector<std::array<int, 2>> meeting_faces(const SweptTree&);

  // Children lie behind their parent, next to each other. Bounds are rounded outwards.
  struct Node {
    float low[3], high[3];  // box at the start
    int child = -1;         // the left one; -1: a leaf
    int face = -1;
  };
  struct Motion {
    float low[3], high[3];
  };
  template <bool kMoves>
  bool may_meet(int i, const SweptTree& other, int j) const;
  template <bool kMoves>
  void descend(const SweptTree& other, std::vector<std::array<int, 2>>& pairs) const;

  Faces faces_;
  std::vector<Node> nodes_;
  std::vector<Motion> motions_;  // of each node; empty where all stay
  std::vector<char> is_marked_;  // of each node: whether a face below it is
};

// Pairs (face of a, face of b) that may meet while all vertices run through their motions at the
// same pace, at least one of them marked; all pairs that do are among them. In an order that
// depends on the trees only.
std::vector<std::array<int, 2>> meeting_faces(const SweptTree& a, const SweptTree& b);
// Pairs within one surface, each once, neighbours included.
std::vector<std::array<int, 2>> meeting_faces(const SweptTree& a);

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
