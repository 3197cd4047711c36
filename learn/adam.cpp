#include "learn/adam.h"

#include <ATen/Parallel.h>

#include <cassert>
#include <cmath>

namespace pleat::learn {

using torch::Tensor;

Adam::Adam(torch::nn::Module& module) {
  const torch::NoGradGuard no_grad;
  int64_t count = 0;
  for (const Tensor& parameter : module.parameters()) count += parameter.numel();
  values = torch::zeros({count});
  gradients = torch::zeros({count});
  first_moment = torch::zeros({count});
  second_moment = torch::zeros({count});
  int64_t begin = 0;
  for (Tensor& parameter : module.parameters()) {
    const Tensor view = values.narrow(0, begin, parameter.numel()).view(parameter.sizes());
    view.copy_(parameter);
    parameter.set_data(view);
    parameter.mutable_grad() =
        gradients.narrow(0, begin, parameter.numel()).view(parameter.sizes());
    begin += parameter.numel();
  }
  average = values.clone();
}

void Adam::update(int64_t step, const AdamStep& options) {
  const double beta1 = 0.9, beta2 = 0.999, epsilon = 1e-8;
  const double norm = gradients.norm().item<double>();
  const double clip = norm > options.max_gradient_norm ? options.max_gradient_norm / norm : 1;
  const double exponent = static_cast<double>(step);
  const float rate = static_cast<float>(options.learning_rate / (1 - std::pow(beta1, exponent)));
  const float root_correction = static_cast<float>(1 / std::sqrt(1 - std::pow(beta2, exponent)));
  const float keep = static_cast<float>(1 - options.learning_rate * options.weight_decay);
  // Early on the average follows the weights closely, or it would remember the first random ones.
  const float decay =
      static_cast<float>(std::min(options.average_decay, (1 + exponent) / (10 + exponent)));
  float* value = values.data_ptr<float>();
  float* gradient = gradients.data_ptr<float>();
  float* first = first_moment.data_ptr<float>();
  float* second = second_moment.data_ptr<float>();
  float* mean = average.data_ptr<float>();
  const float scale = static_cast<float>(clip), b1 = static_cast<float>(beta1),
              b2 = static_cast<float>(beta2), e = static_cast<float>(epsilon);
  at::parallel_for(0, values.numel(), 1 << 16, [=](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) {
      const float g = gradient[i] * scale;
      first[i] = b1 * first[i] + (1 - b1) * g;
      second[i] = b2 * second[i] + (1 - b2) * g * g;
      value[i] = value[i] * keep - rate * first[i] / (std::sqrt(second[i]) * root_correction + e);
      mean[i] = decay * mean[i] + (1 - decay) * value[i];
      gradient[i] = 0;
    }
  });
}

void set_parameters(torch::nn::Module& module, const Tensor& values) {
  const torch::NoGradGuard no_grad;
  int64_t begin = 0;
  for (Tensor& parameter : module.parameters()) {
    parameter.copy_(values.narrow(0, begin, parameter.numel()).view(parameter.sizes()));
    begin += parameter.numel();
  }
  assert(begin == values.numel());
}

}  // namespace pleat::learn
