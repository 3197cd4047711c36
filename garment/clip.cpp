#include "garment/clip.h"

#include <cmath>
#include <stdexcept>

#include "core/error.h"
#include "core/hdf5_file.h"
#include "garment/checked_arrays.h"

namespace pleat::garment {
namespace {

// Columns of `certificates`.
constexpr int64_t kNumbers = 10;

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
  c.seconds = n[9];
  return c;
}

}  // namespace

void write_clip(const std::string& path, const Clip& clip, const std::string& key,
                const Provenance& provenance) {
  const int64_t frames = static_cast<int64_t>(clip.positions.size());
  if (frames == 0 || clip.poses.size() != clip.positions.size() ||
      clip.certificates.size() != clip.positions.size())
    throw std::invalid_argument(
        "write_clip: a clip has one pose, position and certificate a frame, and a frame");
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
  const int64_t vertices = clip.positions.front().rows();
  file.create_dataset("positions", {frames, vertices, 3}, Hdf5Type::kFloat32);
  for (int64_t t = 0; t < frames; ++t) {
    const Points3& x = clip.positions[static_cast<size_t>(t)];
    if (x.rows() != vertices)
      throw std::invalid_argument("write_clip: frames differ in their vertices");
    file.write_rows("positions", t, 1, x.data());
  }
  file.write_attribute("/", "key", key);
  file.write_attribute("/", "motion_name", clip.motion_name);
  file.write_attribute("/", "frame_rate_hz", clip.frame_rate_hz);
  write_design(file, clip.design);
  write_fabric(file, clip.fabric);
  write_provenance(file, provenance);
  file.commit();
}

Clip read_clip(const std::string& path) {
  const Hdf5File file = Hdf5File::open(path);
  Clip clip;
  clip.design = read_design(file);
  clip.fabric = read_fabric(file);
  clip.motion_name = file.text_attribute("/", "motion_name");
  clip.frame_rate_hz = file.number_attribute("/", "frame_rate_hz");
  if (!(clip.frame_rate_hz > 0) || !std::isfinite(clip.frame_rate_hz))
    refuse(file, "frame_rate_hz", "expected > 0");

  const Dims dims = checked_dims(file, "positions", {-1, -1, 3});
  const int64_t frames = dims[0], vertices = dims[1];
  for (int64_t t = 0; t < frames; ++t) {
    Points3 x(vertices, 3);
    file.read_rows("positions", t, 1, x.data());
    if (!x.allFinite())
      refuse(file, "positions", "frame " + std::to_string(t) + " holds a value that is not finite");
    clip.positions.push_back(std::move(x));
  }

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
  const std::vector<double> certificates = file.read<double>("certificates");
  const std::vector<uint8_t> is_accepted = file.read<uint8_t>("is_accepted");
  const std::vector<std::string> reasons = file.read_texts("reasons");
  for (size_t t = 0; t < static_cast<size_t>(frames); ++t) {
    clip.certificates.push_back(certificate(file, certificates.data() + t * kNumbers));
    clip.certificates.back().is_accepted = is_accepted[t] != 0;
    clip.certificates.back().reason = reasons[t];
  }
  return clip;
}

std::string clip_key(const std::string& path) {
  return Hdf5File::open(path).text_attribute("/", "key");
}

}  // namespace pleat::garment
