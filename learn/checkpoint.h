// Checkpoints are HDF5 files: the network's options as attributes of `network`, its averaged
// weights by name under `network/weights`, the dataset's normalisation, and under `training` what a
// later run needs to go on exactly. Numbers in a file are checked before anything is built from
// them; InputError names file and array.
#pragma once

#include <torch/torch.h>

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/hdf5_file.h"
#include "core/provenance.h"
#include "learn/adam.h"
#include "learn/batches.h"
#include "learn/condition.h"
#include "learn/config.h"

namespace pleat::learn {

using NamedTensors = std::vector<std::pair<std::string, torch::Tensor>>;

struct DiffusionCheckpoint {
  TrainConfig config;
  Normalisation normalisation;
  int64_t joints = 0, shape_count = 0;
  int64_t step = 0;      // done
  double seconds = 0;    // spent
  NamedTensors weights;  // the average
};
// The options that a continued training must share, key to value.
std::map<std::string, std::string> options_of(const TrainConfig& config);

void write_diffusion_checkpoint(const std::string& path, const DiffusionCheckpoint& checkpoint,
                                const Adam& state, const Provenance& provenance);
DiffusionCheckpoint read_diffusion_checkpoint(const std::string& path);
// The rest of the state into an Adam of the same network.
void read_training_state(const std::string& path, Adam& state);

// Tensors of float32 as arrays.
void write_tensor(Hdf5File& file, const std::string& name, const torch::Tensor& tensor);
torch::Tensor read_tensor(const Hdf5File& file, const std::string& name);

NamedTensors named_weights(const torch::nn::Module& module);  // parameters and buffers
// Into a module of these parameters and no others; InputError naming the file where they differ.
void set_weights(torch::nn::Module& module, const NamedTensors& weights, const std::string& path);
void write_weights(Hdf5File& file, const NamedTensors& weights);
NamedTensors read_weights(const Hdf5File& file);

// Attribute `kind` of the file; InputError where it is another's.
void write_kind(Hdf5File& file, const std::string& kind);
void require_kind(const Hdf5File& file, const std::string& kind, const std::string& made_by);

}  // namespace pleat::learn
