#include "synthetic_dataset.h"

#include <stdlib.h>

#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <vector>

#include "core/hdf5_file.h"
#include "core/random.h"

namespace pleat::learn {
namespace {

constexpr double kScale = 1e-5;  // m

// Waves whose direction turns and whose height grows with the pose, over the part of the square
// inside the mask.
double offset(int channel, double u, double v, const double* pose, const double* shape,
              const double* design) {
  const double phase = 2 * pose[3] + 2 * design[0];
  const double wave = std::sin(6 * u + 2 * pose[4] * v + phase + channel);
  return 0.01 * (channel - 1) + 0.02 * (1 + 0.3 * shape[0]) * wave + 0.02 * pose[5] * (u - v) +
         0.02 * design[1] * v;
}

bool is_inside(double u, double v) { return std::hypot(u - 0.5, v - 0.5) < 0.45; }

}  // namespace

void write_synthetic_dataset(const std::string& path, const SyntheticDataset& options) {
  const int64_t frames = options.frames, side = options.resolution, joints = options.joints;
  Hdf5File file = Hdf5File::create(path);
  const auto wants = [&](const std::string& name) { return name != options.left_out; };
  RandomStream random(7, "synthetic");

  std::vector<float> parameters, vertices, uv;
  std::vector<uint8_t> held_out;
  std::vector<std::string> names;
  for (int d = 0; d < options.designs; ++d) {
    for (int k = 0; k < 3; ++k) parameters.push_back(static_cast<float>(random.uniform()));
    const float* p = &parameters[static_cast<size_t>(3 * d)];
    for (int n = 0; n < options.vertices; ++n) {  // straight lines in p
      const double angle = n;
      vertices.push_back(static_cast<float>(0.2 * std::cos(angle) * (1 + 0.3 * p[0])));
      vertices.push_back(static_cast<float>(0.02 * n - 0.5 * p[0] * (n % 3)));
      vertices.push_back(static_cast<float>(0.2 * std::sin(angle) + 0.1 * p[1] - 0.05 * p[2]));
    }
    held_out.push_back(d + 1 == options.designs);
    names.push_back("design_" + std::to_string(d));
  }
  for (int n = 0; n < 2 * options.uvs; ++n) uv.push_back(static_cast<float>(random.uniform()));
  const int64_t designs = options.designs;
  if (wants("designs/parameters")) file.write("designs/parameters", parameters, {designs, 3});
  if (wants("designs/vertices")) {
    file.write("designs/vertices", vertices, {designs, options.vertices, 3});
  }
  file.write("designs/held_out", held_out, {designs});
  file.write("designs/names", names);
  file.write("garment/uv", uv, {options.uvs, 2});

  std::vector<uint8_t> mask, split;
  std::vector<float> pose, shape;
  std::vector<int32_t> design_index;
  std::vector<int16_t> textures;
  std::vector<double> mean(3, 0), square(3, 0);
  double count = 0;
  const auto centre = [&](int64_t i) {
    return (static_cast<double>(i) + 0.5) / static_cast<double>(side);
  };
  for (int64_t i = 0; i < side * side; ++i)
    mask.push_back(is_inside(centre(i % side), centre(i / side)));
  for (int64_t f = 0; f < frames; ++f) {
    for (int64_t k = 0; k < 3 * joints; ++k) {
      pose.push_back(static_cast<float>(0.8 * (2 * random.uniform() - 1)));
    }
    for (int k = 0; k < options.shape_count; ++k) {
      shape.push_back(static_cast<float>(random.normal()));
    }
    design_index.push_back(static_cast<int32_t>(random.below(options.designs)));
    const size_t design = static_cast<size_t>(design_index.back());
    const bool is_held_out = held_out[design] || random.uniform() < options.held_out_share;
    split.push_back(is_held_out ? (held_out[design] ? 1 : 2) : 0);
    const std::vector<double> theta(pose.end() - 3 * joints, pose.end());
    const std::vector<double> beta(shape.end() - options.shape_count, shape.end());
    const std::vector<double> p(parameters.begin() + 3 * design_index.back(),
                                parameters.begin() + 3 * design_index.back() + 3);
    for (int channel = 0; channel < 3; ++channel) {
      for (int64_t i = 0; i < side * side; ++i) {
        const double u = centre(i % side), v = centre(i / side);
        const double value =
            is_inside(u, v) ? offset(channel, u, v, theta.data(), beta.data(), p.data()) : 0;
        textures.push_back(static_cast<int16_t>(std::lround(value / kScale)));
        if (is_inside(u, v) && !is_held_out) {
          mean[static_cast<size_t>(channel)] += value;
          square[static_cast<size_t>(channel)] += value * value;
          count += 1.0 / 3;
        }
      }
    }
  }
  std::vector<float> means, deviations;
  for (size_t channel = 0; channel < 3; ++channel) {
    means.push_back(static_cast<float>(count > 0 ? mean[channel] / count : 0));
    deviations.push_back(static_cast<float>(
        count > 0 ? std::sqrt(square[channel] / count - std::pow(mean[channel] / count, 2)) : 1));
  }
  if (wants("textures")) {
    file.write("textures", textures, {frames, 3, side, side});
    file.write_attribute("textures", "scale_m", kScale);
  }
  if (wants("mask")) file.write("mask", mask, {side, side});
  if (wants("pose")) file.write("pose", pose, {frames, joints, 3});
  if (wants("shape")) file.write("shape", shape, {frames, options.shape_count});
  if (wants("design_index")) file.write("design_index", design_index, {frames});
  if (wants("split")) file.write("split", split, {frames});
  if (wants("normalisation/mean")) file.write("normalisation/mean", means, {3});
  if (wants("normalisation/std")) file.write("normalisation/std", deviations, {3});
  file.commit();
}

TemporaryFolder::TemporaryFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "pleat_learn_XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace pleat::learn
