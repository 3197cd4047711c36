// AdamW (Loshchilov and Hutter 2019) with a moving average of the weights, in one pass over memory.
// The network's parameters and gradients are views into two flat arrays, so that the whole state is
// five arrays of one length.
#pragma once

#include <torch/torch.h>

#include <string>
#include <vector>

namespace pleat::learn {

struct AdamStep {
  double learning_rate = 1e-3;
  double weight_decay = 0;
  double average_decay = 0;
  double max_gradient_norm = 1;
};

class Adam {
 public:
  // Moves the module's parameters into the flat array; average starts as a copy.
  explicit Adam(torch::nn::Module& module);

  // One update from the gradients that backward() left, which are then cleared. step counts from 1.
  void update(int64_t step, const AdamStep& options);

  // float32 [P], in the order of module.named_parameters().
  torch::Tensor values, gradients, first_moment, second_moment, average;
};

// Copies a flat array into the module's parameters.
void set_parameters(torch::nn::Module& module, const torch::Tensor& values);

}  // namespace pleat::learn
