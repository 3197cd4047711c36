#include "evaluate/baselines.h"

#include <gtest/gtest.h>

#include "tests/evaluate/small_dataset.h"

namespace pleat::evaluate {
namespace {

TEST(Baselines, MeanTextureIsThatOfTheTrainingSplit) {
  const SmallDataset small;
  const encode::Dataset dataset(small.dataset_file);
  const encode::Texture mean = mean_training_texture(dataset);
  for (const size_t i : {size_t{1000}, size_t{1500}, size_t{6000}, size_t{11000}}) {
    double expected = 0;
    for (int64_t row = 0; row < 4; ++row)
      expected += 0.25 * static_cast<double>(dataset.texture(row).values[i]);
    EXPECT_NEAR(static_cast<double>(mean.values[i]), expected, 1e-8);
  }
}

TEST(Baselines, NearestPoseIsOfTheTrainingSplitAndOfAnotherClip) {
  const SmallDataset small;
  const encode::Dataset dataset(small.dataset_file);
  const NearestPose nearest(dataset);
  for (int64_t row = 0; row < 4; ++row)
    EXPECT_FALSE(nearest.row(row).has_value());  // one clip is all there is
  // The tilt of row i is 0.02 i and the heading does not count: the last training row is the
  // nearest to all later ones.
  for (int64_t row = 4; row < 10; ++row) EXPECT_EQ(nearest.row(row), 3);
}

}  // namespace
}  // namespace pleat::evaluate
