#include "learn/train.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "core/error.h"
#include "core/hdf5_file.h"
#include "learn/batches.h"
#include "learn/sample.h"
#include "synthetic_dataset.h"

namespace pleat::learn {
namespace {

const std::function<bool()> kNever = [] { return false; };

TrainConfig tiny_config() {
  TrainConfig config;
  config.network.block_channels = {16, 32};
  config.network.attention_blocks = {2};
  config.network.layers_per_block = 1;
  config.network.norm_groups = 4;
  config.network.condition_features = 32;
  config.batch_size = 8;
  config.steps = 12;
  config.warmup_steps = 4;
  config.validate_every_steps = 5;
  config.validation_rows = 8;
  config.threads = 1;
  config.seed = 3;
  return config;
}

TrainResult train(const TrainConfig& config, const TemporaryFolder& folder, const std::string& name,
                  const std::function<bool()>& should_stop = kNever) {
  return train_diffusion(config, folder / "dataset.h5", folder / name, Provenance{}, should_stop);
}

std::string message_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no InputError";
}

TEST(Batches, GiveEveryRowOnceAnEpochFromAnyStep) {
  std::vector<int64_t> rows = {3, 5, 8, 13, 21, 34, 55};
  std::vector<int64_t> drawn;
  for (int64_t step = 0; step < 7; ++step) {
    const std::vector<int64_t> batch = batch_rows(rows, 1, step, 3);
    drawn.insert(drawn.end(), batch.begin(), batch.end());
  }
  std::vector<std::vector<int64_t>> epochs;
  for (int epoch = 0; epoch < 3; ++epoch) {
    epochs.emplace_back(drawn.begin() + 7 * epoch, drawn.begin() + 7 * (epoch + 1));
    EXPECT_THAT(epochs.back(), testing::UnorderedElementsAreArray(rows));
  }
  EXPECT_NE(epochs[0], epochs[1]);
  EXPECT_NE(batch_rows(rows, 2, 0, 7), batch_rows(rows, 1, 0, 7));
}

TEST(Batches, ReadWhatTheFileHolds) {
  const TemporaryFolder folder;
  write_synthetic_dataset(folder / "dataset.h5", {});
  TextureDataset dataset(folder / "dataset.h5");
  const Normalisation normalisation = read_normalisation(dataset);
  const torch::Tensor offsets = dataset.textures(dataset.training_rows());
  const torch::Tensor mask = normalisation.mask;
  const torch::Tensor textures = normalise_textures(normalisation, offsets);
  EXPECT_EQ((textures * (1 - mask)).abs().max().item<double>(), 0);
  const torch::Tensor inside = textures.masked_select(mask.expand_as(textures) > 0);
  EXPECT_NEAR(inside.mean().item<double>(), 0, 1e-3);
  EXPECT_NEAR(inside.std().item<double>(), 1, 1e-2);
  EXPECT_LT(inside.abs().max().item<double>(), normalisation.limit);
  EXPECT_LT((restore_offsets(normalisation, textures) - offsets).abs().max().item<double>(), 1e-6);
  dataset.preload(100);
  EXPECT_TRUE(dataset.textures(dataset.training_rows()).equal(offsets));
}

TEST(Train, ResumesToTheSameBits) {
  const TemporaryFolder folder;
  write_synthetic_dataset(folder / "dataset.h5", {});
  TrainConfig config = tiny_config();
  config.threads = 2;
  const TrainResult whole = train(config, folder, "whole");
  EXPECT_EQ(whole.status, TrainStatus::kFinished);
  EXPECT_EQ(whole.step, 12);

  int asked = 0;
  const auto after_five = [&] { return ++asked == 5; };
  TrainResult part = train(config, folder, "parts", after_five);
  EXPECT_EQ(part.status, TrainStatus::kInterrupted);
  EXPECT_EQ(part.step, 5);
  TrainConfig hurried = config;
  hurried.max_minutes = 1e-9;  // one step, then time is up
  part = train(hurried, folder, "parts");
  EXPECT_EQ(part.status, TrainStatus::kTimeUp);
  EXPECT_EQ(part.step, 6);
  part = train(config, folder, "parts");
  EXPECT_EQ(part.status, TrainStatus::kFinished);

  const Hdf5File a = Hdf5File::open(whole.checkpoint), b = Hdf5File::open(part.checkpoint);
  for (const std::string name : {"weights", "average", "first_moment", "second_moment"}) {
    EXPECT_EQ(a.read<float>("training/" + name), b.read<float>("training/" + name)) << name;
  }
  EXPECT_EQ(whole.validation_loss, part.validation_loss);
  EXPECT_TRUE(std::isfinite(whole.validation_loss));

  // The curve has each step once, up to the last.
  std::ifstream curve(folder / "parts/diffusion_loss.csv");
  std::vector<std::string> steps;
  for (std::string line; std::getline(curve, line);)
    steps.push_back(line.substr(0, line.find(',')));
  EXPECT_THAT(steps, testing::ElementsAre("step", "5", "10", "12"));
}

TEST(Train, RefusesToContinueAnotherTraining) {
  const TemporaryFolder folder;
  write_synthetic_dataset(folder / "dataset.h5", {});
  TrainConfig config = tiny_config();
  config.steps = 2;
  train(config, folder, "out");
  TrainConfig other = config;
  other.batch_size = 4;
  EXPECT_THAT(message_of([&] { train(other, folder, "out"); }),
              testing::HasSubstr("train.batch_size"));
  SyntheticDataset changed;
  changed.frames = 50;
  write_synthetic_dataset(folder / "dataset.h5", changed);
  EXPECT_THAT(message_of([&] { train(config, folder, "out"); }),
              testing::HasSubstr("another dataset"));
}

TEST(Train, RefusesBadDatasets) {
  const TemporaryFolder folder;
  const auto message_without = [&](const SyntheticDataset& options) {
    write_synthetic_dataset(folder / "dataset.h5", options);
    return message_of([&] { train(tiny_config(), folder, "out"); });
  };
  for (const std::string name : {"textures", "mask", "pose", "shape", "design_index", "split",
                                 "designs/parameters", "normalisation/mean", "normalisation/std"}) {
    SyntheticDataset options;
    options.left_out = name;
    EXPECT_THAT(message_without(options),
                testing::AllOf(testing::HasSubstr(name), testing::HasSubstr("dataset.h5")));
  }
  SyntheticDataset options;
  options.held_out_share = 1;
  EXPECT_THAT(message_without(options), testing::HasSubstr("no training rows"));
  options = {};
  options.frames = 0;
  EXPECT_THAT(message_without(options), testing::HasSubstr("no frames"));
  options = {};
  options.resolution = 10;  // not to be halved after 2x2 patches
  EXPECT_THAT(message_without(options), testing::HasSubstr("train.network"));
  EXPECT_FALSE(std::filesystem::exists(folder / "out/diffusion.h5"));
}

TEST(Train, RefusesALossThatIsNoNumber) {
  const TemporaryFolder folder;
  write_synthetic_dataset(folder / "dataset.h5", {});
  TrainConfig config = tiny_config();
  config.learning_rate = 1000;
  config.warmup_steps = 0;
  config.max_gradient_norm = 1e30;
  config.steps = 200;
  EXPECT_THAT(message_of([&] { train(config, folder, "out"); }),
              testing::HasSubstr("train.learning_rate"));
}

TEST(Validate, NamesTheKey) {
  TrainConfig config;
  config.prediction = "noise";
  EXPECT_THAT(message_of([&] { validate(config); }),
              testing::HasSubstr("train.prediction = noise"));
  config = {};
  config.learning_rate = std::nan("");
  EXPECT_THAT(message_of([&] { validate(config); }), testing::HasSubstr("train.learning_rate"));
  SampleConfig sample;
  sample.ddim_steps = 0;
  EXPECT_THAT(message_of([&] { validate(sample); }), testing::HasSubstr("sample.ddim_steps"));
}

TEST(Train, LearnsWhatTheConditionSays) {
  const TemporaryFolder folder;
  SyntheticDataset options;
  options.frames = 200;
  write_synthetic_dataset(folder / "dataset.h5", options);
  TrainConfig train_config = tiny_config();
  train_config.steps = 800;
  train_config.learning_rate = 3e-3;
  train_config.average_decay = 0.98;
  train_config.validate_every_steps = 400;
  const TrainResult result = train(train_config, folder, "out");

  std::ifstream curve(folder / "out/diffusion_loss.csv");
  std::string header, first;
  std::getline(curve, header);
  std::getline(curve, first);
  EXPECT_EQ(header, "step,loss,validation_loss,seconds");
  EXPECT_LT(result.loss, 0.1 * std::stod(first.substr(first.find(',') + 1)));

  for (const std::string sampler : {"ddim", "ddpm"}) {
    for (const int split : {0, 2}) {
      const std::vector<int64_t> rows = rows_of_split(folder / "dataset.h5", split, 12);
      ASSERT_EQ(rows.size(), 12U);
      SampleConfig config;
      config.sampler = sampler;
      config.threads = 1;
      const std::string output = folder / "samples.h5";
      ASSERT_TRUE(sample_textures(result.checkpoint, folder / "dataset.h5", rows, config, output,
                                  Provenance{}));
      const Hdf5File file = Hdf5File::open(output);
      ASSERT_EQ(file.dims("textures"), (Dims{12, 3, 16, 16}));
      const TextureDataset dataset(folder / "dataset.h5");
      const Normalisation normalisation = read_normalisation(dataset);
      const torch::Tensor drawn = torch::tensor(file.read<float>("textures")).view({12, 3, 16, 16});
      EXPECT_EQ((drawn * (1 - normalisation.mask)).abs().max().item<double>(), 0);
      const torch::Tensor truth = normalise_textures(normalisation, dataset.textures(rows));
      const torch::Tensor error = normalise_textures(normalisation, drawn) - truth;
      // Rows of other conditions are a relative error of sqrt(2) apart.
      const double relative = (error.norm() / truth.norm()).item<double>();
      EXPECT_LT(relative, split == 0 ? 0.3 : 0.5) << sampler << " split " << split;
      const std::vector<int32_t> written = file.read<int32_t>("row");
      EXPECT_THAT(written, testing::ElementsAreArray(rows));
    }
  }
}

// Samples of a model that has hardly learned: enough for all but their quality.
class Sample : public testing::Test {
 protected:
  Sample() {
    write_synthetic_dataset(folder_ / "dataset.h5", {});
    result_ = train(tiny_config(), folder_, "out");
  }
  TemporaryFolder folder_;
  TrainResult result_;
};

TEST_F(Sample, DoesNotDependOnItsBatch) {
  const DiffusionModel model(result_.checkpoint);
  const TextureDataset dataset(folder_ / "dataset.h5");
  std::vector<Condition> conditions;
  std::vector<std::string> streams;
  for (int row = 0; row < 5; ++row) {
    conditions.push_back(dataset.condition(row));
    streams.push_back("sample/" + std::to_string(row));
  }
  SampleConfig config;
  config.sampler = "ddpm";
  config.threads = 1;
  config.batch_size = 5;
  const std::vector<float> together = model.sample(conditions, streams, config);
  config.batch_size = 2;
  const std::vector<float> apart = model.sample(conditions, streams, config);
  const std::vector<float> alone = model.sample({conditions[3]}, {streams[3]}, config);
  const size_t size = 3 * 16 * 16;
  ASSERT_EQ(together.size(), 5 * size);
  ASSERT_EQ(alone.size(), size);
  double largest = 0;
  for (size_t i = 0; i < together.size(); ++i) {
    largest = std::max(largest, std::abs(static_cast<double>(together[i]) - apart[i]));
  }
  for (size_t i = 0; i < size; ++i) {
    largest = std::max(largest, std::abs(static_cast<double>(together[3 * size + i]) - alone[i]));
  }
  EXPECT_LT(largest, 1e-5);  // m; rounding of sums in another order, over 100 steps
  const std::vector<float> other = model.sample({conditions[3]}, {"sample/other"}, config);
  EXPECT_NE(other, alone);
}

TEST_F(Sample, RefusesBadCheckpoints) {
  const auto message = [&](const std::string& path) {
    return message_of([&] { DiffusionModel model(path); });
  };
  EXPECT_THAT(message(folder_ / "nowhere.h5"), testing::HasSubstr("nowhere.h5"));
  EXPECT_THAT(message(folder_ / "dataset.h5"), testing::HasSubstr("no diffusion checkpoint"));
  std::ifstream source(result_.checkpoint, std::ios::binary);
  std::stringstream bytes;
  bytes << source.rdbuf();
  const std::string whole = bytes.str();
  for (const double share : {0.0, 0.1, 0.5, 0.99}) {
    std::ofstream(folder_ / "cut.h5", std::ios::binary)
        << whole.substr(0, static_cast<size_t>(share * static_cast<double>(whole.size())));
    EXPECT_THAT(message(folder_ / "cut.h5"), testing::HasSubstr("cut.h5")) << share;
  }
  std::ofstream(folder_ / "text.h5") << "no HDF5";
  EXPECT_THAT(message(folder_ / "text.h5"), testing::HasSubstr("text.h5"));
}

TEST_F(Sample, RefusesRowsAndConditionsThatDoNotFit) {
  SampleConfig config;
  EXPECT_THROW(sample_textures(result_.checkpoint, folder_ / "dataset.h5", {60}, config,
                               folder_ / "none.h5", Provenance{}),
               InputError);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "none.h5"));
  const DiffusionModel model(result_.checkpoint);
  Condition condition;
  condition.pose = Points3::Zero(5, 3);
  condition.shape = Eigen::VectorXd::Zero(2);
  condition.design.setZero();
  EXPECT_THROW(model.sample({condition}, {"a"}, config), InputError);
}

}  // namespace
}  // namespace pleat::learn
