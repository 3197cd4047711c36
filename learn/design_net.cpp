#include "learn/design_net.h"

namespace pleat::learn {

namespace nn = torch::nn;
using torch::Tensor;

DesignNetImpl::DesignNetImpl(const std::vector<int>& hidden, int64_t components, int64_t outputs) {
  mean = register_buffer("mean", torch::zeros({outputs}));
  basis = register_buffer("basis", torch::zeros({components, outputs}));
  line_ = register_module("line", nn::Linear(3, components));
  mlp_ = register_module("mlp", nn::Sequential());
  int64_t in = 3;
  for (const int width : hidden) {
    mlp_->push_back(nn::Linear(in, width));
    mlp_->push_back(nn::SiLU());
    in = width;
  }
  mlp_->push_back(nn::Linear(in, components));
}

Tensor DesignNetImpl::coefficients(const Tensor& p) {
  const Tensor centred = 2 * p - 1;  // [0, 1] to [-1, 1]
  return line_(centred) + mlp_->forward(centred);
}

Tensor DesignNetImpl::forward(const Tensor& p) {
  return mean + torch::matmul(coefficients(p), basis);  // [D, outputs]
}

}  // namespace pleat::learn
