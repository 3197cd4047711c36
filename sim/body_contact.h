// The collider: the posed body, its smooth normals, and the parts of it that cloth may ignore.
//
// A posed body passes through itself (armpit, inner arm on torso, thighs). Faces that lie inside
// the body or cross another part of it are switched off: no cloth can satisfy both sides there, and
// nobody can see it.
#pragma once

#include <vector>

#include "core/proximity.h"
#include "core/types.h"

namespace pleat::sim {

class BodyCollider {
 public:
  BodyCollider(const Eigen::Ref<const Points3>& vertices, const Faces& faces);
  void move_to(const Eigen::Ref<const Points3>& vertices);

  const SurfaceTree& tree() const { return tree_; }
  const Points3& vertices() const { return tree_.vertices(); }
  const Faces& faces() const { return tree_.faces(); }
  // Outward unit normal at a point of a face, blended from the vertex normals.
  Vec<3> normal(int face, const Vec<3>& barycentric) const;
  Vec<3> point(int face, const Vec<3>& barycentric) const;
  const std::vector<char>& is_active() const { return is_active_; }  // a face

 private:
  void switch_off_overlaps();

  SurfaceTree tree_;
  std::vector<std::vector<int>> faces_of_vertex_;
  Points3 normals_;
  std::vector<char> is_active_;
};

}  // namespace pleat::sim
