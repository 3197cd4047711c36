#include "learn/batches.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/random.h"
#include "learn/condition.h"

namespace pleat::learn {
namespace {

using torch::Tensor;

[[noreturn]] void refuse(const Hdf5File& file, const std::string& array, const std::string& why) {
  throw InputError(file.path() + ": " + array + ": " + why);
}

std::string dims_text(const Dims& dims) {
  std::string text = "[";
  for (size_t i = 0; i < dims.size(); ++i) text += (i ? ", " : "") + std::to_string(dims[i]);
  return text + "]";
}

// -1 in expected: any number above 0.
Dims require_dims(const Hdf5File& file, const std::string& array, const Dims& expected,
                  const std::string& expected_text) {
  const Dims dims = file.dims(array);
  bool fits = dims.size() == expected.size();
  for (size_t i = 0; fits && i < dims.size(); ++i) {
    fits = expected[i] < 0 ? dims[i] > 0 : dims[i] == expected[i];
  }
  if (!fits) refuse(file, array, "is " + dims_text(dims) + "; expected " + expected_text);
  return dims;
}

template <typename T>
void require_finite(const Hdf5File& file, const std::string& array, const std::vector<T>& values) {
  for (size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) {
      refuse(file, array, "number " + std::to_string(i) + " is not finite");
    }
  }
}

}  // namespace

TextureDataset::TextureDataset(const std::string& path) : file_(Hdf5File::open(path)) {
  const Dims textures = file_.dims("textures");
  if (textures.size() != 4 || textures[1] != 3 || textures[2] != textures[3] || textures[2] < 1) {
    refuse(file_, "textures", "is " + dims_text(textures) + "; expected [F, 3, R, R]");
  }
  if (textures[0] == 0) refuse(file_, "textures", "has no frames; expected at least one");
  if (textures[2] > 4096) refuse(file_, "textures", "is too large a texture; expected R <= 4096");
  resolution_ = textures[2];
  scale_m_ = file_.number_attribute("textures", "scale_m");
  if (!(scale_m_ > 0 && scale_m_ <= 1)) {
    refuse(file_, "textures",
           "attribute scale_m is " + std::to_string(scale_m_) + "; expected above 0, at most 1");
  }
  is_int16_ = scale_m_ < 1;  // 1: metres in float32
  const std::vector<uint8_t> split = file_.read<uint8_t>("split");
  require_dims(file_, "split", {textures[0]}, "[" + std::to_string(textures[0]) + "], one a frame");
  for (size_t row = 0; row < split.size(); ++row) {
    (split[row] == 0 ? training_rows_ : held_out_rows_).push_back(static_cast<int64_t>(row));
  }
  kept_position_.assign(split.size(), -1);
  read_conditions();
}

void TextureDataset::read_conditions() {
  const int64_t frames = file_.dims("textures")[0];
  joints_ = require_dims(file_, "pose", {frames, -1, 3}, "[F, J, 3]")[1];
  shape_count_ = require_dims(file_, "shape", {frames, -1}, "[F, S]")[1];
  const int64_t designs = require_dims(file_, "designs/parameters", {-1, 3}, "[D, 3]")[0];
  require_dims(file_, "design_index", {frames}, "[F]");
  pose_ = file_.read<double>("pose");
  shape_ = file_.read<double>("shape");
  parameters_ = file_.read<double>("designs/parameters");
  design_index_ = file_.read<int32_t>("design_index");
  require_finite(file_, "pose", pose_);
  require_finite(file_, "shape", shape_);
  require_finite(file_, "designs/parameters", parameters_);

  const int64_t count = feature_count(joints_, shape_count_);
  features_ = torch::empty({frames, count});
  for (int64_t row = 0; row < frames; ++row) {
    const int64_t design = design_index_[static_cast<size_t>(row)];
    if (design < 0 || design >= designs) {
      refuse(file_, "design_index",
             "row " + std::to_string(row) + " is " + std::to_string(design) + "; expected 0 to " +
                 std::to_string(designs - 1));
    }
    const Eigen::VectorXf features = condition_features(condition(row));
    std::copy(features.begin(), features.end(), features_.data_ptr<float>() + row * count);
  }
}

Condition TextureDataset::condition(int64_t row) const {
  const int64_t design = design_index_[static_cast<size_t>(row)];
  Condition condition;
  condition.pose = Eigen::Map<const Points3>(pose_.data() + row * joints_ * 3, joints_, 3);
  condition.shape =
      Eigen::Map<const Eigen::VectorXd>(shape_.data() + row * shape_count_, shape_count_);
  condition.design = Eigen::Map<const Vec<3>>(parameters_.data() + design * 3);
  return condition;
}

void TextureDataset::preload(double megabytes) {
  const int64_t side = resolution(), count = static_cast<int64_t>(training_rows_.size());
  const torch::Dtype type = is_int16_ ? torch::kInt16 : torch::kFloat32;
  const double bytes = static_cast<double>(count * 3 * side * side) * (is_int16_ ? 2 : 4);
  if (bytes > megabytes * 1e6) return;
  const Tensor kept = torch::empty({count, 3, side, side}, type);
  for (int64_t i = 0; i < count; ++i) {
    const int64_t row = training_rows_[static_cast<size_t>(i)];
    if (is_int16_) {
      file_.read_rows("textures", row, 1, kept[i].data_ptr<int16_t>());
    } else {
      file_.read_rows("textures", row, 1, kept[i].data_ptr<float>());
    }
    kept_position_[static_cast<size_t>(row)] = i;
  }
  kept_ = kept;
}

