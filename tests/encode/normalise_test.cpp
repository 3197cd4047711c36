#include "encode/normalise.h"

#include <gtest/gtest.h>

namespace pleat::encode {
namespace {

Texture texture_of(std::vector<float> values) { return {2, std::move(values)}; }
const std::vector<uint8_t> kMask = {kInside, kInside, kGutter, kEmpty};

TEST(Normalise, MeasuresInsideTexelsOnly) {
  OffsetSums sums;
  add(sums, texture_of({1, 3, 100, 100, 5, 5, 100, 100, -1, 1, 100, 100}), kMask);
  add(sums, texture_of({1, 3, 100, 100, 5, 5, 100, 100, -1, 1, 100, 100}), kMask);
  EXPECT_EQ(sums.count, 4);
  const Normalisation result = normalisation(sums);
  EXPECT_EQ(result.mean, Vec<3>(2, 5, 0));
  EXPECT_DOUBLE_EQ(result.std[0], 1);
  EXPECT_GT(result.std[1], 0);  // constant axis
  EXPECT_DOUBLE_EQ(result.std[2], 1);
}

TEST(Normalise, UndoesItselfAndLeavesEmptyTexelsZero) {
  const Normalisation by{Vec<3>(2, 5, 0), Vec<3>(0.5, 2, 1)};
  const Texture texture = texture_of({1, 3, 4, 0, 5, 6, 7, 0, -1, 1, 2, 0});
  const Texture normalised = normalise(texture, by, kMask);
  EXPECT_EQ(normalised.values[0], -2.0f);
  EXPECT_EQ(normalised.values[3], 0.0f);
  EXPECT_EQ(denormalise(normalised, by, kMask).values, texture.values);
}

}  // namespace
}  // namespace pleat::encode
