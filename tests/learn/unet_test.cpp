#include "learn/unet.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "learn/threads.h"

namespace pleat::learn {
namespace {

UNetConfig tiny() {
  UNetConfig config;
  config.block_channels = {8, 16};
  config.attention_blocks = {2};
  config.layers_per_block = 1;
  config.norm_groups = 4;
  config.condition_features = 16;
  return config;
}

TEST(UNet, HasThePapersParameters) {
  // UNet2DModel of diffusers with the settings of section 5.2 has 113,673,219 without conditions.
  UNet plain(paper_unet(), 128, 0);
  EXPECT_EQ(parameter_count(*plain), 113673219);
}

TEST(UNet, KeepsTheImagesShape) {
  use_threads(1);  // images this small are slower on more
  for (const int patch : {1, 2, 4}) {
    for (const int input_channels : {3, 6}) {
      for (const bool scale_shift : {false, true}) {
        for (const int64_t features : {0, 5}) {
          UNetConfig config = tiny();
          config.patch = patch;
          config.input_channels = input_channels;
          config.scale_shift = scale_shift;
          UNet network(config, 16, features);
          const torch::Tensor out = network(
              torch::randn({2, input_channels, 16, 16}), torch::tensor({int64_t{1}, int64_t{100}}),
              features > 0 ? torch::randn({2, features}) : torch::Tensor());
          EXPECT_EQ(out.sizes(), torch::IntArrayRef({2, 3, 16, 16}));
          EXPECT_TRUE(torch::isfinite(out).all().item<bool>());
        }
      }
    }
  }
}

TEST(UNet, DependsOnTimeConditionAndEveryParameter) {
  torch::manual_seed(1);
  UNetConfig config = tiny();
  config.block_channels = {8, 16, 16};
  config.layers_per_block = 2;
  UNet network(config, 16, 5);
  const torch::Tensor y = torch::randn({1, 3, 16, 16}), c = torch::randn({1, 5});
  const torch::Tensor t = torch::full({1}, int64_t{3}), other_t = torch::full({1}, int64_t{60});
  const torch::Tensor out = network(y, t, c);
  EXPECT_GT((network(y, other_t, c) - out).abs().max().item<double>(), 1e-4);
  EXPECT_GT((network(y, t, c + 1) - out).abs().max().item<double>(), 1e-4);
  out.square().sum().backward();
  for (const auto& item : network->named_parameters()) {
    ASSERT_TRUE(item.value().grad().defined()) << item.key();
    EXPECT_GT(item.value().grad().abs().max().item<double>(), 0) << item.key();
  }
}

TEST(UNet, RefusesWhatDoesNotDivide) {
  EXPECT_THROW(UNet(tiny(), 18, 0), InputError);  // 18 / (2 * 2)
  UNetConfig config = tiny();
  config.block_channels = {8, 10};
  EXPECT_THROW(validate(config), InputError);
  config = tiny();
  config.attention_blocks = {3};
  EXPECT_THROW(validate(config), InputError);
}

}  // namespace
}  // namespace pleat::learn
