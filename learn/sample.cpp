#include "learn/sample.h"

#include <torch/torch.h>

#include <cmath>

#include "core/error.h"
#include "core/hdf5_file.h"
#include "core/progress.h"
#include "core/random.h"
#include "learn/batches.h"
#include "learn/checkpoint.h"
#include "learn/design_net.h"
#include "learn/diffusion.h"
#include "learn/threads.h"
#include "learn/unet.h"

namespace pleat::learn {

using torch::Tensor;

struct DiffusionModel::Model {
  std::string path;
  DiffusionCheckpoint checkpoint;
  Schedule schedule;
  UNet network{nullptr};
};

DiffusionModel::DiffusionModel(const std::string& path) : model_(std::make_unique<Model>()) {
  Model& model = *model_;
  model.path = path;
  model.checkpoint = read_diffusion_checkpoint(path);
  const DiffusionCheckpoint& checkpoint = model.checkpoint;
  model.schedule = make_schedule(checkpoint.config.diffusion_steps);
  model.network = UNet(checkpoint.config.network, checkpoint.normalisation.mask.size(2),
                       feature_count(checkpoint.joints, checkpoint.shape_count));
  set_weights(*model.network, checkpoint.weights, path);
  model.network->eval();
}

DiffusionModel::DiffusionModel(DiffusionModel&&) noexcept = default;
DiffusionModel::~DiffusionModel() = default;

int DiffusionModel::resolution() const {
  return static_cast<int>(model_->checkpoint.normalisation.mask.size(2));
}
int64_t DiffusionModel::joints() const { return model_->checkpoint.joints; }
int64_t DiffusionModel::shape_count() const { return model_->checkpoint.shape_count; }

namespace {

// [B, C] for B conditions.
Tensor feature_rows(const std::vector<Condition>& conditions,
                    const DiffusionCheckpoint& checkpoint) {
  const int64_t count = feature_count(checkpoint.joints, checkpoint.shape_count);
  const Tensor features = torch::empty({static_cast<int64_t>(conditions.size()), count});
  float* row = features.data_ptr<float>();
  for (const Condition& condition : conditions) {
    if (condition.pose.rows() != checkpoint.joints ||
        condition.shape.size() != checkpoint.shape_count) {
      throw InputError(
          "sample: a condition has " + std::to_string(condition.pose.rows()) + " joints and " +
          std::to_string(condition.shape.size()) + " shape coefficients; the checkpoint expects " +
          std::to_string(checkpoint.joints) + " and " + std::to_string(checkpoint.shape_count));
    }
    const Eigen::VectorXf numbers = condition_features(condition);
    row = std::copy(numbers.begin(), numbers.end(), row);
  }
  return features;
}

}  // namespace

std::vector<float> DiffusionModel::sample(const std::vector<Condition>& conditions,
                                          const std::vector<std::string>& streams,
                                          const SampleConfig& config) const {
  validate(config);
  if (conditions.size() != streams.size()) {
    throw InputError("sample: " + std::to_string(conditions.size()) + " conditions but " +
                     std::to_string(streams.size()) + " random streams; expected one each");
  }
  const Model& model = *model_;
  const Normalisation& normalisation = model.checkpoint.normalisation;
  if (model.checkpoint.config.network.input_channels != 3) {
    throw InputError(model.path + ": needs the previous frame; expected a model of single frames");
  }
  use_threads(config.threads);
  const torch::NoGradGuard no_grad;
  const Tensor features =
      normalise_features(normalisation, feature_rows(conditions, model.checkpoint));
  const int64_t side = resolution(), texture_size = 3 * side * side;
  std::vector<float> textures;
  textures.reserve(conditions.size() * static_cast<size_t>(texture_size));
  const size_t batch_size = static_cast<size_t>(config.batch_size);
  for (size_t begin = 0; begin < conditions.size(); begin += batch_size) {
    const size_t end = std::min(conditions.size(), begin + batch_size);
    const int64_t batch = static_cast<int64_t>(end - begin);
    const Tensor c = features.narrow(0, static_cast<int64_t>(begin), batch);
    std::vector<RandomStream> noise;
    for (size_t k = begin; k < end; ++k) noise.emplace_back(config.seed, streams[k]);

    SamplerProblem problem;
    problem.schedule = model.schedule;
    problem.prediction = prediction_from(model.checkpoint.config.prediction);
    problem.mask = normalisation.mask;
    problem.limit = normalisation.limit;
    problem.network = [&](const Tensor& y, const Tensor& t) {
      return model_->network->forward(y, t, c);
    };
    problem.next_noise = [&] {
      const Tensor drawn = torch::empty({batch, 3, side, side});
      float* value = drawn.data_ptr<float>();
      for (RandomStream& stream : noise) {
        for (int64_t i = 0; i < texture_size; ++i) *value++ = static_cast<float>(stream.normal());
      }
      return drawn;
    };
    const Tensor drawn =
        config.sampler == "ddpm" ? sample_ddpm(problem) : sample_ddim(problem, config.ddim_steps);
    const Tensor offsets = restore_offsets(normalisation, drawn).contiguous();  // [B, 3, R, R], m
    const float* data = offsets.data_ptr<float>();
    textures.insert(textures.end(), data, data + offsets.numel());
  }
  return textures;
}

bool sample_textures(const std::string& checkpoint, const std::string& dataset_path,
                     const std::vector<int64_t>& rows, const SampleConfig& config,
                     const std::string& output, const Provenance& provenance) {
  validate(config);
  const DiffusionModel model(checkpoint);
  const TextureDataset dataset(dataset_path);
  if (dataset.joints() != model.joints() || dataset.shape_count() != model.shape_count() ||
      dataset.resolution() != model.resolution()) {
    throw InputError(dataset_path + ": has other textures, joints or shape coefficients than " +
                     checkpoint + " was trained with; expected the dataset of its training");
  }
  for (const int64_t row : rows) {
    if (row < 0 || row >= dataset.row_count()) {
      throw InputError("sample: row " + std::to_string(row) + " is not in " + dataset_path +
                       "; expected 0 to " + std::to_string(dataset.row_count() - 1));
    }
  }
  if (rows.empty()) throw InputError("sample: no rows chosen of " + dataset_path);

  std::vector<int32_t> sample_rows, draws;
  for (const int64_t row : rows) {
    for (int draw = 0; draw < config.samples_per_row; ++draw) {
      sample_rows.push_back(static_cast<int32_t>(row));
      draws.push_back(draw);
    }
  }
  const int64_t count = static_cast<int64_t>(sample_rows.size());
  const int64_t side = model.resolution();
  Hdf5File file = Hdf5File::create(output);
  write_provenance(file, provenance);
  file.create_dataset("textures", {count, 3, side, side}, Hdf5Type::kFloat32, 1);
  file.write("row", sample_rows, {count});
  file.write("draw", draws, {count});
  file.write_attribute("textures", "unit", std::string("m"));
  file.write_attribute("textures", "meaning",
                       std::string("sampled offset x, y, z from the design's template in T-pose "
                                   "space; 0 outside the mask"));
  file.write_attribute("row", "unit", std::string("1"));
  file.write_attribute("row", "meaning", std::string("row of the dataset that gave the condition"));
  file.write_attribute("draw", "unit", std::string("1"));
  file.write_attribute("draw", "meaning",
                       std::string("number of the sample among those of its row"));
  Progress progress("sample", count, "textures");
  for (int64_t begin = 0; begin < count; begin += config.batch_size) {
    if (is_interrupted()) return false;
    const int64_t end = std::min<int64_t>(count, begin + config.batch_size);
    std::vector<Condition> conditions;
    std::vector<std::string> streams;
    for (int64_t k = begin; k < end; ++k) {
      const size_t i = static_cast<size_t>(k);
      conditions.push_back(dataset.condition(sample_rows[i]));
      streams.push_back("sample/" + std::to_string(sample_rows[i]) + "/" +
                        std::to_string(draws[i]));
    }
    const std::vector<float> textures = model.sample(conditions, streams, config);
    file.write_rows("textures", begin, end - begin, textures.data());
    progress.advance(end - begin);
  }
  file.commit();
  return true;
}

std::vector<int64_t> rows_of_split(const std::string& dataset, int split, int64_t count) {
  const Hdf5File file = Hdf5File::open(dataset);
  const std::vector<uint8_t> splits = file.read<uint8_t>("split");
  std::vector<int64_t> rows;
  for (size_t row = 0; row < splits.size(); ++row) {
    if (splits[row] == split) rows.push_back(static_cast<int64_t>(row));
  }
  return spread(rows, count);
}

std::vector<DesignShape> predict_design(const std::string& checkpoint,
                                        const std::vector<Vec<3>>& designs) {
  const Hdf5File file = Hdf5File::open(checkpoint);
  require_kind(file, "design", "pleat train");
  const std::vector<int> hidden = file.read<int>("network/hidden");
  TrainDesignConfig config;
  config.hidden = hidden;
  validate(config);
  const NamedTensors weights = read_weights(file);
  const double vertices = file.number_attribute("network", "vertices");
  const double uvs = file.number_attribute("network", "uvs");
  const Dims basis = file.dims("network/weights/basis");
  if (!(vertices >= 1 && vertices < 1e9 && uvs >= 1 && uvs < 1e9) || basis.size() != 2 ||
      basis[0] < 1 || static_cast<double>(basis[1]) != 3 * vertices + 2 * uvs) {
    throw InputError(checkpoint + ": network/weights/basis does not fit the network's attributes");
  }
  DesignNet network(hidden, basis[0], basis[1]);
  set_weights(*network, weights, checkpoint);

  const torch::NoGradGuard no_grad;
  const int64_t vertex_count = static_cast<int64_t>(vertices), uv_count = static_cast<int64_t>(uvs);
  std::vector<DesignShape> shapes;
  for (const Vec<3>& p : designs) {
    const Tensor input = torch::tensor({p[0], p[1], p[2]}, torch::kFloat32).view({1, 3});
    const Tensor output = network(input).to(torch::kFloat64).contiguous();
    const double* data = output.data_ptr<double>();
    DesignShape shape;
    shape.vertices = Eigen::Map<const Points3>(data, vertex_count, 3);
    shape.uv = Eigen::Map<const Points2>(data + 3 * vertex_count, uv_count, 2);
    shapes.push_back(shape);
  }
  return shapes;
}

}  // namespace pleat::learn
