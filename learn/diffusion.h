// Denoising diffusion of textures (paper, section 4.1; Ho et al. 2020). Images are normalised, [B,
// 3, R, R]; texels outside the mask are 0 in the data and stay 0 in the noised images: they are no
// part of the process.
#pragma once

#include <torch/torch.h>

#include <functional>
#include <string>
#include <vector>

namespace pleat::learn {

// Index t = 0 .. T; alpha_bar[0] = 1 is the data.
struct Schedule {
  int steps = 0;                  // T
  std::vector<double> alpha;      // [T + 1], alpha[0] = 1
  std::vector<double> alpha_bar;  // [T + 1], product of alpha up to t
};
// 1 - alpha rises linearly from 0.1 / T to 20 / T: the schedule of Ho et al. at T = 1000,
// stretched, so that every T ends in noise. At T = 100 alpha_bar[T] = 2e-5, where 0.02 as the last
// value would leave a third of the signal.
Schedule make_schedule(int steps);

enum class Prediction { kX0, kV, kEpsilon };
Prediction prediction_from(const std::string& name);  // x0, v, epsilon

struct NoiseLevel {      // y = signal x0 + noise epsilon
  torch::Tensor signal;  // [B, 1, 1, 1], sqrt(alpha_bar)
  torch::Tensor noise;   // [B, 1, 1, 1], sqrt(1 - alpha_bar)
};
NoiseLevel noise_level(const Schedule& schedule, const torch::Tensor& t);  // t: int64 [B]

// What the network is to predict, and back. v = signal epsilon - noise x0 (Salimans and Ho 2022).
torch::Tensor target(Prediction prediction, const torch::Tensor& x0, const torch::Tensor& epsilon,
                     const NoiseLevel& level);
torch::Tensor x0_from(Prediction prediction, const torch::Tensor& output, const torch::Tensor& y,
                      const NoiseLevel& level);

// Mean of the squared error over channels and texels inside the mask. mask: [1, 1, R, R], 1 inside;
// gives [].
torch::Tensor masked_loss(const torch::Tensor& output, const torch::Tensor& target,
                          const torch::Tensor& mask);

struct SamplerProblem {
  Schedule schedule;
  Prediction prediction = Prediction::kX0;
  torch::Tensor mask;  // [1, 1, R, R]
  double limit = 0;    // |x0| is cut to this, as the data never exceed it
  std::function<torch::Tensor(const torch::Tensor& y, const torch::Tensor& t)> network;
  std::function<torch::Tensor()> next_noise;  // [B, 3, R, R], standard normal
};
// All T steps with the posterior of Ho et al. (their algorithm 2 and equation 7). The paper's
// equation 3 prints sqrt(1 - alpha_t) in the place of (1 - alpha_t) / sqrt(1 - alpha_bar_t) and
// leaves out the noise; taken literally it does not invert the forward process.
torch::Tensor sample_ddpm(const SamplerProblem& problem);
// steps of the T, evenly spaced, without noise on the way (Song et al. 2021, eta = 0).
torch::Tensor sample_ddim(const SamplerProblem& problem, int steps);

}  // namespace pleat::learn
