#include "evaluate/plausibility.h"

#include <gtest/gtest.h>

#include "tests/encode/synthetic_body.h"

namespace pleat::evaluate {
namespace {

struct Worn {
  encode::Tube tube = encode::make_tube(16, 32);
  garment::Garment garment = encode::tube_garment(tube, {});
  body::BodyModel model = encode::column_body();
  SurfaceTree body{model.template_vertices, model.faces};

  Points3 scaled(double radius) const {  // the tube at this radius, kept off the column's flat ends
    Points3 vertices = garment.t_pose;
    vertices.col(0) *= radius / 0.2;
    vertices.col(2) *= radius / 0.2;
    vertices.col(1) = 0.1 + 0.75 * vertices.col(1).array();
    return vertices;
  }
};

TEST(Plausibility, OfATubeRoundTheBodyIsClean) {
  const Worn worn;
  const Plausibility result = plausibility(worn.garment, worn.scaled(0.2), worn.body, 0.1);
  EXPECT_EQ(result.inside_share, 0);
  EXPECT_EQ(result.max_depth_mm, 0);
  EXPECT_EQ(result.body_intersections, 0);
}

TEST(Plausibility, SeesATubeInsideTheBody) {
  const Worn worn;
  const Plausibility result = plausibility(worn.garment, worn.scaled(0.1), worn.body, 0.1);
  EXPECT_EQ(result.inside_share, 1);
  // The column has twelve sides: their distance from the axis runs from 0.15 cos(15 deg) to 0.15 m.
  EXPECT_GT(result.mean_depth_mm, 1000 * (0.15 * std::cos(M_PI / 12) - 0.1) - 1);
  EXPECT_LT(result.mean_depth_mm, 50);
  EXPECT_GE(result.max_depth_mm, result.mean_depth_mm);
  EXPECT_EQ(result.body_intersections, 0);
}

TEST(Plausibility, CountsClothFacesThatCrossTheBody) {
  const Worn worn;
  Points3 vertices = worn.scaled(0.2);
  vertices.row(16 * 17 + 8).setZero();  // one vertex of the front, pulled to the axis
  vertices(16 * 17 + 8, 1) = 0.4;
  const Plausibility result = plausibility(worn.garment, vertices, worn.body, 0.2);
  EXPECT_NEAR(result.inside_share * worn.garment.topology.vertex_count, 1, 1e-9);
  EXPECT_EQ(result.body_intersections, 6);  // the faces round that vertex
  EXPECT_GT(result.strain.max, 1);
}

TEST(Plausibility, MeasuresStrainAgainstTheFlatPanels) {
  const Worn worn;
  const Plausibility rest = plausibility(worn.garment, worn.garment.t_pose, worn.body, 0.1);
  // Chords of a circle are shorter than its arcs: 1 - sin(x) / x at x = pi / 32 and the jitter's
  // share.
  EXPECT_LT(rest.strain.percentile_95, 0.01);
  Points3 stretched = worn.garment.t_pose;
  stretched.col(1) *= 1.1;
  EXPECT_NEAR(plausibility(worn.garment, stretched, worn.body, 0.1).strain.percentile_95, 0.1,
              0.01);
}

}  // namespace
}  // namespace pleat::evaluate
