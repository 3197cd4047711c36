#include "garment/clip.h"

#include <cmath>
#include <functional>
#include <optional>
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

// What a file says of its states before they are read.
struct StateList {
  std::vector<int> frames;
  std::vector<uint8_t> is_sound;
};

void write_states(Hdf5File& file, const StateList& list, int64_t vertices,
                  const std::function<ClipState(int64_t)>& state_at) {
  const int64_t count = static_cast<int64_t>(list.frames.size());
  file.write("states/frame", list.frames, {count});
  file.write("states/is_sound", list.is_sound, {count});
  if (count == 0) return;
  file.create_dataset("states/positions", {count, vertices, 3}, Hdf5Type::kFloat64);
  file.create_dataset("states/anchor_faces", {count, vertices}, Hdf5Type::kInt32, 1, 1);
  file.create_dataset("states/anchor_barycentrics", {count, vertices, 3}, Hdf5Type::kFloat64, 1, 1);
  for (int64_t k = 0; k < count; ++k) {
    const ClipState state = state_at(k);
    if (state.positions.rows() != vertices)
      throw std::invalid_argument("write_clip: states and frames differ in their vertices");
    file.write_rows("states/positions", k, 1, state.positions.data());
    file.write_rows("states/anchor_faces", k, 1, state.anchor_faces.data());
    file.write_rows("states/anchor_barycentrics", k, 1, state.anchor_barycentrics.data());
  }
}

// Frames rise, and lie behind the clip's first and not behind its end.
StateList read_state_list(const Hdf5File& file, int first_frame, int64_t frames) {
  const Dims dims = file.dims("states/frame");
  if (dims.size() != 1) refuse(file, "states/frame", "its shape is not [n]");
  if (file.dims("states/is_sound") != dims) refuse(file, "states/is_sound", "has another shape");
  StateList list{file.read<int>("states/frame"), file.read<uint8_t>("states/is_sound")};
  int64_t before = first_frame;
  for (int frame : list.frames) {
    if (frame <= before || frame > first_frame + frames)
      refuse(file, "states/frame", "is no rising list of frames of the clip");
    before = frame;
  }
  return list;
}

ClipState read_state(const Hdf5File& file, const StateList& list, int64_t vertices, int64_t k) {
  const int64_t count = static_cast<int64_t>(list.frames.size());
  checked_dims(file, "states/positions", {count, vertices, 3});
  checked_dims(file, "states/anchor_faces", {count, vertices});
  checked_dims(file, "states/anchor_barycentrics", {count, vertices, 3});
  const size_t i = static_cast<size_t>(k);
  ClipState state{list.frames[i], list.is_sound[i] != 0, Points3(vertices, 3),
                  Eigen::VectorXi(vertices), Points3(vertices, 3)};
  file.read_rows("states/positions", k, 1, state.positions.data());
  file.read_rows("states/anchor_faces", k, 1, state.anchor_faces.data());
  file.read_rows("states/anchor_barycentrics", k, 1, state.anchor_barycentrics.data());
  if (!state.positions.allFinite() || !state.anchor_barycentrics.allFinite())
    refuse(file, "states", "holds a value that is not finite");
  if (state.anchor_faces.minCoeff() < -1) refuse(file, "states/anchor_faces", "holds no face");
  return state;
}

