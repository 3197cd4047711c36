// What the representation costs, in millimetres: docs/codec.md.
#pragma once

#include <string>
#include <vector>

#include "encode/drape_files.h"
#include "encode/error_summary.h"
#include "encode/texture.h"
#include "encode/unpose.h"

namespace pleat::encode {

struct CodecReportConfig {
  std::vector<int> texture_sizes = {64, 128, 256};
  std::vector<Fill> fills = {Fill::kBarycentric, Fill::kFitted};
  Skinning skinning = Skinning::kLinear;
  int finer_vertices = 20000;  // of the tessellation that is decoded on, beside the garments' own
  int64_t max_frames = 1000;   // accepted ones, evenly spread; 0: all
};

// Errors of the vertices in the posed world, and of face normals.
struct CodecErrors {
  ErrorSummary texture_mm;       // simulated against decoded from the texture in float32
  ErrorSummary quantisation_mm;  // decoded from float32 against decoded from int16
  ErrorSummary total_mm;         // simulated against decoded from int16
  ErrorSummary normals_deg;      // of the same, between face normals
  // The finer tessellation decoded from int16, against the simulated surface at its vertices.
  ErrorSummary finer_mm;
  void add(const CodecErrors& other);
};

struct CodecVariant {
  int texture_size = 128;
  Fill fill = Fill::kFitted;
  double scale_m = 0;                // of int16, over all designs
  std::vector<CodecErrors> designs;  // in the garments' order
  CodecErrors all() const;
};

// A frame, as unposed with the inverse of its skinning.
struct UnposedFrame {
  std::string clip_file;
  int frame = 0, design = 0;
  double smallest_singular_value = 1;  // of the blended transforms
};

struct CodecReport {
  std::vector<std::string> designs;
  std::vector<int64_t> frames;            // of each design
  std::vector<ErrorSummary> unposing_mm;  // of each design: simulated, unposed and posed again
  std::vector<CodecVariant> variants;
  int vertices = 0, finer_vertices = 0;
  // The worst conditioned frame of each clip, the worst clip first.
  std::vector<UnposedFrame> worst_unposed;
  // Edges about which the cloth is folded over (its faces more than 105 degrees apart): in the
  // drapes, and beyond those, in the unposed garments; of so many.
  int64_t folds_posed = 0, folds_added = 0, edges = 0;
  bool is_interrupted = false;
};

CodecReport codec_report(const DatasetInputs& inputs, const CodecReportConfig& config);

// Markdown tables, as docs/codec.md has them; and JSON with everything.
std::string to_markdown(const CodecReport& report);
std::string to_json(const CodecReport& report);

}  // namespace pleat::encode
