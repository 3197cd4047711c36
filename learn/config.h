// The options of learning. Section and key of the YAML are the names here.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace pleat::learn {

// The default is sized for minutes on two cores; paper_unet() for a GPU, or days.
struct UNetConfig {                                 // section `train.network`
  std::vector<int> block_channels = {64, 96, 128};  // from the full resolution down by halves
  std::vector<int> attention_blocks = {3};          // numbered from 1: those with self-attention
  int layers_per_block = 1;                         // residual layers, one more on the way up
  int patch = 4;  // space to depth: patch x patch texels become channels before the first block
  int norm_groups = 32;  // of GroupNorm; divides every block's channels
  int attention_head_channels = 8;
  int condition_features = 128;  // width of the 2-layer MLP on the condition
  int input_channels = 3;        // 6 with the previous frame
  bool scale_shift = true;  // time and condition scale channels too, as in Dhariwal and Nichol 2021
};
UNetConfig paper_unet();  // section 5.2: 128 128 256 256 512 512, attention in the fifth

struct TrainConfig {  // section `train`
  UNetConfig network;
  int diffusion_steps = 100;      // T
  std::string prediction = "x0";  // what the network predicts: x0, v, or epsilon as in the paper
  int batch_size = 8;
  int64_t steps = 600;
  double max_minutes = 0;       // of training, all runs together; 0: no limit
  double learning_rate = 2e-3;  // peak: rises over warmup_steps, falls as a cosine to 1/50
  int64_t warmup_steps = 50;
  double weight_decay = 1e-4;
  double max_gradient_norm = 1;
  double average_decay = 0.99;  // of the moving average of the weights that samples are drawn with
  double checkpoint_minutes = 2;  // between checkpoints
  int64_t validate_every_steps = 200;
  int validation_rows = 32;  // spread over the held-out rows
  double preload_mb = 4096;  // training textures are kept in memory up to this size
  int threads = 0;           // 0: all
  uint64_t seed = 1;
};

struct TrainDesignConfig {  // section `train_design`
  std::vector<int> hidden = {64, 64};
  int components = 16;   // of the principal basis of the outputs, at most
  int64_t steps = 3000;  // on all training designs at once
  double learning_rate = 3e-3;
  double weight_decay = 1e-3;
  int threads = 1;  // the network is too small for more
  uint64_t seed = 1;
};

struct SampleConfig {  // section `sample`
  std::string sampler =
      "ddim";  // ddim (deterministic from its first noise) or ddpm (T steps, Ho et al. 2020)
  int ddim_steps = 10;
  int samples_per_row = 1;
  int batch_size = 8;  // no influence on the samples beyond rounding
  int threads = 0;
  uint64_t seed = 1;
};

// Throw InputError naming the key.
void validate(const UNetConfig& config);
void validate(const TrainConfig& config);
void validate(const TrainDesignConfig& config);
void validate(const SampleConfig& config);

}  // namespace pleat::learn
