// The collider: the posed body, its smooth normals, and the parts of it that cloth may ignore.
//
// A posed body passes through itself (armpit, inner arm on torso, thighs). Faces that lie inside
// the body or cross another part of it are switched off: no cloth can satisfy both sides there, and
// nobody can see it.
#pragma once

#include <vector>

#include "body/body_model.h"
#include "core/proximity.h"
#include "core/types.h"

namespace pleat::sim {

class BodyCollider {
 public:
  // part: of each face, 0 .. ; cloth between two parts feels both. Empty: all is one part.
  BodyCollider(const Eigen::Ref<const Points3>& vertices, const Faces& faces,
               std::vector<int> part = {});
  void move_to(const Eigen::Ref<const Points3>& vertices);

  const SurfaceTree& tree() const { return tree_; }
  const Points3& vertices() const { return tree_.vertices(); }
  const Faces& faces() const { return tree_.faces(); }
  // Outward unit normal at a point of a face, blended from the vertex normals.
  Vec<3> normal(int face, const Vec<3>& barycentric) const;
  Vec<3> point(int face, const Vec<3>& barycentric) const;
  const std::vector<char>& is_active() const { return is_active_; }  // a face
  // Faces that are switched off or lie within a cloth edge's length of one that is: what cloth does
  // there is not held against it.
  const std::vector<char>& is_near_overlap() const { return is_near_overlap_; }
  int part_count() const { return static_cast<int>(is_active_in_part_.size()); }
  int part(int face) const { return part_[face]; }
  const std::vector<char>& is_active_in(int part) const { return is_active_in_part_[part]; }

 private:
  void switch_off_overlaps();
  void find_rim();

  SurfaceTree tree_;
  std::vector<std::vector<int>> faces_of_vertex_;
  Points3 normals_;
  std::vector<char> is_active_, is_near_overlap_;
  std::vector<int> part_;
  std::vector<std::vector<char>> is_active_in_part_;
};

// Trunk with head, arms and legs, by the joint that moves most of each face.
std::vector<int> body_parts(const body::BodyModel& model);

}  // namespace pleat::sim
