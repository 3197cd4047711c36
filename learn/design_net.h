// G_design: p -> N x 3 template vertices and M x 2 texture coordinates (paper, section 3), a
// shallow MLP.
#pragma once

#include <torch/torch.h>

#include <string>

#include "learn/config.h"

namespace pleat::learn {

// mean + basis (line(p) + MLP(p)). The basis is that of the principal components of the training
// designs, so the network has few outputs and stays inside the span of shapes that exist. The line
// is the least-squares fit, which leaves to the MLP only what is curved: with so few designs an MLP
// alone is far off between them.
class DesignNetImpl : public torch::nn::Module {
 public:
  DesignNetImpl(const std::vector<int>& hidden, int64_t components, int64_t outputs);
  torch::Tensor coefficients(const torch::Tensor& p);  // [D, 3] -> [D, K]
  torch::Tensor forward(const torch::Tensor& p);       // [D, 3] -> [D, outputs]

  // Buffers, fitted before the MLP is trained.
  torch::Tensor mean, basis;   // [outputs], [K, outputs]
  torch::Tensor slope, start;  // [3, K], [K]: line(p) = start + p slope

 private:
  torch::nn::Sequential mlp_{nullptr};
};
TORCH_MODULE(DesignNet);

}  // namespace pleat::learn
