#include "learn/unet.h"

#include <cmath>

#include "core/error.h"

namespace pleat::learn {
namespace {

namespace nn = torch::nn;
using torch::Tensor;

nn::Conv2d conv3(int64_t in, int64_t out, int64_t stride = 1) {
  return nn::Conv2d(nn::Conv2dOptions(in, out, 3).stride(stride).padding(1));
}

nn::GroupNorm group_norm(int64_t groups, int64_t channels) {
  return nn::GroupNorm(nn::GroupNormOptions(groups, channels).eps(1e-5));
}

// x + conv(silu(norm(conv(silu(norm(x))) + shift))), or with scale_shift
// x + conv(silu(norm(conv(silu(norm(x)))) (1 + scale) + shift)); scale and shift are linear in the
// embedding.
struct ResidualImpl : nn::Module {
  ResidualImpl(int64_t in, int64_t out, int64_t embedding, const UNetConfig& config)
      : scale_shift(config.scale_shift),
        norm1(register_module("norm1", group_norm(config.norm_groups, in))),
        conv1(register_module("conv1", conv3(in, out))),
        project(register_module("project", nn::Linear(embedding, scale_shift ? 2 * out : out))),
        norm2(register_module("norm2", group_norm(config.norm_groups, out))),
        conv2(register_module("conv2", conv3(out, out))) {
    if (in != out) {
      shortcut = register_module("shortcut", nn::Conv2d(nn::Conv2dOptions(in, out, 1)));
    }
  }
  // embedding: silu(time, condition), [B, E]
  Tensor forward(const Tensor& x, const Tensor& embedding) {
    Tensor h = conv1(torch::silu(norm1(x)));
    const Tensor projected = project(embedding).unsqueeze(2).unsqueeze(3);
    if (scale_shift) {
      const std::vector<Tensor> parts = projected.chunk(2, 1);
      h = norm2(h) * (1 + parts[0]) + parts[1];
    } else {
      h = norm2(h + projected);
    }
    h = conv2(torch::silu(h));
    return (shortcut ? shortcut(x) : x) + h;
  }
  bool scale_shift;
  nn::GroupNorm norm1;
  nn::Conv2d conv1;
  nn::Linear project;
  nn::GroupNorm norm2;
  nn::Conv2d conv2, shortcut{nullptr};
};
TORCH_MODULE(Residual);

// Every texel looks at every other (Vaswani et al. 2017), in heads of few channels.
struct AttentionImpl : nn::Module {
  AttentionImpl(int64_t channels, int64_t head_channels, int64_t groups)
      : heads(channels / head_channels),
        norm(register_module("norm", group_norm(groups, channels))),
        query_key_value(register_module("query_key_value", nn::Linear(channels, 3 * channels))),
        out(register_module("out", nn::Linear(channels, channels))) {}
  Tensor forward(const Tensor& x) {
    const int64_t batch = x.size(0), channels = x.size(1), texels = x.size(2) * x.size(3);
    const Tensor tokens = norm(x).reshape({batch, channels, texels}).transpose(1, 2);  // [B, N, C]
    const Tensor qkv = query_key_value(tokens)
                           .reshape({batch, texels, 3, heads, channels / heads})
                           .permute({2, 0, 3, 1, 4});  // [3, B, heads, N, C / heads]
    const double scale = 1 / std::sqrt(static_cast<double>(channels / heads));
    const Tensor weights = torch::softmax(torch::matmul(qkv[0] * scale, qkv[1].transpose(2, 3)),
                                          -1);  // [B, heads, N, N]
    Tensor h = torch::matmul(weights, qkv[2]).transpose(1, 2).reshape({batch, texels, channels});
    h = out(h).transpose(1, 2).reshape(x.sizes());
    return x + h;
  }
  int64_t heads;
  nn::GroupNorm norm;
  nn::Linear query_key_value, out;
};
TORCH_MODULE(Attention);

// One resolution: residual layers, each with attention behind it where asked for, then the change
// of resolution.
struct BlockImpl : nn::Module {
  BlockImpl(const std::vector<int64_t>& inputs, int64_t out, int64_t embedding, bool has_attention,
            const UNetConfig& config) {
    residuals = register_module("residuals", nn::ModuleList());
    attentions = register_module("attentions", nn::ModuleList());
    for (const int64_t in : inputs) {
      residuals->push_back(Residual(in, out, embedding, config));
      if (has_attention) {
        attentions->push_back(Attention(out, config.attention_head_channels, config.norm_groups));
      }
    }
  }
  Tensor layer(size_t i, const Tensor& x, const Tensor& embedding) {
    const Tensor h = residuals->at<ResidualImpl>(i).forward(x, embedding);
    return attentions->is_empty() ? h : attentions->at<AttentionImpl>(i).forward(h);
  }
  nn::ModuleList residuals{nullptr}, attentions{nullptr};
  nn::Conv2d resample{nullptr};
};
TORCH_MODULE(Block);

// Sinusoids of t from wavelength 2 pi to 2 pi 10^4, cosines first.
Tensor time_features(const Tensor& t, int64_t count) {
  const int64_t half = count / 2;
  const Tensor frequencies = torch::exp(torch::arange(half, torch::kFloat32) *
                                        (-std::log(1e4) / static_cast<double>(half)));
  const Tensor angles = t.to(torch::kFloat32).unsqueeze(1) * frequencies.unsqueeze(0);
  return torch::cat({torch::cos(angles), torch::sin(angles)}, 1);  // [B, count]
}

Tensor to_patches(const Tensor& y, int64_t patch) {
  return patch == 1 ? y : torch::pixel_unshuffle(y, patch);  // [B, C p p, H / p, W / p]
}

Tensor from_patches(const Tensor& y, int64_t patch) {
  return patch == 1 ? y : torch::pixel_shuffle(y, patch);  // [B, C, H p, W p]
}

}  // namespace

UNetImpl::UNetImpl(const UNetConfig& config, int64_t resolution, int64_t features)
    : config_(config) {
  validate(config);
  const size_t levels = config.block_channels.size();
  const int64_t shrink = config.patch * (int64_t{1} << (levels - 1));
  if (resolution % shrink != 0) {
    throw InputError("train.network: patch " + std::to_string(config.patch) + " and " +
                     std::to_string(levels) + " blocks divide the texture's side by " +
                     std::to_string(shrink) + ", but it has " + std::to_string(resolution) +
                     " texels; expected fewer blocks or a smaller patch");
  }
  const auto channels = [&](size_t level) { return int64_t{config.block_channels[level]}; };
  const auto has_attention = [&](size_t level) {
    for (const int block : config.attention_blocks) {
      if (block == static_cast<int>(level) + 1) return true;
    }
    return false;
  };
  const int64_t texels_per_patch = int64_t{config.patch} * config.patch;
  const int64_t time_count = 4 * channels(0);
  int64_t embedding = time_count;
  time_in_ = register_module("time_in", nn::Linear(channels(0), time_count));
  time_out_ = register_module("time_out", nn::Linear(time_count, time_count));
  if (features > 0) {
    condition_in_ =
        register_module("condition_in", nn::Linear(features, config.condition_features));
    condition_out_ = register_module(
        "condition_out", nn::Linear(config.condition_features, config.condition_features));
    embedding += config.condition_features;
  }
  conv_in_ =
      register_module("conv_in", conv3(config.input_channels * texels_per_patch, channels(0)));

  std::vector<int64_t> skips = {channels(0)};
  int64_t in = channels(0);
  down_ = register_module("down", nn::ModuleList());
  for (size_t level = 0; level < levels; ++level) {
    std::vector<int64_t> inputs(static_cast<size_t>(config.layers_per_block), channels(level));
    inputs[0] = in;
    in = channels(level);
    Block block(inputs, in, embedding, has_attention(level), config);
    skips.insert(skips.end(), inputs.size(), in);
    if (level + 1 < levels) {
      block->resample = block->register_module("resample", conv3(in, in, 2));
      skips.push_back(in);
    }
    down_->push_back(block);
  }

  middle_ = register_module("middle", nn::ModuleList());
  middle_->push_back(Residual(in, in, embedding, config));
  middle_->push_back(Attention(in, config.attention_head_channels, config.norm_groups));
  middle_->push_back(Residual(in, in, embedding, config));

  up_ = register_module("up", nn::ModuleList());
  for (size_t level = levels; level-- > 0;) {
    std::vector<int64_t> inputs;
    for (int layer = 0; layer <= config.layers_per_block; ++layer) {
      inputs.push_back(in + skips.back());
      skips.pop_back();
      in = channels(level);
    }
    Block block(inputs, in, embedding, has_attention(level), config);
    if (level > 0) block->resample = block->register_module("resample", conv3(in, in));
    up_->push_back(block);
  }
  norm_out_ = register_module("norm_out", group_norm(config.norm_groups, in));
  conv_out_ = register_module("conv_out", conv3(in, 3 * texels_per_patch));
}

Tensor UNetImpl::forward(const Tensor& y, const Tensor& t, const Tensor& c) {
  Tensor embedding = time_out_(torch::silu(time_in_(time_features(t, config_.block_channels[0]))));
  if (condition_in_) {
    embedding = torch::cat({embedding, condition_out_(torch::silu(condition_in_(c)))}, 1);
  }
  embedding = torch::silu(embedding);  // [B, E]

  Tensor h = conv_in_(to_patches(y, config_.patch));
  std::vector<Tensor> skips = {h};
  for (size_t level = 0; level < down_->size(); ++level) {
    auto& block = down_->at<BlockImpl>(level);
    for (size_t i = 0; i < block.residuals->size(); ++i) {
      h = block.layer(i, h, embedding);
      skips.push_back(h);
    }
    if (block.resample) {
      h = block.resample(h);
      skips.push_back(h);
    }
  }
  h = middle_->at<ResidualImpl>(0).forward(h, embedding);
  h = middle_->at<AttentionImpl>(1).forward(h);
  h = middle_->at<ResidualImpl>(2).forward(h, embedding);
  for (size_t level = 0; level < up_->size(); ++level) {
    auto& block = up_->at<BlockImpl>(level);
    for (size_t i = 0; i < block.residuals->size(); ++i) {
      h = block.layer(i, torch::cat({h, skips.back()}, 1), embedding);
      skips.pop_back();
    }
    if (block.resample) {
      h = block.resample(torch::upsample_nearest2d(h, {2 * h.size(2), 2 * h.size(3)}));
    }
  }
  h = conv_out_(torch::silu(norm_out_(h)));
  return from_patches(h, config_.patch);
}

int64_t parameter_count(const nn::Module& module) {
  int64_t count = 0;
  for (const Tensor& parameter : module.parameters()) count += parameter.numel();
  return count;
}

}  // namespace pleat::learn