// A clip whose positions and states come one by one; clip.frame_sha256 is known.
void write_clip_file(const std::string& path, const Clip& clip, int64_t vertices,
                     const std::function<Points3(int64_t)>& positions, const StateList& states,
                     const std::function<ClipState(int64_t)>& state_at, const std::string& key,
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
  write_states(file, states, vertices, state_at);
  file.write_attribute("/", "key", key);
  file.write_attribute("/", "content_sha256", content_hash(key, clip.frame_sha256));
  file.write_attribute("/", "motion_name", clip.motion_name);
  file.write_attribute("/", "frame_rate_hz", clip.frame_rate_hz);
  file.write_attribute("/", "first_frame", clip.first_frame);
  file.write_attribute("/", "from_sha256", clip.from_sha256);
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
  clip.from_sha256 = file.text_attribute("/", "from_sha256");

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

std::string state_hash(const ClipState& state) {
  Sha256 hash;
  const int head[2] = {state.frame, state.is_sound ? 1 : 0};
  hash.add(head, sizeof head);
  hash.add(state.positions.data(), sizeof(double) * static_cast<size_t>(state.positions.size()));
  hash.add(state.anchor_faces.data(), sizeof(int) * static_cast<size_t>(state.anchor_faces.size()));
  hash.add(state.anchor_barycentrics.data(),
           sizeof(double) * static_cast<size_t>(state.anchor_barycentrics.size()));
  return hash.hex();
}

void write_clip(const std::string& path, const Clip& clip, const std::string& key,
                const Provenance& provenance) {
  const size_t frames = clip.positions.size();
  if (frames == 0 || clip.poses.size() != frames || clip.certificates.size() != frames)
    throw std::invalid_argument(
        "write_clip: a clip has one pose, position and certificate a frame, and a frame");
  Clip head = clip;
  head.positions.clear();
  head.states.clear();
  head.frame_sha256.clear();
  for (size_t t = 0; t < frames; ++t)
    head.frame_sha256.push_back(frame_hash(clip, static_cast<int>(t)));
  StateList states;
  for (const ClipState& state : clip.states) {
    states.frames.push_back(state.frame);
    states.is_sound.push_back(state.is_sound ? 1 : 0);
  }
  write_clip_file(
      path, head, clip.positions.front().rows(),
      [&](int64_t t) { return clip.positions[static_cast<size_t>(t)]; }, states,
      [&](int64_t k) { return clip.states[static_cast<size_t>(k)]; }, key, provenance);
}

Clip read_clip_frames(const std::string& path, int first, int count) {
  const Hdf5File file = Hdf5File::open(path);
  Clip clip = read_head(file);
  const int total = static_cast<int>(clip.poses.size());
  if (first < 0 || count < 1 || first > total - count)
    throw InputError(path + ": has " + std::to_string(total) + " frames; " + std::to_string(first) +
                     " to " + std::to_string(first + count - 1) + " were asked for");
  const StateList list = read_state_list(file, clip.first_frame, total);
  const int64_t vertices = file.dims("positions")[1];
  const auto cut = [&](auto& values) {
    values.erase(values.begin() + first + count, values.end());
    values.erase(values.begin(), values.begin() + first);
  };
  cut(clip.poses);
  cut(clip.certificates);
  cut(clip.frame_sha256);
  for (int t = first; t < first + count; ++t)
    clip.positions.push_back(read_positions(file, vertices, t));
  const int begin = clip.first_frame + first;
  // A whole clip's last state may start a frame behind its end.
  const int end = begin + count + (first + count == total ? 1 : 0);
  for (size_t k = 0; k < list.frames.size(); ++k)
    if (list.frames[k] >= begin && list.frames[k] < end)
      clip.states.push_back(read_state(file, list, vertices, static_cast<int64_t>(k)));
  if (first > 0) clip.from_sha256.clear();
  clip.first_frame = begin;
  return clip;
}

Clip read_clip(const std::string& path) {
  const int64_t frames = checked_dims(Hdf5File::open(path), "positions", {-1, -1, 3})[0];
  return read_clip_frames(path, 0, static_cast<int>(std::min<int64_t>(frames, 1 << 30)));
}

Clip read_clip_head(const std::string& path) { return read_head(Hdf5File::open(path)); }

void join_clips(const std::vector<std::string>& parts, const std::string& path) {
  if (parts.empty()) throw std::invalid_argument("join_clips: no part");
  struct Place {
    size_t part;
    int64_t row;
  };
  std::vector<Place> frames, ends;  // of each frame, of each state
  StateList states;
  std::vector<StateList> lists;  // of each part
  Clip whole;
  int64_t vertices = 0;
  for (size_t p = 0; p < parts.size(); ++p) {
    const Hdf5File file = Hdf5File::open(parts[p]);
    Clip part = read_head(file);
    const int next = whole.first_frame + static_cast<int>(whole.poses.size());
    if (p > 0 && part.first_frame != next)
      refuse(file, "first_frame", "does not follow the part before");
    const int64_t count = static_cast<int64_t>(part.poses.size());
    const StateList list = read_state_list(file, part.first_frame, count);
    for (size_t k = 0; k < list.frames.size(); ++k) {
      states.frames.push_back(list.frames[k]);
      states.is_sound.push_back(list.is_sound[k]);
      ends.push_back({p, static_cast<int64_t>(k)});
    }
    lists.push_back(list);
    for (int64_t t = 0; t < count; ++t) frames.push_back({p, t});
    if (p == 0) {
      vertices = file.dims("positions")[1];
      whole = std::move(part);
      continue;
    }
    const auto append = [](auto& all, const auto& more) {
      all.insert(all.end(), more.begin(), more.end());
    };
    append(whole.poses, part.poses);
    append(whole.certificates, part.certificates);
    append(whole.frame_sha256, part.frame_sha256);
  }
  const int end = whole.first_frame + static_cast<int>(whole.poses.size());
  if (!states.frames.empty() && states.frames.back() == end) {
    states.frames.pop_back();
    states.is_sound.pop_back();
  }
  std::optional<Hdf5File> open;
  size_t open_part = parts.size();
  const auto file_of = [&](const Place& place) -> const Hdf5File& {
    if (place.part != open_part) open.emplace(Hdf5File::open(parts[place.part]));
    open_part = place.part;
    return *open;
  };
  const Hdf5File first = Hdf5File::open(parts.front());
  write_clip_file(
      path, whole, vertices,
      [&](int64_t t) {
        const Place& place = frames[static_cast<size_t>(t)];
        return read_positions(file_of(place), vertices, place.row);
      },
      states,
      [&](int64_t k) {
        const Place& place = ends[static_cast<size_t>(k)];
        return read_state(file_of(place), lists[place.part], vertices, place.row);
      },
      first.text_attribute("/", "key"), read_provenance(first));
}

std::string clip_key(const std::string& path) {
  return Hdf5File::open(path).text_attribute("/", "key");
}

}  // namespace pleat::garment
