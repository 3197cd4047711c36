#include "garment/garment_weights.h"

#include <Eigen/SparseCholesky>
#include <cmath>
#include <vector>

#include "body/skinning.h"
#include "core/mesh.h"
#include "core/proximity.h"

namespace pleat::garment {
namespace {

constexpr double kSearch = 1.0;           // m: no cloth hangs farther from the body it is worn on
constexpr double kSmoothLength = 0.015;   // m: weights are smoothed over this length where the cloth lies on the body
constexpr double kLooseDistance = 0.01;   // m: from here on the smoothing grows in proportion to the distance
constexpr double kLeastWeight = 1e-5;

using Matrix = Eigen::SparseMatrix<double>;
using Dense = Eigen::MatrixXd;

// The joints that a motion turns; what hangs on a finger or the face hangs on the nearest of them.
int driven_joint(const body::BodyModel& model, int joint) {
  while (joint >= body::kJoints) joint = model.parents[joint];
  return joint;
}

// Cotangent stiffness, with obtuse angles' negative weights left out so that smoothing stays between its neighbours.
Matrix laplacian(const Eigen::Ref<const Points3>& points, const Faces& faces) {
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int c = 0; c < 3; ++c) {
      const int a = faces(f, (c + 1) % 3), b = faces(f, (c + 2) % 3);
      const Vec<3> u = (points.row(a) - points.row(faces(f, c))).transpose();
      const Vec<3> v = (points.row(b) - points.row(faces(f, c))).transpose();
      const double weight = std::max(0.05, 0.5 * u.dot(v) / std::max(u.cross(v).norm(), 1e-12));
      entries.emplace_back(a, a, weight);
      entries.emplace_back(b, b, weight);
      entries.emplace_back(a, b, -weight);
      entries.emplace_back(b, a, -weight);
    }
  Matrix matrix(points.rows(), points.rows());
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

}  // namespace

SkinWeights garment_weights(const Eigen::Ref<const Points3>& t_pose, const Faces& faces, const body::BodyModel& model,
                            const body::ShapedBody& body) {
  const Points3 posed = body::pose_body(model, body, body::Pose{});
  const SurfaceTree tree(posed, model.faces);
  Dense nearest = Dense::Zero(t_pose.rows(), model.joint_count());
  Eigen::VectorXd fidelity = Eigen::VectorXd::Zero(t_pose.rows());
  const Eigen::VectorXd areas = face_areas(t_pose, faces);
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int c = 0; c < 3; ++c) fidelity[faces(f, c)] += areas[f] / 3;
  for (Eigen::Index v = 0; v < t_pose.rows(); ++v) {
    const ClosestPoint closest = tree.closest(t_pose.row(v).transpose(), kSearch);
    if (closest.face < 0) continue;
    for (int c = 0; c < 3; ++c)
      for (SkinWeights::InnerIterator w(model.weights, model.faces(closest.face, c)); w; ++w)
        nearest(v, driven_joint(model, static_cast<int>(w.col()))) += closest.barycentric[c] * w.value();
    const double loose = std::sqrt(closest.squared_distance) / kLooseDistance;
    fidelity[v] /= 1 + loose * loose;
  }

  // Minimises sum fidelity |w - nearest|^2 + length^2 |grad w|^2: rows keep their sum of 1, since constants cost nothing.
  Matrix system = kSmoothLength * kSmoothLength * laplacian(t_pose, faces);
  for (Eigen::Index v = 0; v < t_pose.rows(); ++v) system.coeffRef(v, v) += fidelity[v];
  const Eigen::SimplicialLDLT<Matrix> factor(system);
  const Dense smooth = factor.solve(fidelity.asDiagonal() * nearest);

  SkinWeights weights(t_pose.rows(), model.joint_count());
  for (Eigen::Index v = 0; v < t_pose.rows(); ++v) {
    double sum = 0;
    for (Eigen::Index j = 0; j < smooth.cols(); ++j) sum += smooth(v, j) > kLeastWeight ? smooth(v, j) : 0;
    for (Eigen::Index j = 0; j < smooth.cols(); ++j)
      if (smooth(v, j) > kLeastWeight) weights.insert(v, j) = smooth(v, j) / sum;
  }
  weights.makeCompressed();
  return weights;
}

}  // namespace pleat::garment
