#include "learn/diffusion.h"

#include <gtest/gtest.h>

#include <cmath>

namespace pleat::learn {
namespace {

using torch::Tensor;

double largest(const Tensor& tensor) { return tensor.abs().max().item<double>(); }

Tensor round_mask() {
  Tensor mask = torch::zeros({1, 1, 8, 8});
  mask.slice(2, 1, 7).slice(3, 2, 6).fill_(1);
  return mask;
}

TEST(Schedule, EndsInNoiseForEveryLength) {
  for (const int steps : {25, 50, 100, 1000, 4000}) {
    const Schedule schedule = make_schedule(steps);
    ASSERT_EQ(schedule.alpha_bar.size(), static_cast<size_t>(steps) + 1);
    EXPECT_EQ(schedule.alpha_bar[0], 1);
    for (size_t t = 1; t < schedule.alpha_bar.size(); ++t) {
      EXPECT_GT(schedule.alpha[t], 0);
      EXPECT_LT(schedule.alpha_bar[t], schedule.alpha_bar[t - 1]);
    }
    EXPECT_LT(schedule.alpha_bar.back(), 1e-4);
  }
  // Ho et al. 2020: 1e-4 to 0.02 over 1000 steps.
  EXPECT_NEAR(make_schedule(1000).alpha[1], 1 - 1e-4, 1e-12);
  EXPECT_NEAR(make_schedule(1000).alpha[1000], 1 - 0.02, 1e-12);
}

TEST(Prediction, EveryTargetGivesTheDataBack) {
  torch::manual_seed(2);
  const Schedule schedule = make_schedule(100);
  const Tensor x0 = torch::randn({3, 3, 8, 8}), epsilon = torch::randn({3, 3, 8, 8});
  const NoiseLevel level =
      noise_level(schedule, torch::tensor({int64_t{1}, int64_t{30}, int64_t{70}}));
  EXPECT_LT(largest(level.signal.square() + level.noise.square() - 1), 1e-6);
  const Tensor y = level.signal * x0 + level.noise * epsilon;
  for (const char* name : {"x0", "v", "epsilon"}) {
    const Prediction prediction = prediction_from(name);
    const Tensor back = x0_from(prediction, target(prediction, x0, epsilon, level), y, level);
    EXPECT_LT(largest(back - x0), 1e-4) << name;
  }
}

TEST(MaskedLoss, CountsOnlyTexelsInside) {
  const Tensor mask = round_mask();
  Tensor error = torch::full({2, 3, 8, 8}, 3.0) * mask + 100 * (1 - mask);
  EXPECT_NEAR(masked_loss(error, torch::zeros_like(error), mask).item<double>(), 9, 1e-5);
}

// A network that knows the answer: what it says is exact for the x0 it was made with.
SamplerProblem perfect_problem(Prediction prediction, const Tensor& x0, const Tensor& mask) {
  SamplerProblem problem;
  problem.schedule = make_schedule(100);
  problem.prediction = prediction;
  problem.mask = mask;
  problem.limit = 10;
  const Schedule schedule = problem.schedule;
  problem.network = [=](const Tensor& y, const Tensor& t) {
    const NoiseLevel level = noise_level(schedule, t);
    const Tensor epsilon = (y - level.signal * x0) / level.noise;
    return target(prediction, x0, epsilon, level);
  };
  problem.next_noise = [x0] { return torch::randn(x0.sizes()); };
  return problem;
}

TEST(Samplers, FindTheDataWithAPerfectPredictor) {
  torch::manual_seed(3);
  const Tensor mask = round_mask();
  const Tensor x0 = torch::randn({2, 3, 8, 8}) * mask;
  for (const char* name : {"x0", "v", "epsilon"}) {
    const SamplerProblem problem = perfect_problem(prediction_from(name), x0, mask);
    for (const int steps : {1, 2, 10, 100, 1000}) {
      EXPECT_LT(largest(sample_ddim(problem, steps) - x0), 1e-2) << name << ' ' << steps;
    }
    EXPECT_LT(largest(sample_ddpm(problem) - x0), 1e-2) << name;
  }
}

// Data N(m, s^2) in every texel has a known best x0 and noise; the samplers must give back mean and
// spread.
TEST(Samplers, DrawTheDistributionOfGaussianData) {
  torch::manual_seed(4);
  const double mean = 0.7, deviation = 0.5;
  SamplerProblem problem;
  problem.schedule = make_schedule(1000);
  problem.mask = torch::ones({1, 1, 32, 32});
  problem.limit = 100;
  const Schedule schedule = problem.schedule;
  problem.network = [=](const Tensor& y, const Tensor& t) {
    const NoiseLevel level = noise_level(schedule, t);
    const Tensor variance = level.signal.square() * deviation * deviation + level.noise.square();
    return mean + level.signal * deviation * deviation / variance * (y - level.signal * mean);
  };
  problem.next_noise = [] { return torch::randn({4, 3, 32, 32}); };
  for (const bool is_ddpm : {false, true}) {
    const Tensor drawn = is_ddpm ? sample_ddpm(problem) : sample_ddim(problem, 1000);
    // 12288 numbers: the mean's standard error is 0.005; 1000 steps shrink the spread by about 1 %.
    EXPECT_NEAR(drawn.mean().item<double>(), mean, 0.02) << is_ddpm;
    EXPECT_NEAR(drawn.std().item<double>(), deviation, 0.02) << is_ddpm;
  }
}

TEST(Samplers, LeaveTexelsOutsideTheMaskAtZero) {
  const Tensor mask = round_mask();
  SamplerProblem problem = perfect_problem(Prediction::kX0, torch::ones({1, 3, 8, 8}), mask);
  EXPECT_EQ(largest(sample_ddim(problem, 5) * (1 - mask)), 0);
  EXPECT_EQ(largest(sample_ddpm(problem) * (1 - mask)), 0);
}

}  // namespace
}  // namespace pleat::learn
