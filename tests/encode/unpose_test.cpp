#include "encode/unpose.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "tests/encode/synthetic_body.h"

namespace pleat::encode {
namespace {

class BothSkinnings : public testing::TestWithParam<Skinning> {};
INSTANTIATE_TEST_SUITE_P(Unpose, BothSkinnings,
                         testing::Values(Skinning::kLinear, Skinning::kDualQuaternion));

TEST_P(BothSkinnings, UnposingUndoesPosing) {
  const Tube tube = make_tube(12, 24);
  const body::BodyModel model = column_body();
  const garment::Garment garment = tube_garment(tube, {});
  const Points3 offsets = tube_wrinkles(tube, 0.01, 4);
  for (const double time : {0.0, 1.0, 4.0}) {
    const std::vector<body::Transform> transforms =
        body::joint_transforms(model, body::shape_body(model, Vec<2>(1, -2)), spine_pose(time));
    const Points3 posed = pose(garment, offsets, transforms, GetParam());
    EXPECT_GT((posed - garment.t_pose).cwiseAbs().maxCoeff(), 0.1);
    Eigen::VectorXd singular_values;
    const Points3 back = unpose(garment, posed, transforms, GetParam(), &singular_values);
    EXPECT_LT((back - offsets).cwiseAbs().maxCoeff(), 1e-12);
    ASSERT_EQ(singular_values.size(), offsets.rows());
    EXPECT_GT(singular_values.minCoeff(), 0.8);
    EXPECT_LE(singular_values.maxCoeff(), 1 + 1e-12);
  }
}

TEST(Unpose, NamesItsSkinnings) {
  for (const Skinning skinning : {Skinning::kLinear, Skinning::kDualQuaternion}) {
    EXPECT_EQ(parse_skinning(skinning_name(skinning)), skinning);
  }
  EXPECT_THROW(parse_skinning("cubic"), InputError);
}

}  // namespace
}  // namespace pleat::encode
