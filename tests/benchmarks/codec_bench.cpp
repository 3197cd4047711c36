// Drapes to textures and back, on a garment of 5k vertices; textures from the page cache.
#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <string>

#include "core/hdf5_file.h"
#include "core/random.h"
#include "encode/texture.h"
#include "encode/unpose.h"
#include "tests/benchmarks/bench.h"
#include "tests/core/scratch.h"

namespace pleat::bench {
namespace {

constexpr int kSize = 128;

// Waves of 10 mm, 30 mm long, on four joints that turn by a radian between them.
garment::Garment wavy_garment(Points3& posed, std::vector<body::Transform>& transforms) {
  garment::Garment garment;
  garment.topology = garment::make_topology(5000);
  garment.panels = garment::cut_panels(garment.topology, {});
  const int count = garment.topology.vertex_count;
  garment.t_pose.resize(count, 3);
  Points3 offsets(count, 3);
  std::vector<Eigen::Triplet<double>> weights;
  for (int m = 0; m < garment.panels.rows(); ++m) {
    const double x = garment.panels(m, 0), y = garment.panels(m, 1), phase = 2 * M_PI / 0.03 * x;
    const int v = garment.topology.sewn_vertex[m];
    garment.t_pose.row(v) << x, y, 0.1 * std::cos(3 * x);
    offsets.row(v) << 0.01 * std::sin(phase), 0.005, 0.01 * std::cos(phase);
  }
  for (int v = 0; v < count; ++v)
    for (int k = 0; k < 4; ++k) weights.emplace_back(v, (v + 5 * k) % body::kJoints, 0.25);
  garment.weights.resize(count, body::kJoints);
  garment.weights.setFromTriplets(weights.begin(), weights.end());
  for (int j = 0; j < body::kJoints; ++j) {
    body::Transform transform;
    transform << Eigen::AngleAxisd(j / 24.0, Vec<3>::UnitY()).toRotationMatrix(), Vec<3>(0, 1, 0);
    transforms.push_back(transform);
  }
  posed = encode::pose(garment, offsets, transforms, encode::Skinning::kLinear);
  return garment;
}

void bench_reading(Report& report) {
  constexpr int kFrames = 2048, kBatch = 8, kBatches = 512;  // 200 MB
  const Scratch scratch;
  const std::string path = scratch.path("textures.h5");
  constexpr int64_t kValues = 3 * kSize * kSize;
  {
    Hdf5File file = Hdf5File::create(path);
    file.create_dataset("textures", {kFrames, 3, kSize, kSize}, Hdf5Type::kInt16, 1, 0);
    std::vector<int16_t> texture(kValues);
    for (int64_t i = 0; i < kValues; ++i) texture[i] = static_cast<int16_t>(i % 30000);
    for (int f = 0; f < kFrames; ++f) file.write_rows("textures", f, 1, texture.data());
    file.commit();
  }
  const Hdf5File file = Hdf5File::open(path);
  std::vector<int16_t> batch(kBatch * kValues);
  RandomStream random(1, "shuffle");
  report.rate("codec.read_shuffled.frames_per_s", 5, kBatch * kBatches, [&] {
    for (int b = 0; b < kBatches; ++b)
      for (int k = 0; k < kBatch; ++k)
        file.read_rows("textures", static_cast<int64_t>(random.below(kFrames)), 1,
                       batch.data() + k * kValues);
  });
}

}  // namespace

void bench_codec(Report& report) {
  Points3 posed;
  std::vector<body::Transform> transforms;
  const garment::Garment garment = wavy_garment(posed, transforms);
  const garment::GarmentTopology& topology = garment.topology;
  encode::UvLayout layout;
  report.time("codec.uv_layout_5k", 5, [&] { layout = encode::make_uv_layout(topology, kSize); });
  for (const auto fill : {encode::Fill::kBarycentric, encode::Fill::kFitted}) {
    const bool is_fitted = fill == encode::Fill::kFitted;
    const std::string of = is_fitted ? "" : "_barycentric";
    const encode::TextureEncoder encoder(topology, layout, fill);
    const double scale = encode::fixed_point_scale(0.05);
    std::vector<int16_t> stored;
    // As `pleat encode` does it: unpose, fill, round; and back to posed vertices.
    report.rate("codec.encode_5k" + of + ".frames_per_s", 20, 20, [&] {
      for (int k = 0; k < 20; ++k)
        stored = encode::to_fixed_point(
            encoder.encode(encode::unpose(garment, posed, transforms, encode::Skinning::kLinear)),
            scale);
    });
    Points3 decoded;
    report.rate("codec.decode_5k" + of + ".frames_per_s", 20, 20, [&] {
      for (int k = 0; k < 20; ++k)
        decoded =
            encode::pose(garment,
                         encode::decode_texture(encode::from_fixed_point(stored, kSize, scale),
                                                topology, encoder.reads()),
                         transforms, encode::Skinning::kLinear);
    });
    report.add("codec.round_trip_mean" + of, 1000 * (decoded - posed).rowwise().norm().mean(),
               "mm");
  }
  bench_reading(report);
}

}  // namespace pleat::bench
