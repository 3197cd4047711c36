#include "learn/config.h"

#include <sstream>

#include "core/error.h"

namespace pleat::learn {
namespace {

template <typename T>
void require(bool ok, const std::string& key, const T& value, const std::string& expected) {
  if (ok) return;
  std::ostringstream text;
  text << key << " = " << value << "; expected " << expected;
  throw InputError(text.str());
}

void require_within(const std::string& key, double value, double low, double high) {
  std::ostringstream expected;
  expected << low << " to " << high;
  require(value >= low && value <= high, key, value, expected.str());  // false for NaN
}

}  // namespace

UNetConfig paper_unet() {
  UNetConfig config;
  config.block_channels = {128, 128, 256, 256, 512, 512};
  config.attention_blocks = {5};
  config.layers_per_block = 2;
  config.patch = 1;
  config.scale_shift = false;
  return config;
}

void validate(const UNetConfig& config) {
  const std::string section = "train.network.";
  require_within(section + "norm_groups", config.norm_groups, 1, 1024);
  require_within(section + "attention_head_channels", config.attention_head_channels, 1, 1024);
  require(!config.block_channels.empty() && config.block_channels.size() <= 8,
          section + "block_channels", config.block_channels.size(), "1 to 8 numbers");
  for (const int channels : config.block_channels) {
    require_within(section + "block_channels", channels, 2, 4096);
    require(channels % config.norm_groups == 0, section + "block_channels", channels,
            "multiples of norm_groups = " + std::to_string(config.norm_groups));
    require(channels % 2 == 0, section + "block_channels", channels, "even numbers");
  }
  for (const int block : config.attention_blocks) {
    require_within(section + "attention_blocks", block, 1,
                   static_cast<double>(config.block_channels.size()));
    const int channels = config.block_channels[static_cast<size_t>(block - 1)];
    require(channels % config.attention_head_channels == 0, section + "attention_head_channels",
            config.attention_head_channels,
            "a divisor of the block's channels, " + std::to_string(channels));
  }
  require(
      config.block_channels.back() % config.attention_head_channels == 0,
      section + "attention_head_channels", config.attention_head_channels,
      "a divisor of the last block's channels, " + std::to_string(config.block_channels.back()));
  require_within(section + "layers_per_block", config.layers_per_block, 1, 8);
  require(config.patch == 1 || config.patch == 2 || config.patch == 4 || config.patch == 8,
          section + "patch", config.patch, "1, 2, 4 or 8");
  require_within(section + "condition_features", config.condition_features, 1, 4096);
  require(config.input_channels == 3 || config.input_channels == 6, section + "input_channels",
          config.input_channels, "3, or 6 with the previous frame");
}

void validate(const TrainConfig& config) {
  validate(config.network);
  // Below 25 the last step would add more noise than there is variance: see make_schedule.
  require_within("train.diffusion_steps", config.diffusion_steps, 25, 4000);
  require(config.prediction == "x0" || config.prediction == "v" || config.prediction == "epsilon",
          "train.prediction", config.prediction, "x0, v or epsilon");
  require_within("train.batch_size", config.batch_size, 1, 65536);
  require_within("train.steps", static_cast<double>(config.steps), 1, 1e9);
  require_within("train.max_minutes", config.max_minutes, 0, 1e7);
  require_within("train.learning_rate", config.learning_rate, 1e-12, 1e3);
  require_within("train.warmup_steps", static_cast<double>(config.warmup_steps), 0, 1e9);
  require_within("train.weight_decay", config.weight_decay, 0, 1);
  require(config.max_gradient_norm > 0, "train.max_gradient_norm", config.max_gradient_norm, "> 0");
  require(config.average_decay >= 0 && config.average_decay < 1, "train.average_decay",
          config.average_decay, ">= 0 and < 1");
  require_within("train.checkpoint_minutes", config.checkpoint_minutes, 0, 1e7);
  require_within("train.validate_every_steps", static_cast<double>(config.validate_every_steps), 1,
                 1e9);
  require_within("train.validation_rows", config.validation_rows, 1, 65536);
  require_within("train.preload_mb", config.preload_mb, 0, 1e9);
  require_within("train.threads", config.threads, 0, 4096);
}

void validate(const TrainDesignConfig& config) {
  require(config.hidden.size() <= 8, "train_design.hidden", config.hidden.size(),
          "at most 8 layers");
  for (const int width : config.hidden) require_within("train_design.hidden", width, 1, 65536);
  require_within("train_design.components", config.components, 1, 4096);
  require_within("train_design.steps", static_cast<double>(config.steps), 1, 1e9);
  require_within("train_design.learning_rate", config.learning_rate, 1e-12, 1e3);
  require_within("train_design.weight_decay", config.weight_decay, 0, 1);
  require_within("train_design.threads", config.threads, 0, 4096);
}

void validate(const SampleConfig& config) {
  require(config.sampler == "ddim" || config.sampler == "ddpm", "sample.sampler", config.sampler,
          "ddim or ddpm");
  require_within("sample.ddim_steps", config.ddim_steps, 1, 4000);
  require_within("sample.samples_per_row", config.samples_per_row, 1, 1e6);
  require_within("sample.batch_size", config.batch_size, 1, 65536);
  require_within("sample.threads", config.threads, 0, 4096);
}

}  // namespace pleat::learn
