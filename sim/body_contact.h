// The collider: the posed body as a smooth surface that cloth rests on, and as a mesh that it never
// crosses.
//
// The smooth surface is where a blend of quadrics vanishes: at each vertex of the body one that
// osculates the surface there, blended by weights of distance (Ohtake et al. 2003, "Multi-level
// Partition of Unity Implicits"). It is twice differentiable, where distance to the mesh itself
// has kinks along every edge at which a solver would cycle. docs/derivations/contact.md.
//
// Where the posed body passes through itself (the crease of an elbow), the faces that cross others or
// lie inside are switched off: cloth there meets nothing. What is folded in the pose of construction
// too (lips, between fingers) stays on: no cloth gets there. docs/solver.md tells why.
#pragma once

#include <vector>

#include "core/proximity.h"
#include "core/types.h"

namespace pleat::sim {

// Signed distance phi to the smooth surface at one place, positive outside.
struct BodyField {
  double phi = 0;   // m
  Vec<3> gradient = Vec<3>::Zero();  // 1, about the outward unit normal
  Mat<3> hessian = Mat<3>::Zero();   // 1/m, positive where the body is convex
};

class BodyCollider {
 public:
  // vertices: in a pose in which no parts touch (the T-pose): what belongs together is read off it.
  BodyCollider(const Eigen::Ref<const Points3>& vertices, const Faces& faces);
  void move_to(const Eigen::Ref<const Points3>& vertices);
  // The same where is_off = overlaps(posed) is known.
  void move_to(const SurfaceTree& posed, const std::vector<char>& is_off);

  const SurfaceTree& tree() const { return tree_; }
  // Of each face of a body in this pose: whether it is switched off.
  std::vector<char> overlaps(const SurfaceTree& posed) const;
  const std::vector<char>& is_off() const { return is_off_; }  // the same, of the pose it stands in
  // Whether neither the face nor one that shares a corner with it is off: no cloth may cross it.
  bool is_clear(int face) const;
  // 0 on faces that are switched off, rising to 1 over the faces next to them.
  double share_on(int face, const Vec<3>& barycentric) const;
  const Points3& vertices() const { return tree_.vertices(); }
  const Faces& faces() const { return tree_.faces(); }
  Vec<3> point(int face, const Vec<3>& barycentric) const;
  // Outward unit normal, blended from the vertex normals.
  Vec<3> normal(int face, const Vec<3>& barycentric) const;

  // The smooth surface around `face`, of what faces the same way as `normal`, for x nearby. Where it
  // ends phi fades to `beyond`, m. order: 0 phi, 1 and its gradient, 2 and its Hessian.
  BodyField field(int face, const Vec<3>& normal, const Vec<3>& x, double beyond, int order) const;

 private:
  void stand(const std::vector<char>& is_off);  // tree_ being there
  void fit_quadrics();
  std::vector<char> folded(const SurfaceTree& posed) const;

  SurfaceTree tree_;
  std::vector<std::array<int, 2>> edges_;
  std::vector<std::vector<int>> faces_of_vertex_;
  std::vector<char> is_off_, is_always_folded_;
  Eigen::VectorXd on_;  // of the vertices, 0 or 1
  Eigen::VectorXd support_;         // m, of each vertex: how far its quadric reaches
  std::vector<int> start_, near_;   // of each face: vertices whose quadrics may reach what lies on it
  Points3 normals_;                 // of the vertices
  struct Quadric {  // of each vertex, all that the field needs in one place
    Vec<3> point;
    double inverse_support;  // squared, 1/m^2
    Vec<3> normal;
    Mat<3> curvature;  // 1/m, tangential
  };
  std::vector<Quadric> quadrics_;
};

}  // namespace pleat::sim
