#include "body/body_model.h"

#include <gtest/gtest.h>

#include "tests/body/synthetic_body.h"
#include "tests/core/input_error.h"

namespace pleat::body {
namespace {

TEST(ShapeBody, MovesVerticesAndJointsLinearly) {
  const BodyModel model = box_body();
  const ShapedBody mean = shape_body(model, Eigen::VectorXd());
  EXPECT_LT((mean.joints - human_joints()).cwiseAbs().maxCoeff(), 1e-12);
  Eigen::VectorXd beta(2);
  beta << 0, 2;  // 20 % taller
  const ShapedBody tall = shape_body(model, beta);
  EXPECT_LT((tall.joints.col(1) - 1.2 * mean.joints.col(1)).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT((tall.joints.col(0) - mean.joints.col(0)).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(ShapeBody, BoneLengthsSurviveTheBindPose) {
  BodyModel model = box_body();
  bind_in_a_pose(model);
  const ShapedBody body = shape_body(model, Eigen::VectorXd());
  const Points3 bind = model.joint_regressor * body.vertices;
  for (int j = 1; j < kJoints; ++j) {
    const int p = kParents[j];
    EXPECT_NEAR((body.joints.row(j) - body.joints.row(p)).norm(),
                (bind.row(j) - bind.row(p)).norm(), 1e-12);
  }
}

TEST(ShapeBody, RefusesMoreCoefficientsThanDirections) {
  EXPECT_INPUT_ERROR(shape_body(box_body(), Eigen::VectorXd::Zero(4)), "4 coefficients", "3");
}

TEST(ValidateBody, AcceptsAClosedBody) { EXPECT_NO_THROW(validate(box_body(), "box")); }

TEST(ValidateBody, NamesTheArrayAtFault) {
  const BodyModel good = box_body();
  BodyModel bad = good;
  bad.faces.conservativeResize(bad.faces.rows() - 1, 3);
  EXPECT_INPUT_ERROR(validate(bad, "x.npz"), "x.npz", "f is not a closed surface",
                     "3 edges with one face");
  bad = good;
  std::swap(bad.faces(5, 0), bad.faces(5, 1));
  EXPECT_INPUT_ERROR(validate(bad, "x.npz"), "turned against");
  bad = good;
  bad.template_vertices(9, 1) = std::nan("");
  EXPECT_INPUT_ERROR(validate(bad, "x.npz"), "v_template row 9");
  bad = good;
  bad.weights *= 1.1;
  EXPECT_INPUT_ERROR(validate(bad, "x.npz"), "weights row 0", "1.1");
  bad = good;
  bad.joint_regressor.coeffRef(3, 0) += 0.5;
  EXPECT_INPUT_ERROR(validate(bad, "x.npz"), "J_regressor row 3");
  bad = good;
  bad.parents[4] = 7;
  EXPECT_INPUT_ERROR(validate(bad, "x.npz"), "kintree_table", "joint 4");
  bad = good;
  bad.faces(0, 0) = 100000;
  EXPECT_INPUT_ERROR(validate(bad, "x.npz"), "f names vertex 100000");
  bad = good;
  bad.shape_directions[1](0, 0) = std::nan("");
  EXPECT_INPUT_ERROR(validate(bad, "x.npz"), "shapedirs");
}

}  // namespace
}  // namespace pleat::body
