#include "garment/garment_weights.h"

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "body/skinning.h"
#include "core/proximity.h"

namespace pleat::garment {
namespace {

constexpr double kSpread = 2.0;  // smoothing length over distance to the body
constexpr double kLeastDistance =
    0.01;  // m: cloth on the skin is smoothed as if it hung this far away
constexpr double kNegligible = 1e-4;  // of a weight
constexpr double kReach = 10;         // m

// Joint -> the joint on the other side, by where they are.
std::vector<int> mirrored_joints(const Points3& joints, double middle) {
  std::vector<int> mirrored;
  for (Eigen::Index j = 0; j < joints.rows(); ++j) {
    const Eigen::RowVector3d image(2 * middle - joints(j, 0), joints(j, 1), joints(j, 2));
    Eigen::Index nearest;
    (joints.rowwise() - image).rowwise().squaredNorm().minCoeff(&nearest);
    mirrored.push_back(static_cast<int>(nearest));
  }
  for (size_t j = 0; j < mirrored.size(); ++j)
    if (mirrored[mirrored[j]] != static_cast<int>(j)) mirrored[j] = static_cast<int>(j);
  return mirrored;
}

// Weights of the closest body point, and how far away it is.
struct Nearest {
  Eigen::MatrixXd weights;    // #V x joints
  Eigen::VectorXd distances;  // m
};

Nearest nearest_weights(const Eigen::Ref<const Points3>& points, const SurfaceTree& surface,
                        const SkinWeights& body_weights) {
  Nearest nearest{Eigen::MatrixXd::Zero(points.rows(), body_weights.cols()),
                  Eigen::VectorXd(points.rows())};
  for (Eigen::Index v = 0; v < points.rows(); ++v) {
    const ClosestPoint closest = surface.closest(points.row(v).transpose(), kReach);
    if (closest.face < 0) throw std::invalid_argument("the garment is not around the body");
    nearest.distances[v] = std::sqrt(closest.squared_distance);
    for (int k = 0; k < 3; ++k)
      for (SkinWeights::InnerIterator w(body_weights, surface.faces()(closest.face, k)); w; ++w)
        nearest.weights(v, w.col()) += closest.barycentric[k] * w.value();
  }
  return nearest;
}

}  // namespace

SkinWeights garment_weights(const Eigen::Ref<const Points3>& t_pose, const Faces& faces,
                            const body::BodyModel& model, const body::ShapedBody& body) {
  const Points3 skin = body::pose_body(model, body, body::Pose{});
  const SurfaceTree surface(skin, model.faces);
  Nearest nearest = nearest_weights(t_pose, surface, model.weights);

  // On the middle plane of a skirt the left and the right leg are as near: the closest point there
  // is a matter of chance. The mean with what the mirrored cloth would get makes both sides alike.
  const double middle = body.joints(0, 0);
  Points3 mirrored = t_pose;
  mirrored.col(0) = 2 * middle - mirrored.col(0).array();
  const Nearest other = nearest_weights(mirrored, surface, model.weights);
  const std::vector<int> joint_across = mirrored_joints(body.joints, middle);
  nearest.distances = 0.5 * (nearest.distances + other.distances);
  const Eigen::MatrixXd own = nearest.weights;
  for (Eigen::Index j = 0; j < own.cols(); ++j)
    nearest.weights.col(j) =
        0.5 * (own.col(j) + other.weights.col(joint_across[static_cast<size_t>(j)]));

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
  const Eigen::VectorXd lengths = kSpread * nearest.distances.cwiseMax(kLeastDistance);
  const Eigen::VectorXd pull = mass.array().max(1e-12) / lengths.array().square();
  for (Eigen::Index v = 0; v < count; ++v) entries.emplace_back(v, v, pull[v]);
  Eigen::SparseMatrix<double> matrix(count, count);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> system(matrix);
  if (system.info() != Eigen::Success)
    throw std::runtime_error("garment weights: the diffusion could not be solved");
  const Eigen::MatrixXd right_side = pull.asDiagonal() * nearest.weights;
  Eigen::MatrixXd smooth = system.solve(right_side);
  smooth = (smooth.array() < kNegligible).select(0.0, smooth);
  const Eigen::VectorXd sums = smooth.rowwise().sum();
  smooth.array().colwise() /= sums.array();
  SkinWeights weights = smooth.sparseView();
  weights.makeCompressed();
  return weights;
}

}  // namespace pleat::garment
