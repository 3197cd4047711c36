// The denoising network, default and the paper's, on 128 x 128 textures.
#include <string>

#include "learn/unet.h"
#include "tests/benchmarks/bench.h"

namespace pleat::bench {

void bench_learn(Report& report) {
  constexpr int64_t kResolution = 128, kFeatures = 200;
  torch::manual_seed(0);
  for (const bool is_paper : {false, true}) {
    const std::string name = is_paper ? "learn/unet_paper" : "learn/unet";
    const learn::UNetConfig config = is_paper ? learn::paper_unet() : learn::UNetConfig{};
    learn::UNet network(config, kResolution, kFeatures);
    report.add(name + "_parameters", 1e-6 * learn::parameter_count(*network), "million");
    const torch::Tensor y = torch::randn({1, config.input_channels, kResolution, kResolution});
    const torch::Tensor t = torch::full({1}, 50, torch::kInt64);
    const torch::Tensor c = torch::randn({1, kFeatures});
    network->eval();
    report.time(name + "_forward", is_paper ? 3 : 10, [&] {
      const torch::NoGradGuard no_grad;
      network->forward(y, t, c);
    });
    if (is_paper) continue;
    network->train();
    report.time(name + "_step", 5, [&] {
      network->zero_grad();
      network->forward(y, t, c).square().mean().backward();
    });
  }
}

}  // namespace pleat::bench
