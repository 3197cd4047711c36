#include "learn/diffusion.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace pleat::learn {

using torch::Tensor;

Schedule make_schedule(int steps) {
  assert(steps >= 25);
  Schedule schedule;
  schedule.steps = steps;
  schedule.alpha = {1};
  schedule.alpha_bar = {1};
  for (int t = 1; t <= steps; ++t) {
    const double beta = (0.1 + (20 - 0.1) * (t - 1) / (steps - 1)) / steps;
    schedule.alpha.push_back(1 - beta);
    schedule.alpha_bar.push_back(schedule.alpha_bar.back() * (1 - beta));
  }
  return schedule;
}

Prediction prediction_from(const std::string& name) {
  if (name == "epsilon") return Prediction::kEpsilon;
  if (name == "v") return Prediction::kV;
  assert(name == "x0");
  return Prediction::kX0;
}

NoiseLevel noise_level(const Schedule& schedule, const Tensor& t) {
  const Tensor alpha_bar =
      torch::tensor(schedule.alpha_bar, torch::kFloat64).index_select(0, t).view({-1, 1, 1, 1});
  return {alpha_bar.sqrt().to(torch::kFloat32), (1 - alpha_bar).sqrt().to(torch::kFloat32)};
}

Tensor target(Prediction prediction, const Tensor& x0, const Tensor& epsilon,
              const NoiseLevel& level) {
  if (prediction == Prediction::kEpsilon) return epsilon;
  if (prediction == Prediction::kV) return level.signal * epsilon - level.noise * x0;
  return x0;
}

Tensor x0_from(Prediction prediction, const Tensor& output, const Tensor& y,
               const NoiseLevel& level) {
  if (prediction == Prediction::kEpsilon) return (y - level.noise * output) / level.signal;
  if (prediction == Prediction::kV) return level.signal * y - level.noise * output;
  return output;
}

Tensor masked_loss(const Tensor& output, const Tensor& target, const Tensor& mask) {
  const Tensor squared = (output - target).square() * mask;
  return squared.sum() / (mask.sum() * static_cast<double>(output.size(0) * output.size(1)));
}

namespace {

Tensor predict_x0(const SamplerProblem& problem, const Tensor& y, int step) {
  const Tensor t = torch::full({y.size(0)}, int64_t{step}, torch::kInt64);
  const Tensor x0 =
      x0_from(problem.prediction, problem.network(y, t), y, noise_level(problem.schedule, t));
  return x0.clamp(-problem.limit, problem.limit) * problem.mask;
}

}  // namespace

Tensor sample_ddpm(const SamplerProblem& problem) {
  const Schedule& schedule = problem.schedule;
  Tensor y = problem.next_noise() * problem.mask;
  for (int t = schedule.steps; t >= 1; --t) {
    const size_t i = static_cast<size_t>(t);
    const double alpha = schedule.alpha[i], bar = schedule.alpha_bar[i],
                 previous_bar = schedule.alpha_bar[i - 1];
    const Tensor x0 = predict_x0(problem, y, t);
    y = x0 * (std::sqrt(previous_bar) * (1 - alpha) / (1 - bar)) +
        y * (std::sqrt(alpha) * (1 - previous_bar) / (1 - bar));
    if (t > 1) {
      const double variance = (1 - alpha) * (1 - previous_bar) / (1 - bar);
      y = y + problem.next_noise() * problem.mask * std::sqrt(variance);
    }
  }
  return y;
}

Tensor sample_ddim(const SamplerProblem& problem, int steps) {
  const Schedule& schedule = problem.schedule;
  const int count = std::min(steps, schedule.steps);
  const auto time_of = [&](int i) {  // i = count: T; i = 0: the data
    return static_cast<int>(std::lround(static_cast<double>(schedule.steps) * i / count));
  };
  Tensor y = problem.next_noise() * problem.mask;
  for (int i = count; i >= 1; --i) {
    const double bar = schedule.alpha_bar[static_cast<size_t>(time_of(i))];
    const double next_bar = schedule.alpha_bar[static_cast<size_t>(time_of(i - 1))];
    const Tensor x0 = predict_x0(problem, y, time_of(i));
    const Tensor epsilon = (y - x0 * std::sqrt(bar)) / std::sqrt(1 - bar);
    y = x0 * std::sqrt(next_bar) + epsilon * std::sqrt(1 - next_bar);
  }
  return y;
}

}  // namespace pleat::learn
