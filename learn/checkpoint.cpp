#include "learn/checkpoint.h"

#include <cmath>
#include <map>
#include <sstream>

#include "core/error.h"

namespace pleat::learn {
namespace {

using torch::Tensor;

// The options by name, as section `train.network` and `train` have them.
template <typename Config, typename Visit>
void visit_network(Config& config, Visit&& visit) {
  visit("block_channels", config.block_channels);
  visit("attention_blocks", config.attention_blocks);
  visit("layers_per_block", config.layers_per_block);
  visit("patch", config.patch);
  visit("norm_groups", config.norm_groups);
  visit("attention_head_channels", config.attention_head_channels);
  visit("condition_features", config.condition_features);
  visit("input_channels", config.input_channels);
  visit("scale_shift", config.scale_shift);
}

template <typename Config, typename Visit>
void visit_train(Config& config, Visit&& visit) {
  visit("diffusion_steps", config.diffusion_steps);
  visit("prediction", config.prediction);
  visit("batch_size", config.batch_size);
  visit("steps", config.steps);
  visit("learning_rate", config.learning_rate);
  visit("warmup_steps", config.warmup_steps);
  visit("weight_decay", config.weight_decay);
  visit("max_gradient_norm", config.max_gradient_norm);
  visit("average_decay", config.average_decay);
  visit("validate_every_steps", config.validate_every_steps);
  visit("validation_rows", config.validation_rows);
  visit("seed", config.seed);
}

// Every option as text: exact for doubles, legible in h5dump.
template <typename T>
std::string option_text(const T& value) {
  std::ostringstream text;
  text.precision(17);
  text << value;
  return text.str();
}
std::string option_text(const std::vector<int>& values) {
  std::string text;
  for (const int value : values) text += (text.empty() ? "" : " ") + std::to_string(value);
  return text;
}

template <typename T>
bool parse_option(const std::string& text, T& value) {
  std::istringstream stream(text);
  return static_cast<bool>(stream >> value) && (stream >> std::ws).eof();
}
bool parse_option(const std::string& text, std::vector<int>& values) {
  std::istringstream stream(text);
  values.clear();
  for (int value = 0; stream >> value;) values.push_back(value);
  return stream.eof();
}

struct WriteOption {
  Hdf5File& file;
  std::string object;
  template <typename T>
  void operator()(const std::string& name, const T& value) const {
    file.write_attribute(object, name, option_text(value));
  }
};

struct ReadOption {
  const Hdf5File& file;
  std::string object;
  template <typename T>
  void operator()(const std::string& name, T& value) const {
    if (!parse_option(file.text_attribute(object, name), value)) {
      throw InputError(file.path() + ": attribute '" + name + "' of '" + object +
                       "' cannot be read as an option");
    }
  }
};

int64_t whole_number(const Hdf5File& file, const std::string& object, const std::string& name) {
  const double number = file.number_attribute(object, name);
  if (!(number >= 0 && number < 1e15)) {
    throw InputError(file.path() + ": attribute '" + name + "' of '" + object +
                     "' is out of range");
  }
  return static_cast<int64_t>(number);
}

}  // namespace

std::map<std::string, std::string> options_of(const TrainConfig& config) {
  std::map<std::string, std::string> options;
  visit_train(config, [&](const std::string& name, const auto& value) {
    options["train." + name] = option_text(value);
  });
  visit_network(config.network, [&](const std::string& name, const auto& value) {
    options["train.network." + name] = option_text(value);
  });
  return options;
}

void write_tensor(Hdf5File& file, const std::string& name, const Tensor& tensor) {
  const Tensor plain = tensor.detach().to(torch::kFloat32).contiguous();
  file.write(name, plain.data_ptr<float>(), plain.sizes().vec());
}

Tensor read_tensor(const Hdf5File& file, const std::string& name) {
  const Dims dims = file.dims(name);
  const std::vector<float> values = file.read<float>(name);
  const Tensor tensor = torch::empty(dims, torch::kFloat32);
  std::copy(values.begin(), values.end(), tensor.data_ptr<float>());
  if (!torch::isfinite(tensor).all().item<bool>()) {
    throw InputError(file.path() + ": " + name + " holds numbers that are not finite");
  }
  return tensor;
}

NamedTensors named_weights(const torch::nn::Module& module) {
  NamedTensors weights;
  for (const auto& item : module.named_parameters()) weights.emplace_back(item.key(), item.value());
  for (const auto& item : module.named_buffers()) weights.emplace_back(item.key(), item.value());
  return weights;
}

void set_weights(torch::nn::Module& module, const NamedTensors& weights, const std::string& path) {
  const torch::NoGradGuard no_grad;
  std::map<std::string, Tensor> found(weights.begin(), weights.end());
  for (auto& [name, tensor] : named_weights(module)) {
    const auto weight = found.find(name);
    if (weight == found.end()) {
      throw InputError(path + ": network/weights/" + name + " is missing");
    }
    if (weight->second.sizes() != tensor.sizes()) {
      throw InputError(path + ": network/weights/" + name + " has another shape than the network");
    }
    tensor.copy_(weight->second);
  }
}

void write_weights(Hdf5File& file, const NamedTensors& weights) {
  for (const auto& [name, tensor] : weights) write_tensor(file, "network/weights/" + name, tensor);
}

NamedTensors read_weights(const Hdf5File& file) {
  NamedTensors weights;
  for (const std::string& name : file.list("network/weights")) {
    weights.emplace_back(name, read_tensor(file, "network/weights/" + name));
  }
  return weights;
}

void write_kind(Hdf5File& file, const std::string& kind) {
  file.write_attribute("/", "kind", kind);
}

void require_kind(const Hdf5File& file, const std::string& kind, const std::string& made_by) {
  if (!file.has_attribute("/", "kind") || file.text_attribute("/", "kind") != kind) {
    throw InputError(file.path() + ": is no " + kind + " checkpoint; expected a file made by " +
                     made_by);
  }
}

void write_diffusion_checkpoint(const std::string& path, const DiffusionCheckpoint& checkpoint,
                                const Adam& state, const Provenance& provenance) {
  Hdf5File file = Hdf5File::create(path);
  write_kind(file, "diffusion");
  write_provenance(file, provenance);
  write_weights(file, checkpoint.weights);
  file.write_attribute("network", "joints", checkpoint.joints);
  file.write_attribute("network", "shape_count", checkpoint.shape_count);
  visit_network(checkpoint.config.network, WriteOption{file, "network"});
  const Normalisation& normalisation = checkpoint.normalisation;
  write_tensor(file, "normalisation/texture_mean", normalisation.texture_mean);
  write_tensor(file, "normalisation/texture_std", normalisation.texture_std);
  write_tensor(file, "normalisation/mask", normalisation.mask);
  write_tensor(file, "normalisation/feature_mean", normalisation.feature_mean);
  write_tensor(file, "normalisation/feature_std", normalisation.feature_std);
  file.write_attribute("normalisation", "limit", normalisation.limit);
  write_tensor(file, "training/weights", state.values);
  write_tensor(file, "training/average", state.average);
  write_tensor(file, "training/first_moment", state.first_moment);
  write_tensor(file, "training/second_moment", state.second_moment);
  file.write_attribute("training", "step", checkpoint.step);
  file.write_attribute("training", "seconds", checkpoint.seconds);
  visit_train(checkpoint.config, WriteOption{file, "training"});
  file.commit();
}

DiffusionCheckpoint read_diffusion_checkpoint(const std::string& path) {
  const Hdf5File file = Hdf5File::open(path);
  require_kind(file, "diffusion", "pleat train");
  DiffusionCheckpoint checkpoint;
  visit_network(checkpoint.config.network, ReadOption{file, "network"});
  visit_train(checkpoint.config, ReadOption{file, "training"});
  try {
    validate(checkpoint.config);
  } catch (const InputError& error) {
    throw InputError(path + ": " + error.what());
  }
  checkpoint.joints = whole_number(file, "network", "joints");
  checkpoint.shape_count = whole_number(file, "network", "shape_count");
  checkpoint.step = whole_number(file, "training", "step");
  checkpoint.seconds = file.number_attribute("training", "seconds");
  if (checkpoint.joints < 1 || checkpoint.joints > 1000 || checkpoint.shape_count > 1000) {
    throw InputError(path + ": attribute 'joints' or 'shape_count' of 'network' is out of range");
  }
  const auto shaped = [&](const std::string& name, const std::vector<int64_t>& sizes) {
    const Tensor tensor = read_tensor(file, name);
    if (tensor.sizes() != torch::IntArrayRef(sizes)) {
      throw InputError(path + ": " + name + " has a wrong shape");
    }
    return tensor;
  };
  Normalisation& normalisation = checkpoint.normalisation;
  normalisation.texture_mean = shaped("normalisation/texture_mean", {1, 3, 1, 1});
  normalisation.texture_std = shaped("normalisation/texture_std", {1, 3, 1, 1});
  const Dims mask = file.dims("normalisation/mask");
  if (mask.size() != 4 || mask[2] < 1 || mask[2] > 4096) {
    throw InputError(path + ": normalisation/mask has a wrong shape");
  }
  normalisation.mask = shaped("normalisation/mask", {1, 1, mask[2], mask[2]});
  const int64_t features = feature_count(checkpoint.joints, checkpoint.shape_count);
  normalisation.feature_mean = shaped("normalisation/feature_mean", {1, features});
  normalisation.feature_std = shaped("normalisation/feature_std", {1, features});
  normalisation.limit = file.number_attribute("normalisation", "limit");
  checkpoint.weights = read_weights(file);
  return checkpoint;
}

void read_training_state(const std::string& path, Adam& state) {
  const Hdf5File file = Hdf5File::open(path);
  const auto read_into = [&](const std::string& name, Tensor& tensor) {
    const Tensor values = read_tensor(file, name);
    if (values.sizes() != tensor.sizes()) {
      throw InputError(path + ": " + name + " has another length than the network");
    }
    tensor.copy_(values);
  };
  read_into("training/weights", state.values);
  read_into("training/average", state.average);
  read_into("training/first_moment", state.first_moment);
  read_into("training/second_moment", state.second_moment);
}

}  // namespace pleat::learn
