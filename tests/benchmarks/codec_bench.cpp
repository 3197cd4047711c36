// Offsets to texture and back, on a garment of 5k vertices.
#include <cmath>
#include <string>

#include "encode/texture.h"
#include "tests/benchmarks/bench.h"

namespace pleat::bench {

void bench_codec(Report& report) {
  constexpr int kSize = 128;
  const garment::GarmentTopology topology = garment::make_topology(5000);
  const Points2 panels = garment::cut_panels(topology, {});
  Points3 offsets = Points3::Zero(topology.vertex_count, 3);  // 30 mm waves of 10 mm
  for (int m = 0; m < panels.rows(); ++m) {
    const double phase = 2 * M_PI / 0.03 * panels(m, 0);
    offsets.row(topology.sewn_vertex[m]) << 0.01 * std::sin(phase), 0.005, 0.01 * std::cos(phase);
  }
  encode::UvLayout layout;
  report.time("codec/uv_layout_5k", 5, [&] { layout = encode::make_uv_layout(topology, kSize); });
  for (const auto fill : {encode::Fill::kBarycentric, encode::Fill::kFitted}) {
    const std::string name = fill == encode::Fill::kFitted ? "fitted" : "barycentric";
    const encode::TextureEncoder encoder(topology, layout, fill);
    encode::Texture texture;
    Points3 decoded;
    report.time("codec/encode_5k_" + name, 50, [&] { texture = encoder.encode(offsets); });
    report.time("codec/decode_5k_" + name, 50,
                [&] { decoded = encode::decode_texture(texture, topology, encoder.reads()); });
    report.add("codec/round_trip_mean_" + name, 1000 * (decoded - offsets).rowwise().norm().mean(),
               "mm");
  }
}

}  // namespace pleat::bench
