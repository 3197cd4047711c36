// The stage `encode`: accepted drapes -> offset textures -> dataset.h5.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/provenance.h"
#include "encode/dataset.h"
#include "encode/drape_files.h"

namespace pleat::encode {

struct EncodeConfig {                         // section `encode`
  int texture_size = 128;                     // texels a side, 64 .. 512
  std::string fill = "fitted";                // or "barycentric", the paper's
  std::string dtype = "int16";                // fixed point, or "float32"
  std::string skinning = "linear";            // or "dual_quaternion"
  int gzip_level = 0;                         // 0 .. 9; 0 reads fastest
  std::vector<std::string> held_out_motions;  // names of sequences that are not trained on
  // Names of designs that are not trained on; by default as their garment files say.
  std::optional<std::vector<std::string>> held_out_designs;
};
void validate(const EncodeConfig& config);  // throws InputError naming the key

struct DatasetReport {
  int64_t accepted_frames = 0;  // rows
  int64_t rejected_frames = 0;  // left out: their certificate did not accept them
  std::array<int64_t, kSplits> split_frames = {};
  double scale_m = 0;           // of int16; 0 with float32
  double largest_offset_m = 0;  // of one axis, over all textures
  // Simulated drape against the one decoded from the file, posed, at the sewn vertices, mm.
  double round_trip_mean_mm = 0, round_trip_p99_mm = 0, round_trip_max_mm = 0;
  // Over all vertices and frames, of the linear blend that unposing inverts; the share below 0.25
  // is doubtful.
  double smallest_singular_value = 1, ill_conditioned_share = 0;
  bool is_interrupted = false;  // by the user: no file was written
};
std::string summary(const DatasetReport& report);  // a few lines to print

// Every clip is read twice: once to learn the range and the statistics, once to write; memory holds
// one clip at a time. provenance: stage, config and seed; the inputs' hashes are added here.
DatasetReport make_dataset(const DatasetInputs& inputs, const EncodeConfig& config,
                           Provenance provenance, const std::string& path);

}  // namespace pleat::encode
