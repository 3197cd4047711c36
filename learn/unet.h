// The denoising network f(c, y, t): a U-Net of residual blocks that time and condition are added
// into (paper, section 5.2; Ho et al. 2020). Without conditions and patches, weight for weight the
// UNet2DModel of diffusers.
#pragma once

#include <torch/torch.h>

#include "learn/config.h"

namespace pleat::learn {

class UNetImpl : public torch::nn::Module {
 public:
  // resolution: texels a side of the images; features: numbers of the condition, 0 for none.
  // InputError where the resolution cannot be halved as often as the blocks ask.
  UNetImpl(const UNetConfig& config, int64_t resolution, int64_t features);

  // y: [B, input_channels, R, R]; t: int64 [B], 1 .. T; c: [B, features] or undefined. Gives [B, 3,
  // R, R].
  torch::Tensor forward(const torch::Tensor& y, const torch::Tensor& t, const torch::Tensor& c);

 private:
  UNetConfig config_;
  torch::nn::Linear time_in_{nullptr}, time_out_{nullptr};
  torch::nn::Linear condition_in_{nullptr}, condition_out_{nullptr};
  torch::nn::Conv2d conv_in_{nullptr}, conv_out_{nullptr};
  torch::nn::ModuleList down_{nullptr}, middle_{nullptr}, up_{nullptr};
  torch::nn::GroupNorm norm_out_{nullptr};
};
TORCH_MODULE(UNet);

int64_t parameter_count(const torch::nn::Module& module);

}  // namespace pleat::learn
