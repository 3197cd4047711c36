#include "learn/train.h"

#include <torch/torch.h>

#include <chrono>
#include <cmath>
#include <deque>
#include <filesystem>
#include <fstream>
#include <limits>

#include "core/error.h"
#include "core/random.h"
#include "learn/adam.h"
#include "learn/batches.h"
#include "learn/checkpoint.h"
#include "learn/design_net.h"
#include "learn/diffusion.h"
#include "learn/threads.h"
#include "learn/unet.h"

namespace pleat::learn {
namespace {

using torch::Tensor;
using Clock = std::chrono::steady_clock;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr int64_t kStepsPerLine = 10;  // of the loss curve

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

void make_folder(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw InputError(folder + ": cannot be made: " + error.message());
}

// step, loss, validation_loss, seconds; lines after `last_step` of an earlier run are dropped.
class LossCurve {
 public:
  LossCurve(std::string path, int64_t last_step) : path_(std::move(path)) {
    std::string kept = "step,loss,validation_loss,seconds\n";
    std::ifstream earlier(path_);
    std::string line;
    std::getline(earlier, line);
    while (std::getline(earlier, line)) {
      if (std::strtoll(line.c_str(), nullptr, 10) <= last_step) kept += line + "\n";
    }
    earlier.close();
    write_file_atomically(path_, kept);
    file_.open(path_, std::ios::app);
  }
  void add(int64_t step, double loss, double validation_loss, double seconds) {
    file_ << step << ',' << loss << ',';
    if (std::isfinite(validation_loss)) file_ << validation_loss;
    file_ << ',' << seconds << '\n' << std::flush;
    if (!file_) throw InputError(path_ + ": cannot be written; is the disk full?");
  }

 private:
  std::string path_;
  std::ofstream file_;
};

double learning_rate(const TrainConfig& config, int64_t step) {
  const double kLast = 0.02;
  if (step < config.warmup_steps) {
    return config.learning_rate * static_cast<double>(step + 1) /
           static_cast<double>(config.warmup_steps);
  }
  const double along =
      static_cast<double>(step - config.warmup_steps) /
      static_cast<double>(std::max<int64_t>(1, config.steps - config.warmup_steps));
  return config.learning_rate * (kLast + (1 - kLast) * 0.5 * (1 + std::cos(M_PI * along)));
}

at::Generator generator_from(RandomStream& stream) {
  at::Generator generator = at::make_generator<at::CPUGeneratorImpl>(stream.next());
  return generator;
}

// Noised images of a batch with what the network is to say of them.
struct Noised {
  Tensor y, t, target;
};

// Times t are uniform over 1 .. T, one from each of B equal parts of it, which varies less than
// drawing each alone.
Noised add_noise(const Tensor& x0, const Tensor& mask, const Schedule& schedule,
                 Prediction prediction, RandomStream stream) {
  const int64_t batch = x0.size(0);
  const double shift = stream.uniform();
  std::vector<int64_t> times;
  for (int64_t i = 0; i < batch; ++i) {
    const double part = (static_cast<double>(i) + shift) / static_cast<double>(batch);
    times.push_back(1 + static_cast<int64_t>(part * schedule.steps));
  }
  Noised noised;
  noised.t = torch::tensor(times);
  const NoiseLevel level = noise_level(schedule, noised.t);
  const Tensor epsilon = torch::randn(x0.sizes(), generator_from(stream)) * mask;
  noised.y = level.signal * x0 + level.noise * epsilon;
  noised.target = target(prediction, x0, epsilon, level);
  return noised;
}

// One training: what the loop of train_diffusion moves.
struct Training {
  Training(const TrainConfig& train_config, const TextureDataset& texture_dataset)
      : config(train_config),
        dataset(texture_dataset),
        normalisation(read_normalisation(texture_dataset)),
        schedule(make_schedule(train_config.diffusion_steps)),
        prediction(prediction_from(train_config.prediction)),
        network(train_config.network, texture_dataset.resolution(),
                feature_count(texture_dataset.joints(), texture_dataset.shape_count())),
        adam(*network) {}

