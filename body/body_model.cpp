#include "body/body_model.h"

#include <cmath>

#include "body/rotation.h"
#include "core/error.h"
#include "core/mesh.h"

namespace pleat::body {
namespace {

void require(bool holds, const std::string& source, const std::string& message) {
  if (!holds) throw InputError(source + ": " + message);
}

std::string dims(Eigen::Index rows, Eigen::Index columns) {
  return std::to_string(rows) + " x " + std::to_string(columns);
}

// Finite entries and rows that sum to 1 (to what float32 files leave).
void check_rows_sum_to_one(const SkinWeights& matrix, const std::string& source,
                           const std::string& array) {
  for (int row = 0; row < matrix.rows(); ++row) {
    double sum = 0;
    for (SkinWeights::InnerIterator it(matrix, row); it; ++it) sum += it.value();
    require(
        std::abs(sum - 1) < 1e-3, source,  // also catches NaN
        array + " row " + std::to_string(row) + " sums to " + std::to_string(sum) + "; expected 1");
  }
}

void check_finite(const double* values, Eigen::Index count, Eigen::Index columns,
                  const std::string& source, const std::string& array) {
  for (Eigen::Index i = 0; i < count; ++i) {
    require(std::isfinite(values[i]), source,
            array + " row " + std::to_string(i / columns) + " is not finite");
  }
}

}  // namespace

ShapedBody shape_body(const BodyModel& model, const Eigen::Ref<const Eigen::VectorXd>& beta) {
  if (beta.size() > static_cast<Eigen::Index>(model.shape_directions.size())) {
    throw InputError("body " + model.name + ": shape has " + std::to_string(beta.size()) +
                     " coefficients; the body has " +
                     std::to_string(model.shape_directions.size()) + " shape directions");
  }
  if (!beta.allFinite())
    throw InputError("body " + model.name + ": a shape coefficient is not finite");
  ShapedBody body;
  body.vertices = model.template_vertices;
  for (Eigen::Index k = 0; k < beta.size(); ++k)
    body.vertices += beta[k] * model.shape_directions[k];

  // The regressor gives the joints of the bind pose; its rotations are undone bone by bone.
  const Points3 bind_joints = model.joint_regressor * body.vertices;
  std::vector<Mat<3>> bind(static_cast<size_t>(model.joint_count()));
  body.joints.resize(model.joint_count(), 3);
  for (int j = 0; j < model.joint_count(); ++j) {
    const Mat<3> local = rotation_matrix(model.bind_pose.row(j));
    const int parent = model.parents[j];
    if (parent < 0) {
      bind[j] = local;
      body.joints.row(j) = bind_joints.row(j);
    } else {
      bind[j] = bind[parent] * local;
      body.joints.row(j) =
          body.joints.row(parent) + (bind_joints.row(j) - bind_joints.row(parent)) * bind[parent];
    }
  }
  return body;
}

void validate(const BodyModel& model, const std::string& source) {
  const Eigen::Index vertices = model.template_vertices.rows();
  const Eigen::Index joints = model.joint_count();
  require(vertices >= 4, source, "v_template has " + std::to_string(vertices) + " vertices");
  require(joints >= kJoints, source,
          "kintree_table has " + std::to_string(joints) + " joints; expected at least " +
              std::to_string(kJoints));
  check_finite(model.template_vertices.data(), model.template_vertices.size(), 3, source,
               "v_template");
  for (const Points3& direction : model.shape_directions) {
    require(direction.rows() == vertices, source,
            "shapedirs has " + std::to_string(direction.rows()) + " vertices; v_template has " +
                std::to_string(vertices));
    check_finite(direction.data(), direction.size(), 3, source, "shapedirs");
  }
  if (model.pose_directions.size() > 0) {
    require(model.pose_directions.rows() == 3 * vertices &&
                model.pose_directions.cols() == 9 * (joints - 1),
            source,
            "posedirs is " + dims(model.pose_directions.rows(), model.pose_directions.cols()) +
                "; expected " + dims(3 * vertices, 9 * (joints - 1)));
    require(model.pose_directions.allFinite(), source, "posedirs is not finite");
  }
  require(model.joint_regressor.rows() == joints && model.joint_regressor.cols() == vertices,
          source,
          "J_regressor is " + dims(model.joint_regressor.rows(), model.joint_regressor.cols()) +
              "; expected " + dims(joints, vertices));
  check_rows_sum_to_one(model.joint_regressor, source, "J_regressor");
  require(model.weights.rows() == vertices && model.weights.cols() == joints, source,
          "weights is " + dims(model.weights.rows(), model.weights.cols()) + "; expected " +
              dims(vertices, joints));
  check_rows_sum_to_one(model.weights, source, "weights");
  for (int row = 0; row < model.weights.rows(); ++row) {
    for (SkinWeights::InnerIterator it(model.weights, row); it; ++it) {
      require(it.value() >= -1e-6, source, "weights row " + std::to_string(row) + " is negative");
    }
  }
  require(model.bind_pose.rows() == joints, source,
          "bind_pose has " + std::to_string(model.bind_pose.rows()) + " rows; expected " +
              std::to_string(joints));
  check_finite(model.bind_pose.data(), model.bind_pose.size(), 3, source, "bind_pose");
  require(model.parents[0] == -1, source, "kintree_table: joint 0 must be the root");
  for (int j = 1; j < joints; ++j) {
    require(model.parents[j] >= 0 && model.parents[j] < j, source,
            "kintree_table: joint " + std::to_string(j) + " has parent " +
                std::to_string(model.parents[j]) + "; expected a joint before it");
  }
  require(model.faces.rows() > 0, source, "f has no faces");
  require(model.faces.minCoeff() >= 0 && model.faces.maxCoeff() < vertices, source,
          "f names vertex " +
              std::to_string(model.faces.maxCoeff() < vertices ? model.faces.minCoeff()
                                                               : model.faces.maxCoeff()) +
              "; v_template has " + std::to_string(vertices));
  const Topology t = topology(model.faces, static_cast<int>(vertices));
  require(t.is_watertight(), source,
          "f is not a closed surface: " + std::to_string(t.boundary_edges) +
              " edges with one face, " + std::to_string(t.nonmanifold_edges) +
              " with more than two, " + std::to_string(t.misoriented_edges) +
              " with faces turned against each other; close the holes of the body");
}

}  // namespace pleat::body
