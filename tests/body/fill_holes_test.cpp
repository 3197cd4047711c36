#include "body/fill_holes.h"

#include <gtest/gtest.h>

#include "core/mesh.h"
#include "tests/body/synthetic_body.h"
#include "tests/core/input_error.h"

namespace pleat::body {
namespace {

Faces without(const Faces& faces, const std::vector<int>& gone) {
  Faces rest(faces.rows() - static_cast<Eigen::Index>(gone.size()), 3);
  int count = 0;
  for (int f = 0; f < faces.rows(); ++f) {
    if (std::find(gone.begin(), gone.end(), f) == gone.end()) rest.row(count++) = faces.row(f);
  }
  return rest;
}

TEST(FillHoles, ClosesWhatWasTakenOut) {
  const TriangleMesh box = box_mesh(2);
  std::vector<int> ring;  // all faces round vertex 20, a hole with several corners
  for (int f = 0; f < box.faces.rows(); ++f) {
    if ((box.faces.row(f).array() == 20).any()) ring.push_back(f);
  }
  ASSERT_GE(ring.size(), 4u);
  Faces open = without(box.faces, ring);
  const auto loops = boundary_loops(open);
  ASSERT_EQ(loops.size(), 1u);
  EXPECT_EQ(loops[0].size(), ring.size());
  open = joined(open, fill_hole(box.vertices, open, loops[0]));
  const Topology t = topology(open, static_cast<int>(box.vertices.rows()));
  EXPECT_TRUE(t.is_watertight());
}

TEST(FillHoles, ClosedSurfaceHasNoLoops) { EXPECT_TRUE(boundary_loops(box_mesh(1).faces).empty()); }

// The square's one diagonal exists on the other side: only the second diagonal is left.
TEST(FillHoles, NeverDoublesAnEdge) {
  Points3 corners(4, 3);
  corners << 0, 0, 0, 2, 0, 0, 2, 1, 0, -1, 1, 0.1;  // 0-2 is the shorter diagonal
  Faces back(2, 3);
  back << 0, 2, 1, 0, 3, 2;
  const auto loops = boundary_loops(back);
  ASSERT_EQ(loops.size(), 1u);
  const Faces closed = joined(back, fill_hole(corners, back, loops[0]));
  EXPECT_TRUE(topology(closed, 4).is_watertight());
}

TEST(FillHoles, RefusesOpeningsThatTouch) {
  const TriangleMesh box = box_mesh(2);
  std::vector<int> round_20;
  for (int f = 0; f < box.faces.rows(); ++f) {
    if ((box.faces.row(f).array() == 20).any()) round_20.push_back(f);
  }
  int apart = -1;  // shares vertex 20 with the first, and no edge
  for (int f : round_20) {
    int shared = 0;
    for (int c = 0; c < 3; ++c) {
      shared += (box.faces.row(f).array() == box.faces(round_20[0], c)).any();
    }
    if (shared == 1) apart = f;
  }
  ASSERT_GE(apart, 0);
  EXPECT_INPUT_ERROR(boundary_loops(without(box.faces, {round_20[0], apart})), "meet in vertex 20");
}

}  // namespace
}  // namespace pleat::body
