#include "learn/design_net.h"

namespace pleat::learn {

namespace nn = torch::nn;
using torch::Tensor;

DesignNetImpl::DesignNetImpl(const std::vector<int>& hidden, int64_t components, int64_t outputs) {
  mean = register_buffer("mean", torch::zeros({outputs}));
  basis = register_buffer("basis", torch::zeros({components, outputs}));
  slope = register_buffer("slope", torch::zeros({3, components}));
  start = register_buffer("start", torch::zeros({components}));
  mlp_ = register_module("mlp", nn::Sequential());
  int64_t in = 3;
  for (const int width : hidden) {
    mlp_->push_back(nn::Linear(in, width));
    mlp_->push_back(nn::SiLU());
    in = width;
  }
  nn::Linear last(in, components);
  nn::init::zeros_(last->weight);  // starts as the line
  nn::init::zeros_(last->bias);
  mlp_->push_back(last);
}

Tensor DesignNetImpl::coefficients(const Tensor& p) {
  return start + torch::matmul(p, slope) + mlp_->forward(2 * p - 1);
}

Tensor DesignNetImpl::forward(const Tensor& p) {
  return mean + torch::matmul(coefficients(p), basis);  // [D, outputs]
}

}  // namespace pleat::learn
