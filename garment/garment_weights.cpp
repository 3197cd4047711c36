#include "garment/garment_weights.h"

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "body/skinning.h"
#include "core/mesh.h"
#include "core/proximity.h"

namespace pleat::garment {
namespace {

constexpr double kSpread = 6;  // smoothing lengths over distance to the body
constexpr double kLeastDistance =
    0.01;  // m: cloth on the skin is smoothed as if it hung this far away
constexpr double kNegligible = 1e-4;  // of a weight
constexpr double kReach = 10;         // m

// Weights of the skin around a point, and how far away the skin is.
struct Around {
  Eigen::MatrixXd weights;    // #V x joints
  Eigen::VectorXd distances;  // m
};

// Averages over the whole skin, by area over (r^2 + l^2)^3, r: distance to the skin there, l:
// kSpread times that to where it is nearest. Close to the skin that is about the weight under the
// point; on the middle plane of a skirt it is half of each leg's, and it changes smoothly through
// space, whatever the cloth does there.
Around skin_around(const Eigen::Ref<const Points3>& points, const SurfaceTree& surface,
                   const SkinWeights& body_weights) {
  const Points3& skin = surface.vertices();
  const Faces& faces = surface.faces();
  Eigen::ArrayXd area = Eigen::ArrayXd::Zero(skin.rows());
  const Eigen::VectorXd of_faces = face_areas(skin, faces);
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) area[faces(f, k)] += of_faces[f] / 3;
  Around around{Eigen::MatrixXd(points.rows(), body_weights.cols()),
                Eigen::VectorXd(points.rows())};
  for (Eigen::Index v = 0; v < points.rows(); ++v) {
    const ClosestPoint closest = surface.closest(points.row(v).transpose(), kReach);
    if (closest.face < 0) throw std::invalid_argument("the garment is not around the body");
    around.distances[v] = std::max(kLeastDistance, std::sqrt(closest.squared_distance));
    const double length = kSpread * around.distances[v];
    // Over l^2, so that nothing overflows.
    const Eigen::ArrayXd farther =
        (skin.rowwise() - points.row(v)).rowwise().squaredNorm().array() / (length * length) + 1;
    const Eigen::VectorXd share = area / farther.cube();
    around.weights.row(v) = (body_weights.transpose() * share).transpose() / share.sum();
  }
  return around;
}

}  // namespace

SkinWeights garment_weights(const Eigen::Ref<const Points3>& t_pose, const Faces& faces,
                            const body::BodyModel& model, const body::ShapedBody& body) {
  const Points3 skin = body::pose_body(model, body, body::Pose{});
  const SurfaceTree surface(skin, model.faces);
  const Around around = skin_around(t_pose, surface, model.weights);

  // Implicit diffusion along the cloth: minimise  sum_v m_v / l_v^2 (w_v - w0_v)^2 + integral |grad
  // w|^2, l_v = kSpread * distance. Cotangents are kept non-negative, so that weights stay within 0
  // .. 1.
  const Eigen::Index count = t_pose.rows();
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::VectorXd mass = Eigen::VectorXd::Zero(count);
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const int a = faces(f, k), b = faces(f, (k + 1) % 3), c = faces(f, (k + 2) % 3);
      const Vec<3> to_a = (t_pose.row(a) - t_pose.row(c)).transpose(),
                   to_b = (t_pose.row(b) - t_pose.row(c)).transpose();
      const double twice_area = to_a.cross(to_b).norm();
      mass[a] += twice_area / 6;
      const double weight = std::max(0.0, 0.5 * to_a.dot(to_b) / std::max(twice_area, 1e-12));
      entries.insert(entries.end(),
                     {{a, a, weight}, {b, b, weight}, {a, b, -weight}, {b, a, -weight}});
    }
  }
  const Eigen::VectorXd lengths = kSpread * around.distances;
  const Eigen::VectorXd pull = mass.array().max(1e-12) / lengths.array().square();
  for (Eigen::Index v = 0; v < count; ++v) entries.emplace_back(v, v, pull[v]);
  Eigen::SparseMatrix<double> matrix(count, count);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> system(matrix);
  if (system.info() != Eigen::Success)
    throw std::runtime_error("garment weights: the diffusion could not be solved");
  const Eigen::MatrixXd right_side = pull.asDiagonal() * around.weights;
  Eigen::MatrixXd smooth = system.solve(right_side);
  smooth = (smooth.array() < kNegligible).select(0.0, smooth);
  const Eigen::VectorXd sums = smooth.rowwise().sum();
  smooth.array().colwise() /= sums.array();
  SkinWeights weights = smooth.sparseView();
  weights.makeCompressed();
  return weights;
}

}  // namespace pleat::garment