Tensor TextureDataset::textures(const std::vector<int64_t>& rows) const {
  const int64_t side = resolution();
  const Tensor offsets = torch::empty({static_cast<int64_t>(rows.size()), 3, side, side});
  for (size_t i = 0; i < rows.size(); ++i) {
    const Tensor slot = offsets[static_cast<int64_t>(i)];
    const int64_t position = kept_position_[static_cast<size_t>(rows[i])];
    if (position >= 0) {
      slot.copy_(kept_[position]);
    } else {
      file_.read_rows("textures", rows[i], 1, slot.data_ptr<float>());
    }
  }
  return offsets * scale_m_;
}

Tensor TextureDataset::features(const std::vector<int64_t>& rows) const {
  return features_.index_select(0, torch::tensor(rows));
}

Normalisation read_normalisation(const TextureDataset& dataset) {
  const Hdf5File& file = dataset.file();
  if (dataset.training_rows().empty()) {
    refuse(file, "split",
           "has no training rows (value 0); expected some: hold out fewer designs or sequences");
  }
  Normalisation normalisation;
  const int64_t side = dataset.resolution();
  require_dims(file, "mask", {side, side}, "[R, R] as the textures");
  const std::vector<uint8_t> mask = file.read<uint8_t>("mask");
  std::vector<float> inside;
  for (const uint8_t texel : mask) inside.push_back(texel != 0 ? 1.0F : 0.0F);
  normalisation.mask = torch::tensor(inside).view({1, 1, side, side});
  if (normalisation.mask.sum().item<double>() == 0) {
    refuse(file, "mask", "is 0 everywhere; expected texels inside panels");
  }
  const auto three = [&](const std::string& name) {
    require_dims(file, name, {3}, "[3]");
    const std::vector<float> values = file.read<float>(name);
    require_finite(file, name, values);
    return torch::tensor(values).view({1, 3, 1, 1});
  };
  normalisation.texture_mean = three("normalisation/mean");
  normalisation.texture_std = three("normalisation/std");
  if (normalisation.texture_std.min().item<double>() <= 0) {
    refuse(file, "normalisation/std", "holds a number <= 0; expected > 0");
  }
  // A bound for the samplers: some hundreds of frames tell it well enough, with a quarter added.
  for (const int64_t row : spread(dataset.training_rows(), 256)) {
    const Tensor texture = normalise_textures(normalisation, dataset.textures({row}));
    const double largest = texture.abs().max().item<double>();
    if (!std::isfinite(largest)) {
      refuse(file, "textures", "row " + std::to_string(row) + " is not finite");
    }
    normalisation.limit = std::max(normalisation.limit, 1.25 * largest);
  }
  const Tensor features = dataset.features(dataset.training_rows());
  normalisation.feature_mean = features.mean(0, true);
  // A number that hardly varies in training must not be blown up where it does vary.
  normalisation.feature_std =
      (features - normalisation.feature_mean).square().mean(0, true).sqrt().clamp_min(0.1);
  return normalisation;
}

Tensor normalise_textures(const Normalisation& normalisation, const Tensor& offsets) {
  return (offsets - normalisation.texture_mean) / normalisation.texture_std * normalisation.mask;
}

Tensor restore_offsets(const Normalisation& normalisation, const Tensor& textures) {
  return (textures * normalisation.texture_std + normalisation.texture_mean) * normalisation.mask;
}

Tensor normalise_features(const Normalisation& normalisation, const Tensor& features) {
  return (features - normalisation.feature_mean) / normalisation.feature_std;
}

std::vector<int64_t> batch_rows(const std::vector<int64_t>& rows, uint64_t seed, int64_t step,
                                int64_t batch_size) {
  const int64_t count = static_cast<int64_t>(rows.size());
  std::vector<int64_t> batch, order;
  int64_t order_epoch = -1;
  for (int64_t i = step * batch_size; i < (step + 1) * batch_size; ++i) {
    const int64_t epoch = i / count;
    if (epoch != order_epoch) {
      order = RandomStream(seed, "train/order/" + std::to_string(epoch)).permutation(count);
      order_epoch = epoch;
    }
    batch.push_back(rows[static_cast<size_t>(order[static_cast<size_t>(i % count)])]);
  }
  return batch;
}

std::vector<int64_t> spread(const std::vector<int64_t>& values, int64_t count) {
  const int64_t size = static_cast<int64_t>(values.size());
  if (count >= size) return values;
  std::vector<int64_t> chosen;
  for (int64_t i = 0; i < count; ++i) {
    chosen.push_back(values[static_cast<size_t>(count == 1 ? 0 : i * (size - 1) / (count - 1))]);
  }
  return chosen;
}

}  // namespace pleat::learn
