#include "encode/make_dataset.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "body/body_file.h"
#include "core/error.h"
#include "core/progress.h"
#include "encode/drape_files.h"
#include "encode/error_summary.h"

namespace pleat::encode {
namespace {

// A vertex whose blended transform shrinks by more than this in some direction has its error grown
// as much by posing back.
constexpr double kIllConditioned = 0.25;

std::string list(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

int sequence_of(const garment::Clip& clip, const std::string& file, const EncodeConfig& config,
                std::vector<Sequence>& sequences) {
  for (size_t i = 0; i < sequences.size(); ++i) {
    if (sequences[i].name != clip.motion_name) continue;
    if (std::abs(sequences[i].frame_rate_hz - clip.frame_rate_hz) > 1e-6) {
      throw InputError(file + ": motion " + clip.motion_name + " at " +
                       std::to_string(clip.frame_rate_hz) + " Hz, in another clip at " +
                       std::to_string(sequences[i].frame_rate_hz) + "; expected one rate a motion");
    }
    return static_cast<int>(i);
  }
  sequences.push_back(
      {clip.motion_name, contains(config.held_out_motions, clip.motion_name), clip.frame_rate_hz});
  return static_cast<int>(sequences.size()) - 1;
}

// Where a clip's rows lie.
struct ClipRows {
  std::string file;
  size_t frames = 0;  // of the clip, accepted or not
  size_t first = 0, end = 0;
};

// Appends one row for each accepted frame of the clip.
ClipRows add_rows(const garment::Clip& clip, const std::string& file, const EncodeConfig& config,
                  int64_t shape_count, DatasetContents& contents, DatasetReport& report) {
  if (clip.shape.size() > shape_count) {
    throw InputError(file + ": shape has " + std::to_string(clip.shape.size()) +
                     " coefficients; the body has " + std::to_string(shape_count));
  }
  DatasetRow row;
  row.design = design_of(clip, file, contents.garments);
  row.sequence = sequence_of(clip, file, config, contents.sequences);
  const bool is_design_held_out =
      contents.garments[static_cast<size_t>(row.design)].design.is_held_out;
  const bool is_sequence_held_out =
      contents.sequences[static_cast<size_t>(row.sequence)].is_held_out;
  row.split = static_cast<Split>((is_design_held_out ? kHeldOutDesign : 0) |
                                 (is_sequence_held_out ? kHeldOutSequence : 0));
  row.clip_key = garment::clip_key(file);
  for (const DatasetRow& other : contents.rows) {
    if (other.clip_key == row.clip_key)
      throw InputError(file + ": the clip of key " + row.clip_key + " comes twice");
  }
  row.shape = Eigen::VectorXd::Zero(shape_count);
  row.shape.head(clip.shape.size()) = clip.shape;

  ClipRows rows{file, clip.positions.size(), contents.rows.size(), 0};
  for (size_t t = 0; t < clip.positions.size(); ++t) {
    if (!clip.certificates[t].is_accepted) {
      ++report.rejected_frames;
      continue;
    }
    const bool follows = t > 0 && clip.certificates[t - 1].is_accepted;
    row.previous = follows ? static_cast<int>(contents.rows.size()) - 1 : -1;
    row.frame = static_cast<int>(t);
    row.pose = clip.poses[t];
    row.certificate = clip.certificates[t];
    contents.rows.push_back(row);
    ++report.accepted_frames;
    ++report.split_frames[row.split];
  }
  rows.end = contents.rows.size();
  return rows;
}

// What turns a frame into a texture.
struct Codec {
  body::BodyModel model;
  TextureEncoder encoder;
};

struct EncodedFrame {
  Texture texture;
  std::vector<body::Transform> transforms;
  Eigen::VectorXd smallest_singular_value;  // of each vertex
};

EncodedFrame encode_frame(const Codec& codec, const DatasetContents& contents,
                          const body::ShapedBody& body, const garment::Clip& clip,
                          const DatasetRow& row, const std::string& file) {
  EncodedFrame frame;
  frame.transforms = body::joint_transforms(codec.model, body, row.pose);
  const garment::Garment& garment = contents.garments[static_cast<size_t>(row.design)];
  const Points3 offsets =
      unpose(garment, clip.positions[static_cast<size_t>(row.frame)], frame.transforms,
             contents.skinning, &frame.smallest_singular_value);
  if (!offsets.allFinite()) {
    throw InputError(
        file + ": frame " + std::to_string(row.frame) +
        " cannot be unposed: its skin weights blend to " +
        "a transform that is not invertible; encode.skinning = dual_quaternion would do");
  }
  frame.texture = codec.encoder.encode(offsets);
  return frame;
}

// What the first pass learns about the textures.
struct Survey {
  OffsetSums training_offsets;
  float largest = 0;  // m, of one axis
  double smallest_singular_value = 1;
  int64_t ill_conditioned = 0, vertices = 0;
};

void add(Survey& survey, const EncodedFrame& frame, Split split, const std::vector<uint8_t>& mask) {
  for (const float value : frame.texture.values)
    survey.largest = std::max(survey.largest, std::abs(value));
  if (split == kTrain) add(survey.training_offsets, frame.texture, mask);
  survey.smallest_singular_value =
      std::min(survey.smallest_singular_value, frame.smallest_singular_value.minCoeff());
  survey.ill_conditioned += (frame.smallest_singular_value.array() < kIllConditioned).count();
  survey.vertices += frame.smallest_singular_value.size();
}

void refuse_empty(const DatasetReport& report, const DatasetContents& contents,
                  const EncodeConfig& config) {
  if (report.accepted_frames == 0) {
    throw InputError("none of the " + std::to_string(report.rejected_frames) +
                     " frames was accepted; `pleat simulate` names the reasons");
  }
  for (const std::string& name : config.held_out_motions) {
    const bool is_known =
        std::any_of(contents.sequences.begin(), contents.sequences.end(),
                    [&](const Sequence& sequence) { return sequence.name == name; });
    if (!is_known) {
      std::vector<std::string> known;
      for (const Sequence& sequence : contents.sequences) known.push_back(sequence.name);
      throw InputError("encode.held_out_motions: no clip of the motion " + name +
                       "; there are: " + list(known));
    }
  }
  if (report.split_frames[kTrain] == 0) {
    throw InputError(
        "no frame is left to train on: every accepted one is of a held-out design or of " +
        std::string("encode.held_out_motions"));
  }
}

// Hashes of all clips as one, since an attribute holds 64 KB and a campaign thousands of clips;
// each row has its own key.
void add_inputs(Provenance& provenance, const DatasetInputs& inputs,
                const DatasetContents& contents) {
  provenance.inputs["body"] = contents.body_sha256;
  std::string garments, clips;
  for (const std::string& file : inputs.garment_files) garments += sha256_of_file(file);
  for (const std::string& file : inputs.clip_files) clips += garment::clip_key(file);
  provenance.inputs["garments"] = sha256(garments);
  provenance.inputs["clips"] = sha256(clips);
}

DatasetReport interrupted(DatasetReport report) {
  report.is_interrupted = true;
  return report;
}

}  // namespace

void validate(const EncodeConfig& config) {
  if (config.texture_size < 64 || config.texture_size > 512) {
    throw InputError("encode.texture_size = " + std::to_string(config.texture_size) +
                     "; expected 64 .. 512");
  }
  parse_fill(config.fill);
  parse_skinning(config.skinning);
  if (config.dtype != "int16" && config.dtype != "float32") {
    throw InputError("encode.dtype = " + config.dtype + "; expected int16 or float32");
  }
  if (config.gzip_level < 0 || config.gzip_level > 9) {
    throw InputError("encode.gzip_level = " + std::to_string(config.gzip_level) +
                     "; expected 0 .. 9");
  }
}

std::string summary(const DatasetReport& report) {
  char text[640];
  std::snprintf(text, sizeof text,
                "frames: %lld (train %lld, held-out design %lld, held-out sequence %lld, both "
                "%lld), %lld rejected\n"
                "round trip: mean %.4f mm, p99 %.4f mm, max %.4f mm\n"
                "largest offset %.4f m, step of the file %.3g mm\n"
                "unposing: smallest singular value %.3f, %.3f %% of vertices below %.2f\n",
                static_cast<long long>(report.accepted_frames),
                static_cast<long long>(report.split_frames[kTrain]),
                static_cast<long long>(report.split_frames[kHeldOutDesign]),
                static_cast<long long>(report.split_frames[kHeldOutSequence]),
                static_cast<long long>(report.split_frames[kHeldOutBoth]),
                static_cast<long long>(report.rejected_frames), report.round_trip_mean_mm,
                report.round_trip_p99_mm, report.round_trip_max_mm, report.largest_offset_m,
                1000 * report.scale_m, report.smallest_singular_value,
                100 * report.ill_conditioned_share, kIllConditioned);
  return text;
}

DatasetReport make_dataset(const DatasetInputs& inputs, const EncodeConfig& config,
                           Provenance provenance, const std::string& path) {
  validate(config);
  if (inputs.clip_files.empty()) throw InputError("no clip to encode; simulate the campaign first");

  DatasetContents contents;
  contents.garments = read_garments(inputs.garment_files);
  if (config.held_out_designs) {
    for (garment::Garment& garment : contents.garments)
      garment.design.is_held_out = contains(*config.held_out_designs, garment.design.name);
  }
  const garment::GarmentTopology topology = contents.garments.front().topology;
  UvLayout layout = make_uv_layout(topology, config.texture_size);
  contents.texture_size = config.texture_size;
  contents.mask = layout.mask;
  contents.skinning = parse_skinning(config.skinning);
  contents.body_sha256 = sha256_of_file(inputs.body_file);
  const Codec codec{body::read_body(inputs.body_file),
                    TextureEncoder(topology, std::move(layout), parse_fill(config.fill))};
  const int64_t shape_count =
      std::max<int64_t>(1, static_cast<int64_t>(codec.model.shape_directions.size()));

  DatasetReport report;
  Survey survey;
  std::vector<ClipRows> clips;
  Progress progress("encode", 2 * static_cast<int64_t>(inputs.clip_files.size()), "clips");
  for (const std::string& file : inputs.clip_files) {
    if (is_interrupted()) return interrupted(report);
    const garment::Clip clip = load_clip(file, topology.vertex_count);
    clips.push_back(add_rows(clip, file, config, shape_count, contents, report));
    const body::ShapedBody body = body::shape_body(codec.model, clip.shape);
    for (size_t i = clips.back().first; i < clips.back().end; ++i) {
      const DatasetRow& row = contents.rows[i];
      add(survey, encode_frame(codec, contents, body, clip, row, file), row.split, contents.mask);
    }
    progress.advance(1, "range and statistics");
  }
  refuse_empty(report, contents, config);
  contents.normalisation = normalisation(survey.training_offsets);
  report.largest_offset_m = static_cast<double>(survey.largest);
  report.smallest_singular_value = survey.smallest_singular_value;
  report.ill_conditioned_share =
      static_cast<double>(survey.ill_conditioned) / static_cast<double>(survey.vertices);
  if (config.dtype == "int16") report.scale_m = fixed_point_scale(report.largest_offset_m);

  add_inputs(provenance, inputs, contents);
  DatasetWriter writer(path, contents, report.scale_m, config.gzip_level, provenance);
  ErrorSummary round_trip;
  for (const ClipRows& rows : clips) {
    if (is_interrupted()) return interrupted(report);
    const garment::Clip clip = load_clip(rows.file, topology.vertex_count);
    if (clip.positions.size() != rows.frames)
      throw InputError(rows.file + ": changed while it was being encoded");
    const body::ShapedBody body = body::shape_body(codec.model, clip.shape);
    for (size_t i = rows.first; i < rows.end; ++i) {
      const DatasetRow& row = contents.rows[i];
      const EncodedFrame frame = encode_frame(codec, contents, body, clip, row, rows.file);
      const Points3 decoded =
          decode_texture(writer.append(frame.texture), topology, codec.encoder.reads());
      const Points3 posed = pose(contents.garments[static_cast<size_t>(row.design)], decoded,
                                 frame.transforms, contents.skinning);
      const Eigen::VectorXd errors =
          vertex_distances_mm(posed, clip.positions[static_cast<size_t>(row.frame)]);
      for (const double error : errors) round_trip.add(error);
    }
    progress.advance(1, "writing");
  }
  writer.commit();
  report.round_trip_mean_mm = round_trip.mean();
  report.round_trip_p99_mm = round_trip.percentile(99);
  report.round_trip_max_mm = round_trip.max();
  return report;
}

}  // namespace pleat::encode
