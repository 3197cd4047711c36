#include "garment/clip.h"

#include <array>
#include <cmath>

#include "core/error.h"
#include "core/hdf5_file.h"

namespace pleat::garment {
namespace {

constexpr int kNumbers = 8;  // of a certificate, in the order of the struct

std::array<double, kNumbers> numbers(const Certificate& c) {
  return {c.residual, c.min_gap_m, c.max_strain, c.strain_95, double(c.body_intersections), double(c.self_intersections),
          double(c.iterations), c.seconds};
}

void check(bool is_right, const Hdf5File& file, const std::string& array, const std::string& what) {
  if (!is_right) throw InputError(file.path() + ": " + array + " " + what);
}

}  // namespace

void write_clip(const std::string& path, const Clip& clip, const std::string& key, const Provenance& provenance) {
  const int64_t frames = static_cast<int64_t>(clip.positions.size());
  const int64_t vertices = frames ? clip.positions.front().rows() : 0;
  Hdf5File file = Hdf5File::create(path);
  file.create_dataset("positions", {frames, vertices, 3}, Hdf5Type::kFloat32, 1);
  std::vector<double> rotations, translations, certificates;
  std::vector<uint8_t> accepted;
  std::vector<std::string> reasons;
  for (int64_t t = 0; t < frames; ++t) {
    file.write_rows("positions", t, 1, clip.positions[t].data());
    const body::Pose& pose = clip.poses[t];
    rotations.insert(rotations.end(), pose.rotations.data(), pose.rotations.data() + pose.rotations.size());
    translations.insert(translations.end(), pose.translation.data(), pose.translation.data() + 3);
    for (double number : numbers(clip.certificates[t])) certificates.push_back(number);
    accepted.push_back(clip.certificates[t].is_accepted);
    reasons.push_back(clip.certificates[t].reason);
  }
  file.write("rotations", rotations, {frames, body::kJoints, 3});
  file.write("translations", translations, {frames, 3});
  file.write("shape", clip.shape.data(), {clip.shape.size()});
  file.write("certificate", certificates, {frames, kNumbers});
  file.write_attribute("certificate", "columns",
                       "residual, min_gap_m, max_strain, strain_95, body_intersections, self_intersections, iterations, seconds");
  file.write("accepted", accepted, {frames});
  file.write("reason", reasons);
  file.write_attribute("/", "design_name", clip.design.name);
  file.write_attribute("/", "length", clip.design.length);
  file.write_attribute("/", "sleeve", clip.design.sleeve);
  file.write_attribute("/", "cleavage", clip.design.cleavage);
  file.write_attribute("/", "held_out", static_cast<int64_t>(clip.design.is_held_out));
  file.write_attribute("/", "motion_name", clip.motion_name);
  file.write_attribute("/", "frame_rate_hz", clip.frame_rate_hz);
  file.write_attribute("/", "key", key);
  write_provenance(file, provenance);
  file.commit();
}

Clip read_clip(const std::string& path) {
  const Hdf5File file = Hdf5File::open(path);
  Clip clip;
  const Dims dims = file.dims("positions");
  check(dims.size() == 3 && dims[2] == 3, file, "positions", "is not frames x vertices x 3");
  const int64_t frames = dims[0], vertices = dims[1];
  check(file.dims("rotations") == Dims{frames, body::kJoints, 3}, file, "rotations", "is not frames x 24 x 3");
  check(file.dims("translations") == Dims{frames, 3}, file, "translations", "is not frames x 3");
  check(file.dims("certificate") == Dims{frames, kNumbers}, file, "certificate", "is not frames x 8");
  check(file.dims("accepted") == Dims{frames}, file, "accepted", "is not one a frame");
  check(file.dims("shape").size() == 1, file, "shape", "is not a list");
  const std::vector<double> rotations = file.read<double>("rotations"), translations = file.read<double>("translations");
  const std::vector<double> certificates = file.read<double>("certificate"), shape = file.read<double>("shape");
  const std::vector<uint8_t> accepted = file.read<uint8_t>("accepted");
  const std::vector<std::string> reasons = file.read_texts("reason");
  check(static_cast<int64_t>(reasons.size()) == frames, file, "reason", "is not one a frame");
  for (int64_t t = 0; t < frames; ++t) {
    Points3 positions(vertices, 3);
    file.read_rows("positions", t, 1, positions.data());
    check(positions.allFinite(), file, "positions", "frame " + std::to_string(t) + " has numbers that are not finite");
    clip.positions.push_back(positions);
    body::Pose pose;
    pose.rotations = Eigen::Map<const Points3>(rotations.data() + t * body::kJoints * 3, body::kJoints, 3);
    pose.translation = Eigen::Map<const Vec<3>>(translations.data() + 3 * t);
    check(pose.rotations.allFinite() && pose.translation.allFinite(), file, "rotations, translations",
          "frame " + std::to_string(t) + " have numbers that are not finite");
    clip.poses.push_back(pose);
    const double* n = certificates.data() + t * kNumbers;
    clip.certificates.push_back({n[0], n[1], n[2], n[3], static_cast<int>(n[4]), static_cast<int>(n[5]), static_cast<int>(n[6]),
                                 n[7], accepted[t] != 0, reasons[t]});
  }
  clip.shape = Eigen::Map<const Eigen::VectorXd>(shape.data(), shape.size());
  clip.design = {file.text_attribute("/", "design_name"), file.number_attribute("/", "length"),
                 file.number_attribute("/", "sleeve"), file.number_attribute("/", "cleavage"),
                 file.number_attribute("/", "held_out") != 0};
  validate(clip.design);
  clip.motion_name = file.text_attribute("/", "motion_name");
  clip.frame_rate_hz = file.number_attribute("/", "frame_rate_hz");
  check(clip.frame_rate_hz > 0, file, "frame_rate_hz", "is not > 0");
  return clip;
}

std::string clip_key(const std::string& path) { return Hdf5File::open(path).text_attribute("/", "key"); }

}  // namespace pleat::garment
