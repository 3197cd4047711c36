// dataset.h5, the file that learners read: docs/dataset.md.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "body/motion.h"
#include "core/hdf5_file.h"
#include "core/provenance.h"
#include "encode/normalise.h"
#include "encode/texture.h"
#include "encode/unpose.h"
#include "garment/clip.h"
#include "garment/template.h"

namespace pleat::encode {

enum Split : uint8_t { kTrain = 0, kHeldOutDesign = 1, kHeldOutSequence = 2, kHeldOutBoth = 3 };
constexpr int kSplits = 4;
std::string split_name(
    int split);  // "train", "held_out_design", "held_out_sequence", "held_out_both"

// One frame, all but its texture.
struct DatasetRow {
  body::Pose pose;
  Eigen::VectorXd shape;  // beta, S
  int design = 0;         // into Dataset's garments
  int sequence = 0;       // into Dataset's sequences
  int frame = 0;          // within its sequence
  int previous = -1;      // row of the frame before in the same clip
  Split split = kTrain;
  garment::Certificate certificate;  // the six numbers of docs/dataset.md
  std::string clip_key;
};

struct Sequence {
  std::string name;
  bool is_held_out = false;
  double frame_rate_hz = 30;
};

// All of the file but its textures.
struct DatasetContents {
  int texture_size = 0;
  std::vector<uint8_t> mask;               // R*R
  std::vector<garment::Garment> garments;  // one a design, of one topology
  std::vector<Sequence> sequences;
  std::vector<DatasetRow> rows;
  Normalisation normalisation;
  Skinning skinning = Skinning::kLinear;
  std::string body_sha256;
};

// A dataset being written: textures one by one, in the order of the rows, then commit().
class DatasetWriter {
 public:
  // scale_m > 0: int16, metres = value * scale_m; 0: float32.
  DatasetWriter(const std::string& path, const DatasetContents& contents, double scale_m,
                int gzip_level, const Provenance& provenance);
  // Returns the texture as a reader will see it. A value outside the scale's range is our own
  // mistake (assert).
  Texture append(const Texture& texture);
  void commit();  // every row must have been appended

 private:
  Hdf5File file_;
  int64_t row_ = 0, row_count_ = 0;
  int texture_size_ = 0;
  double scale_m_ = 0;
};

// A dataset open to read. Everything but the textures is in memory, and checked: InputError names
// file and array.
class Dataset {
 public:
  explicit Dataset(const std::string& path);

  const std::string& path() const { return file_.path(); }
  const DatasetContents& contents() const { return contents_; }
  const DatasetRow& row(int64_t row) const { return contents_.rows[static_cast<size_t>(row)]; }
  int64_t row_count() const { return static_cast<int64_t>(contents_.rows.size()); }
  const garment::Garment& garment(int64_t row) const;
  const TexelReads& reads() const { return reads_; }  // at the panel vertices
  Texture texture(int64_t row) const;                 // metres
  double scale_m() const { return scale_m_; }
  Provenance provenance() const { return read_provenance(file_); }

 private:
  Hdf5File file_;
  DatasetContents contents_;
  TexelReads reads_;
  double scale_m_ = 1;
};

// A texture of this row's garment, its own or a sampled one, back to the sewn vertices, m.
Points3 decode_offsets(const Dataset& dataset, int64_t row,
                       const Texture& texture);  // from the template, T-pose
Points3 decode_unposed(const Dataset& dataset, int64_t row, const Texture& texture);  // T-pose
Points3 decode_posed(const Dataset& dataset, int64_t row, const Texture& texture,
                     const body::BodyModel& model);
// The body that this row's garment is worn by, m, world.
Points3 posed_body(const Dataset& dataset, int64_t row, const body::BodyModel& model);

// Refuses a body file other than the one that the dataset was made with.
body::BodyModel read_body_of(const Dataset& dataset, const std::string& body_file);

// Textures that a model drew for rows of a dataset: samples.h5 with `textures` float32 [K, 3, R,
// R], m, and `row` int32 [K]. A row may come several times.
class Samples {
 public:
  Samples(const std::string& path, const Dataset& dataset);  // InputError names file and array
  const std::string& path() const { return file_.path(); }
  int64_t count() const { return static_cast<int64_t>(rows_.size()); }
  int64_t row(int64_t sample) const { return rows_[static_cast<size_t>(sample)]; }
  Texture texture(int64_t sample) const;  // metres; InputError where a number is not finite

 private:
  Hdf5File file_;
  std::vector<int32_t> rows_;
  int texture_size_ = 0;
};

}  // namespace pleat::encode
