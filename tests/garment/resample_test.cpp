#include "garment/resample.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/core/input_error.h"

namespace pleat::garment {
namespace {

const GarmentTopology& coarse() {
  static const GarmentTopology topology = make_topology(600);
  return topology;
}
const GarmentTopology& fine() {
  static const GarmentTopology topology = make_topology(2400);
  return topology;
}

// A field on the layout, at the sewn vertices: linear on each panel, and the same on both sides of
// no seam, so only panel-inner vertices can tell.
Points3 uv_of_sewn(const GarmentTopology& topology) {
  Points3 values = Points3::Zero(topology.vertex_count, 3);
  for (Eigen::Index i = 0; i < topology.uv.rows(); ++i)
    values.row(topology.sewn_vertex[i]).head(2) = topology.uv.row(i);
  return values;
}

TEST(Locate, FindsTheVerticesOfTheTessellationItself) {
  const PanelPlaces places = locate(fine(), fine().uv);
  for (Eigen::Index i = 0; i < fine().uv.rows(); ++i) {
    Eigen::RowVector2d uv = Eigen::RowVector2d::Zero();
    for (int c = 0; c < 3; ++c)
      uv += places.barycentrics(i, c) * fine().uv.row(fine().panel_faces(places.faces[i], c));
    EXPECT_LT((uv - fine().uv.row(i)).norm(), 1e-12);
    EXPECT_EQ(fine().panel_of_vertex[fine().panel_faces(places.faces[i], 0)],
              fine().panel_of_vertex[i]);
  }
}

// Coarse outlines cut corners: the nearest place is on the same panel all the same.
TEST(Locate, StaysOnItsPanel) {
  const PanelPlaces places = locate(coarse(), fine().uv);
  for (Eigen::Index i = 0; i < fine().uv.rows(); ++i) {
    EXPECT_EQ(coarse().panel_of_vertex[coarse().panel_faces(places.faces[i], 0)],
              fine().panel_of_vertex[i]);
    EXPECT_GE(places.barycentrics.row(i).minCoeff(), 0);
    EXPECT_NEAR(places.barycentrics.row(i).sum(), 1, 1e-12);
  }
}

TEST(Locate, RefusesWhatLiesOutsideOfTheLayout) {
  Points2 uv(1, 2);
  uv << 1.2, 0.5;
  EXPECT_INPUT_ERROR(locate(coarse(), uv), "UV vertex 0");
  uv << 0.5, std::numeric_limits<double>::quiet_NaN();
  EXPECT_INPUT_ERROR(locate(coarse(), uv), "UV vertex 0");
}

TEST(Resample, OntoItselfIsTheSame) {
  const Points3 values = uv_of_sewn(fine());
  EXPECT_LT((resample(fine(), values, fine()) - values).cwiseAbs().maxCoeff(), 1e-12);
}

// Exactly, where no seam is near.
TEST(Resample, KeepsALinearField) {
  Points3 ones = Points3::Ones(coarse().vertex_count, 3);
  EXPECT_LT((resample(coarse(), ones, fine()) - Points3::Ones(fine().vertex_count, 3))
                .cwiseAbs()
                .maxCoeff(),
            1e-12);
  // The middle of the front: far from every seam.
  const Points3 values = resample(coarse(), uv_of_sewn(coarse()), fine());
  int checked = 0;
  for (Eigen::Index i = 0; i < fine().uv.rows(); ++i) {
    const Eigen::RowVector2d uv = fine().uv.row(i);
    if (fine().panel_of_vertex[i] != Panel::kFront || std::abs(uv.x() - 0.25) > 0.05 ||
        std::abs(uv.y() - 0.6) > 0.1)
      continue;
    EXPECT_LT((values.row(fine().sewn_vertex[i]).head(2) - uv).norm(), 1e-12);
    ++checked;
  }
  EXPECT_GT(checked, 10);
}

}  // namespace
}  // namespace pleat::garment
