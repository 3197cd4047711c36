#include "garment/clip.h"

#include <cmath>
#include <functional>
#include <stdexcept>
#include <utility>

#include "core/error.h"
#include "core/hdf5_file.h"
#include "garment/checked_arrays.h"

namespace pleat::garment {
namespace {

// Columns of `certificates`.
constexpr int64_t kNumbers = 11;

std::vector<double> numbers(const Certificate& c) {
  return {c.residual,
          c.is_stable ? 1.0 : 0.0,
          c.min_gap_m,
          c.max_strain,
          c.strain_95,
          static_cast<double>(c.body_intersections),
          static_cast<double>(c.overlap_intersections),
          static_cast<double>(c.self_intersections),
          static_cast<double>(c.iterations),
          static_cast<double>(c.attempts),
          c.seconds};
}

int whole(const Hdf5File& file, double number) {
  if (!(number >= 0 && number <= 1e9))
    refuse(file, "certificates", "a count is negative or too large");
  return static_cast<int>(number);
}

Certificate certificate(const Hdf5File& file, const double* n) {
  Certificate c;
  c.residual = n[0];
  c.is_stable = n[1] != 0;
  c.min_gap_m = n[2];
  c.max_strain = n[3];
  c.strain_95 = n[4];
  c.body_intersections = whole(file, n[5]);
  c.overlap_intersections = whole(file, n[6]);
  c.self_intersections = whole(file, n[7]);
  c.iterations = whole(file, n[8]);
  c.attempts = whole(file, n[9]);
  c.seconds = n[10];
  return c;
}

void write_states(Hdf5File& file, const std::vector<ClipState>& states, int64_t vertices) {
  const int64_t count = static_cast<int64_t>(states.size());
  std::vector<int> frames;
  std::vector<uint8_t> is_sound;
  for (const ClipState& state : states) {
    frames.push_back(state.frame);
    is_sound.push_back(state.is_sound ? 1 : 0);
  }
  file.write("states/frame", frames, {count});
  file.write("states/is_sound", is_sound, {count});
  if (count == 0) return;
  file.create_dataset("states/positions", {count, vertices, 3}, Hdf5Type::kFloat64);
  file.create_dataset("states/anchor_faces", {count, vertices}, Hdf5Type::kInt32, 1, 1);
  file.create_dataset("states/anchor_barycentrics", {count, vertices, 3}, Hdf5Type::kFloat64, 1, 1);
  for (int64_t k = 0; k < count; ++k) {
    const ClipState& state = states[static_cast<size_t>(k)];
    file.write_rows("states/positions", k, 1, state.positions.data());
    file.write_rows("states/anchor_faces", k, 1, state.anchor_faces.data());
    file.write_rows("states/anchor_barycentrics", k, 1, state.anchor_barycentrics.data());
  }
}

std::vector<ClipState> read_states(const Hdf5File& file, int64_t vertices) {
  std::vector<ClipState> states;
  const Dims dims = file.dims("states/frame");
  if (dims.size() != 1) refuse(file, "states/frame", "its shape is not [n]");
  const std::vector<int> frames = file.read<int>("states/frame");
  const int64_t count = dims[0];
  if (count == 0) return states;
  checked_dims(file, "states/is_sound", {count});
  const std::vector<uint8_t> is_sound = file.read<uint8_t>("states/is_sound");
  checked_dims(file, "states/positions", {count, vertices, 3});
  checked_dims(file, "states/anchor_faces", {count, vertices});
  checked_dims(file, "states/anchor_barycentrics", {count, vertices, 3});
  for (int64_t k = 0; k < count; ++k) {
    const size_t i = static_cast<size_t>(k);
    ClipState state{frames[i], is_sound[i] != 0, Points3(vertices, 3), Eigen::VectorXi(vertices),
                    Points3(vertices, 3)};
    file.read_rows("states/positions", k, 1, state.positions.data());
    file.read_rows("states/anchor_faces", k, 1, state.anchor_faces.data());
    file.read_rows("states/anchor_barycentrics", k, 1, state.anchor_barycentrics.data());
    if (!state.positions.allFinite() || !state.anchor_barycentrics.allFinite())
      refuse(file, "states", "holds a value that is not finite");
    states.push_back(std::move(state));
  }
  return states;
}

// A clip whose positions come frame by frame; clip.frame_sha256 is known.
void write_clip_file(const std::string& path, const Clip& clip, int64_t vertices,
                     const std::function<Points3(int64_t)>& positions, const std::string& key,
                     const Provenance& provenance) {
  const int64_t frames = static_cast<int64_t>(clip.poses.size());
  Hdf5File file = Hdf5File::create(path);
  std::vector<double> rotations, translations, certificates;
  std::vector<uint8_t> is_accepted;
  std::vector<std::string> reasons;
  for (const body::Pose& pose : clip.poses) {
    rotations.insert(rotations.end(), pose.rotations.data(),
                     pose.rotations.data() + pose.rotations.size());
    translations.insert(translations.end(), pose.translation.data(), pose.translation.data() + 3);
  }
  for (const Certificate& c : clip.certificates) {
    const std::vector<double> row = numbers(c);
    certificates.insert(certificates.end(), row.begin(), row.end());
    is_accepted.push_back(c.is_accepted ? 1 : 0);
    reasons.push_back(c.reason);
  }
  file.write("rotations", rotations, {frames, body::kJoints, 3});
  file.write("translations", translations, {frames, 3});
  file.write("shape", clip.shape.data(), {clip.shape.size()});
  file.write("certificates", certificates, {frames, kNumbers});
  file.write("is_accepted", is_accepted, {frames});
  file.write("reasons", reasons);
  file.write("frame_sha256", clip.frame_sha256);
  file.create_dataset("positions", {frames, vertices, 3}, Hdf5Type::kFloat32);
  for (int64_t t = 0; t < frames; ++t) {
    const Points3 x = positions(t);
    if (x.rows() != vertices)
      throw std::invalid_argument("write_clip: frames differ in their vertices");
    file.write_rows("positions", t, 1, x.data());
  }
  write_states(file, clip.states, vertices);
  file.write_attribute("/", "key", key);
  file.write_attribute("/", "content_sha256", content_hash(key, clip.frame_sha256));
  file.write_attribute("/", "motion_name", clip.motion_name);
  file.write_attribute("/", "frame_rate_hz", clip.frame_rate_hz);
  file.write_attribute("/", "first_frame", clip.first_frame);
  write_design(file, clip.design);
  write_fabric(file, clip.fabric);
  write_provenance(file, provenance);
  file.commit();
}

Points3 read_positions(const Hdf5File& file, int64_t vertices, int64_t t) {
  Points3 x(vertices, 3);
  file.read_rows("positions", t, 1, x.data());
  if (!x.allFinite())
    refuse(file, "positions", "frame " + std::to_string(t) + " holds a value that is not finite");
  return x;
}

Clip read_head(const Hdf5File& file) {
  Clip clip;
  clip.design = read_design(file);
  clip.fabric = read_fabric(file);
  clip.motion_name = file.text_attribute("/", "motion_name");
  clip.frame_rate_hz = file.number_attribute("/", "frame_rate_hz");
  if (!(clip.frame_rate_hz > 0) || !std::isfinite(clip.frame_rate_hz))
    refuse(file, "frame_rate_hz", "expected > 0");
  clip.first_frame = whole(file, file.number_attribute("/", "first_frame"));

  const Dims dims = checked_dims(file, "positions", {-1, -1, 3});
  const int64_t frames = dims[0];
  checked_dims(file, "rotations", {frames, body::kJoints, 3});
  const std::vector<double> rotations = file.read<double>("rotations");
  const Points3 translations = read_reals<Points3>(file, "translations", frames);
  for (int64_t t = 0; t < frames; ++t) {
    body::Pose pose;
    pose.rotations =
        Eigen::Map<const Points3>(rotations.data() + t * body::kJoints * 3, body::kJoints, 3);
    pose.translation = translations.row(t);
    if (!pose.rotations.allFinite())
      refuse(file, "rotations", "frame " + std::to_string(t) + " holds a value that is not finite");
    clip.poses.push_back(std::move(pose));
  }
  if (file.dims("shape").size() != 1 || file.dims("shape")[0] > 1000)
    refuse(file, "shape", "its shape is not [n]");
  const std::vector<double> shape = file.read<double>("shape");
  clip.shape =
      Eigen::Map<const Eigen::VectorXd>(shape.data(), static_cast<Eigen::Index>(shape.size()));
  if (!clip.shape.allFinite()) refuse(file, "shape", "holds a value that is not finite");

  checked_dims(file, "certificates", {frames, kNumbers});
  checked_dims(file, "is_accepted", {frames});
  checked_dims(file, "reasons", {frames});
  checked_dims(file, "frame_sha256", {frames});
  const std::vector<double> certificates = file.read<double>("certificates");
  const std::vector<uint8_t> is_accepted = file.read<uint8_t>("is_accepted");
  const std::vector<std::string> reasons = file.read_texts("reasons");
  for (size_t t = 0; t < static_cast<size_t>(frames); ++t) {
    clip.certificates.push_back(certificate(file, certificates.data() + t * kNumbers));
    clip.certificates.back().is_accepted = is_accepted[t] != 0;
    clip.certificates.back().reason = reasons[t];
  }
  clip.frame_sha256 = file.read_texts("frame_sha256");
  return clip;
}

}  // namespace

std::string frame_hash(const Clip& clip, int t) {
  Sha256 hash;
  const auto add = [&](const auto& numbers) {
    hash.add(numbers.data(), static_cast<size_t>(numbers.size()) * sizeof(*numbers.data()));
  };
  const size_t i = static_cast<size_t>(t);
  add(clip.poses[i].rotations);
  add(clip.poses[i].translation);
  add(Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>(clip.positions[i].cast<float>()));
  std::vector<double> certified = numbers(clip.certificates[i]);
  certified.pop_back();  // seconds
  add(certified);
  add(clip.certificates[i].reason);
  return hash.hex();
}

std::string content_hash(const std::string& key, const std::vector<std::string>& frame_sha256) {
  std::string text = key + "\n";
  for (const std::string& hash : frame_sha256) text += hash + "\n";
  return sha256(text);
}

void write_clip(const std::string& path, const Clip& clip, const std::string& key,
                const Provenance& provenance) {
  const size_t frames = clip.positions.size();
  if (frames == 0 || clip.poses.size() != frames || clip.certificates.size() != frames)
    throw std::invalid_argument(
        "write_clip: a clip has one pose, position and certificate a frame, and a frame");
  Clip head = clip;
  head.positions.clear();
  head.frame_sha256.clear();
  for (size_t t = 0; t < frames; ++t)
    head.frame_sha256.push_back(frame_hash(clip, static_cast<int>(t)));
  write_clip_file(
      path, head, clip.positions.front().rows(),
      [&](int64_t t) { return clip.positions[static_cast<size_t>(t)]; }, key, provenance);
}

Clip read_clip(const std::string& path) {
  const Hdf5File file = Hdf5File::open(path);
  Clip clip = read_head(file);
  const int64_t vertices = file.dims("positions")[1];
  for (size_t t = 0; t < clip.poses.size(); ++t)
    clip.positions.push_back(read_positions(file, vertices, static_cast<int64_t>(t)));
  clip.states = read_states(file, vertices);
  return clip;
}

Clip read_clip_head(const std::string& path) { return read_head(Hdf5File::open(path)); }

void join_clips(const std::vector<std::string>& parts, const std::string& path) {
  if (parts.empty()) throw std::invalid_argument("join_clips: no part");
  std::vector<Hdf5File> files;
  for (const std::string& part : parts) files.push_back(Hdf5File::open(part));
  Clip whole;
  std::vector<std::pair<const Hdf5File*, int64_t>> place;  // of each frame
  const int64_t vertices = files.front().dims("positions")[1];
  for (const Hdf5File& file : files) {
    Clip part = read_head(file);
    if (&file == &files.front()) {
      whole = part;
    } else {
      if (part.first_frame != whole.first_frame + static_cast<int>(whole.poses.size()))
        refuse(file, "first_frame", "does not follow the part before");
      whole.poses.insert(whole.poses.end(), part.poses.begin(), part.poses.end());
      whole.certificates.insert(whole.certificates.end(), part.certificates.begin(),
                                part.certificates.end());
      whole.frame_sha256.insert(whole.frame_sha256.end(), part.frame_sha256.begin(),
                                part.frame_sha256.end());
    }
    for (size_t t = 0; t < part.poses.size(); ++t)
      place.emplace_back(&file, static_cast<int64_t>(t));
    for (ClipState& state : read_states(file, vertices)) whole.states.push_back(std::move(state));
  }
  const int end = whole.first_frame + static_cast<int>(whole.poses.size());
  if (!whole.states.empty() && whole.states.back().frame == end) whole.states.pop_back();
  write_clip_file(
      path, whole, vertices,
      [&](int64_t t) {
        const auto& [file, row] = place[static_cast<size_t>(t)];
        return read_positions(*file, vertices, row);
      },
      files.front().text_attribute("/", "key"), read_provenance(files.front()));
}

std::string clip_key(const std::string& path) {
  return Hdf5File::open(path).text_attribute("/", "key");
}

}  // namespace pleat::garment