  Tensor loss_of(const std::vector<int64_t>& rows, const RandomStream& stream) {
    const Tensor x0 = normalise_textures(normalisation, dataset.textures(rows));
    const Tensor c = normalise_features(normalisation, dataset.features(rows));
    const Noised noised = add_noise(x0, normalisation.mask, schedule, prediction, stream);
    return masked_loss(network(noised.y, noised.t, c), noised.target, normalisation.mask);
  }

  const TrainConfig& config;
  const TextureDataset& dataset;
  Normalisation normalisation;
  Schedule schedule;
  Prediction prediction;
  UNet network;
  Adam adam;
  int64_t step = 0;    // done
  double seconds = 0;  // spent
};

double train_step(Training& training) {
  const TrainConfig& config = training.config;
  const std::vector<int64_t> rows =
      batch_rows(training.dataset.training_rows(), config.seed, training.step, config.batch_size);
  const RandomStream stream(config.seed, "train/noise/" + std::to_string(training.step));
  const Tensor loss = training.loss_of(rows, stream);
  const double value = loss.item<double>();
  if (!std::isfinite(value)) {
    throw InputError("train.learning_rate = " + std::to_string(config.learning_rate) +
                     ": the loss was no longer finite at step " + std::to_string(training.step) +
                     "; expected a smaller rate");
  }
  loss.backward();
  AdamStep options;
  options.learning_rate = learning_rate(config, training.step);
  options.weight_decay = config.weight_decay;
  options.average_decay = config.average_decay;
  options.max_gradient_norm = config.max_gradient_norm;
  ++training.step;
  training.adam.update(training.step, options);
  return value;
}

// Of the averaged weights, on held-out rows with the same noise each time. NaN without such rows.
double validation_loss(Training& training) {
  const TrainConfig& config = training.config;
  const std::vector<int64_t> rows =
      spread(training.dataset.held_out_rows(), config.validation_rows);
  if (rows.empty()) return kNone;
  const torch::NoGradGuard no_grad;
  const Tensor weights = training.adam.values.clone();
  training.adam.values.copy_(training.adam.average);
  double sum = 0;
  for (size_t begin = 0; begin < rows.size(); begin += static_cast<size_t>(config.batch_size)) {
    const size_t end = std::min(rows.size(), begin + static_cast<size_t>(config.batch_size));
    const std::vector<int64_t> part(rows.begin() + static_cast<int64_t>(begin),
                                    rows.begin() + static_cast<int64_t>(end));
    const RandomStream stream(config.seed, "train/validation/" + std::to_string(begin));
    sum += training.loss_of(part, stream).item<double>() * static_cast<double>(part.size());
  }
  training.adam.values.copy_(weights);
  return sum / static_cast<double>(rows.size());
}

void save(Training& training, const std::string& path, const Provenance& provenance) {
  DiffusionCheckpoint checkpoint;
  checkpoint.config = training.config;
  checkpoint.normalisation = training.normalisation;
  checkpoint.joints = training.dataset.joints();
  checkpoint.shape_count = training.dataset.shape_count();
  checkpoint.step = training.step;
  checkpoint.seconds = training.seconds;
  int64_t begin = 0;
  for (const auto& [name, tensor] : named_weights(*training.network)) {
    checkpoint.weights.emplace_back(
        name, training.adam.average.narrow(0, begin, tensor.numel()).view(tensor.sizes()));
    begin += tensor.numel();
  }
  write_diffusion_checkpoint(path, checkpoint, training.adam, provenance);
}

bool is_same(const Tensor& a, const Tensor& b) { return a.sizes() == b.sizes() && a.equal(b); }

void resume(Training& training, const std::string& path) {
  const DiffusionCheckpoint checkpoint = read_diffusion_checkpoint(path);
  const auto earlier = options_of(checkpoint.config);
  for (const auto& [key, value] : options_of(training.config)) {
    if (key != "train.steps" && earlier.at(key) != value) {
      throw InputError(path + " was trained with " + key + " = " + earlier.at(key) + ", not " +
                       value + "; expected the same, or another folder");
    }
  }
  const Normalisation &a = checkpoint.normalisation, &b = training.normalisation;
  if (!is_same(a.mask, b.mask) || !is_same(a.texture_mean, b.texture_mean) ||
      !is_same(a.texture_std, b.texture_std) || !is_same(a.feature_mean, b.feature_mean)) {
    throw InputError(path + " was trained on another dataset than " + training.dataset.path() +
                     "; expected the same, or another folder");
  }
  read_training_state(path, training.adam);
  training.step = checkpoint.step;
  training.seconds = checkpoint.seconds;
}

}  // namespace

TrainResult train_diffusion(const TrainConfig& config, const std::string& dataset_path,
                            const std::string& folder, const Provenance& provenance,
                            const std::function<bool()>& should_stop) {
  validate(config);
  use_threads(config.threads);
  TextureDataset dataset(dataset_path);
  dataset.preload(config.preload_mb);
  make_folder(folder);
  TrainResult result;
  result.checkpoint = folder + "/diffusion.h5";

  torch::manual_seed(RandomStream(config.seed, "train/weights").next());
  Training training(config, dataset);
  if (std::filesystem::exists(result.checkpoint)) resume(training, result.checkpoint);
  result.parameters = parameter_count(*training.network);
  result.validation_loss = kNone;
  LossCurve curve(folder + "/diffusion_loss.csv", training.step);
  Progress progress("train", config.steps, "steps");
  progress.advance(training.step);

  const double seconds_before = training.seconds;
  const Clock::time_point start = Clock::now();
  Clock::time_point saved = start;
  std::deque<double> losses;  // of the last steps
  const auto mean_of_last = [&](size_t count) {
    count = std::min(count, losses.size());
    double sum = 0;
    for (size_t i = losses.size() - count; i < losses.size(); ++i) sum += losses[i];
    return count == 0 ? kNone : sum / static_cast<double>(count);
  };
  int64_t saved_step = training.step;
  while (training.step < config.steps) {
    losses.push_back(train_step(training));
    if (losses.size() > 100) losses.pop_front();
    const bool is_last = training.step == config.steps;
    double validation = kNone;
    if (is_last || training.step % config.validate_every_steps == 0) {
      validation = validation_loss(training);
      result.validation_loss = validation;
    }
    training.seconds = seconds_before + seconds_since(start);
    const double loss = mean_of_last(kStepsPerLine);
    if (is_last || std::isfinite(validation) || training.step % kStepsPerLine == 0) {
      curve.add(training.step, loss, validation, training.seconds);
    }
    char remark[32];
    std::snprintf(remark, sizeof remark, "loss %.4f", loss);
    progress.advance(1, remark);
    if (is_last) break;
    if (should_stop()) {
      result.status = TrainStatus::kInterrupted;
      break;
    }
    if (config.max_minutes > 0 && training.seconds > 60 * config.max_minutes) {
      result.status = TrainStatus::kTimeUp;
      break;
    }
    if (seconds_since(saved) > 60 * config.checkpoint_minutes) {
      save(training, result.checkpoint, provenance);
      saved = Clock::now();
      saved_step = training.step;
    }
  }
  if (training.step != saved_step) save(training, result.checkpoint, provenance);
  if (result.status != TrainStatus::kInterrupted && !std::isfinite(result.validation_loss)) {
    result.validation_loss = validation_loss(training);
  }
  result.step = training.step;
  result.seconds = training.seconds;
  result.loss = mean_of_last(losses.size());
  return result;
}

namespace {

// The dataset's designs as G_design sees them.
struct Designs {
  std::vector<std::string> names;
  std::vector<bool> is_held_out;
  Tensor parameters;  // [D, 3]
  Tensor outputs;     // [D, 3 N + 2 M]: vertices (m), then UVs
  int64_t vertices = 0, uvs = 0;
};

Designs read_designs(const std::string& path) {
  const Hdf5File file = Hdf5File::open(path);
  const auto refuse = [&](const std::string& array, const std::string& expected) {
    throw InputError(path + ": " + array + " has a wrong shape; expected " + expected);
  };
  Designs designs;
  const Dims dims = file.dims("designs/vertices");
  if (dims.size() != 3 || dims[0] < 1 || dims[1] < 1 || dims[2] != 3) {
    refuse("designs/vertices", "[D, N, 3]");
  }
  if (file.dims("designs/parameters") != Dims{dims[0], 3}) refuse("designs/parameters", "[D, 3]");
  const Dims uv_dims = file.dims("garment/uv");
  if (uv_dims.size() != 2 || uv_dims[0] < 1 || uv_dims[1] != 2) refuse("garment/uv", "[M, 2]");
  designs.vertices = dims[1];
  designs.uvs = uv_dims[0];
  const Tensor uv = read_tensor(file, "garment/uv").view({1, 2 * designs.uvs});
  designs.parameters = read_tensor(file, "designs/parameters");
  designs.outputs = torch::cat({read_tensor(file, "designs/vertices").view({dims[0], 3 * dims[1]}),
                                uv.expand({dims[0], 2 * designs.uvs})},
                               1);
  designs.names = file.read_texts("designs/names");
  const std::vector<uint8_t> held_out = file.read<uint8_t>("designs/held_out");
  if (static_cast<int64_t>(designs.names.size()) != dims[0]) refuse("designs/names", "[D]");
  if (static_cast<int64_t>(held_out.size()) != dims[0]) refuse("designs/held_out", "[D]");
  for (const uint8_t value : held_out) designs.is_held_out.push_back(value != 0);
  return designs;
}

std::vector<DesignError> design_errors(DesignNet& network, const Designs& designs) {
  const torch::NoGradGuard no_grad;
  const int64_t count = designs.parameters.size(0);
  const Tensor error = (network(designs.parameters) - designs.outputs)
                           .narrow(1, 0, 3 * designs.vertices)
                           .view({count, designs.vertices, 3})
                           .norm(2, 2);  // [D, N]
  std::vector<DesignError> errors;
  for (int64_t i = 0; i < count; ++i) {
    const size_t d = static_cast<size_t>(i);
    errors.push_back({designs.names[d], designs.is_held_out[d],
                      1e3 * error[i].mean().item<double>(), 1e3 * error[i].max().item<double>()});
  }
  return errors;
}

double mean_error(const std::vector<DesignError>& errors, bool is_held_out) {
  double sum = 0, count = 0;
  for (const DesignError& error : errors) {
    if (error.is_held_out != is_held_out) continue;
    sum += error.mean_mm;
    count += 1;
  }
  return count == 0 ? kNone : sum / count;
}

// Centre and principal directions of the training designs, scaled to unit variance.
void fit_basis(DesignNet& network, const Tensor& outputs) {
  const torch::NoGradGuard no_grad;
  network->mean.copy_(outputs.mean(0));
  // The covariance between designs is small, D x D: its eigenvectors give the directions.
  const Tensor centred = (outputs - network->mean).to(torch::kFloat64);
  const auto [values, vectors] = torch::linalg_eigh(torch::matmul(centred, centred.t()));
  const int64_t designs = outputs.size(0), components = network->basis.size(0);
  network->basis.zero_();
  for (int64_t k = 0; k < components; ++k) {
    const int64_t column = designs - 1 - k;  // eigenvalues ascend
    if (values[column].item<double>() <= 1e-12) break;
    const Tensor direction = torch::matmul(vectors.select(1, column), centred);
    network->basis[k].copy_(direction / std::sqrt(static_cast<double>(designs)));
  }
}

// Least squares from p to the coordinates in the basis; of all that fit equally, the flattest.
void fit_line(DesignNet& network, const Tensor& parameters, const Tensor& aim) {
  const torch::NoGradGuard no_grad;
  const Tensor p = parameters.to(torch::kFloat64), a = aim.to(torch::kFloat64);
  const Tensor p_mean = p.mean(0, true), a_mean = a.mean(0, true);
  const Tensor slope = torch::matmul(torch::linalg_pinv(p - p_mean, 1e-6), a - a_mean);  // [3, K]
  network->slope.copy_(slope);
  network->start.copy_((a_mean - torch::matmul(p_mean, slope)).squeeze(0));
}

}  // namespace

TrainDesignResult train_design(const TrainDesignConfig& config, const std::string& dataset,
                               const std::string& folder, const Provenance& provenance,
                               const std::function<bool()>& should_stop) {
  validate(config);
  use_threads(config.threads);
  const Clock::time_point start = Clock::now();
  const Designs designs = read_designs(dataset);
  std::vector<int64_t> training;
  for (size_t i = 0; i < designs.names.size(); ++i) {
    if (!designs.is_held_out[i]) training.push_back(static_cast<int64_t>(i));
  }
  if (training.empty()) {
    throw InputError(dataset + ": designs/held_out is 1 everywhere; expected designs to train on");
  }
  make_folder(folder);
  const Tensor parameters = designs.parameters.index_select(0, torch::tensor(training));
  const Tensor outputs = designs.outputs.index_select(0, torch::tensor(training));
  const int64_t components =
      std::min<int64_t>(config.components, std::max<int64_t>(1, parameters.size(0) - 1));

  torch::manual_seed(RandomStream(config.seed, "train_design/weights").next());
  DesignNet network(config.hidden, components, outputs.size(1));
  fit_basis(network, outputs);
  // Squared error of the outputs, by way of their coordinates in the basis, which is orthogonal.
  const Tensor lengths = network->basis.square().sum(1);  // [K]
  const Tensor aim = torch::matmul(outputs - network->mean, network->basis.t()) /
                     lengths.clamp_min(1e-20);  // [D, K]
  fit_line(network, parameters, aim);
  const Tensor importance = lengths / lengths.sum().clamp_min(1e-20);
  Adam adam(*network);
  LossCurve curve(folder + "/design_loss.csv", 0);
  Progress progress("train design", config.steps, "steps");
  TrainDesignResult result;
  for (int64_t step = 1; step <= config.steps; ++step) {
    const Tensor loss =
        ((network->coefficients(parameters) - aim).square() * importance).sum(1).mean();
    const double value = loss.item<double>();
    if (!std::isfinite(value)) {
      throw InputError("train_design.learning_rate = " + std::to_string(config.learning_rate) +
                       ": the loss was no longer finite; expected a smaller rate");
    }
    loss.backward();
    AdamStep options;
    const double along = static_cast<double>(step) / static_cast<double>(config.steps);
    options.learning_rate =
        config.learning_rate * (0.01 + 0.99 * 0.5 * (1 + std::cos(M_PI * along)));
    options.weight_decay = config.weight_decay;
    adam.update(step, options);
    if (step % 100 == 0 || step == config.steps) {
      curve.add(step, value, kNone, seconds_since(start));
      if (should_stop()) {
        result.status = TrainStatus::kInterrupted;
        return result;
      }
    }
    progress.advance(1);
  }
  result.designs = design_errors(network, designs);
  result.train_error_mm = mean_error(result.designs, false);
  result.held_out_error_mm = mean_error(result.designs, true);

  result.checkpoint = folder + "/design.h5";
  Hdf5File file = Hdf5File::create(result.checkpoint);
  write_kind(file, "design");
  write_provenance(file, provenance);
  write_weights(file, named_weights(*network));
  file.write("network/hidden", config.hidden, {static_cast<int64_t>(config.hidden.size())});
  file.write_attribute("network", "vertices", designs.vertices);
  file.write_attribute("network", "uvs", designs.uvs);
  file.commit();
  result.seconds = seconds_since(start);
  return result;
}

}  // namespace pleat::learn
