// dataset.h5 (docs/dataset.md) to tensors. Conditions are in memory; textures are read row by row
// unless kept.
#pragma once

#include <torch/torch.h>

#include <string>
#include <vector>

#include "core/hdf5_file.h"
#include "learn/condition.h"

namespace pleat::learn {

class TextureDataset {
 public:
  // InputError naming file and array: missing, misshapen, not finite, without frames.
  explicit TextureDataset(const std::string& path);

  const std::string& path() const { return file_.path(); }
  int64_t resolution() const { return resolution_; }
  int64_t row_count() const { return features_.size(0); }
  int64_t joints() const { return joints_; }
  int64_t shape_count() const { return shape_count_; }
  const std::vector<int64_t>& training_rows() const { return training_rows_; }
  const std::vector<int64_t>& held_out_rows() const { return held_out_rows_; }
  const Hdf5File& file() const { return file_; }

  // Keeps the training textures in memory where they take no more than this.
  void preload(double megabytes);

  torch::Tensor textures(const std::vector<int64_t>& rows) const;  // [B, 3, R, R], m
  torch::Tensor features(const std::vector<int64_t>& rows) const;  // [B, C], see condition.h
  Condition condition(int64_t row) const;

 private:
  void read_conditions();

  Hdf5File file_;
  double scale_m_ = 1;
  bool is_int16_ = true;
  int64_t resolution_ = 0;
  int64_t joints_ = 0, shape_count_ = 0;
  std::vector<int64_t> training_rows_, held_out_rows_;
  std::vector<double> pose_, shape_, parameters_;  // [F, J, 3], [F, S], [D, 3]
  std::vector<int32_t> design_index_;              // [F]
  torch::Tensor features_;                         // [F, C]
  torch::Tensor kept_;                             // [n, 3, R, R], int16 or float, as in the file
  std::vector<int64_t> kept_position_;             // row -> position in kept_, -1 where not kept
};

// What turns numbers of the file into numbers of the network, and back. Part of every checkpoint.
struct Normalisation {
  torch::Tensor texture_mean, texture_std;  // [1, 3, 1, 1], m
  torch::Tensor mask;                       // [1, 1, R, R], 1 where a texel has a value
  double limit = 0;                         // largest |normalised offset|, with a margin
  torch::Tensor feature_mean, feature_std;  // [1, C]
};
// From the dataset's `mask` and `normalisation`, the rest measured on its training rows; InputError
// without any.
Normalisation read_normalisation(const TextureDataset& dataset);
torch::Tensor normalise_textures(const Normalisation& normalisation,
                                 const torch::Tensor& offsets);  // m -> network
torch::Tensor restore_offsets(const Normalisation& normalisation,
                              const torch::Tensor& textures);  // network -> m
torch::Tensor normalise_features(const Normalisation& normalisation, const torch::Tensor& features);

// Row numbers of batch `step` (from 0): the training rows in a new order each time through, from
// the named stream of the seed, so that any step's batch is known without those before it.
std::vector<int64_t> batch_rows(const std::vector<int64_t>& rows, uint64_t seed, int64_t step,
                                int64_t batch_size);

// count of the values, evenly spread, first and last included.
std::vector<int64_t> spread(const std::vector<int64_t>& values, int64_t count);

}  // namespace pleat::learn
