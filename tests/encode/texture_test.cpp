#include "encode/texture.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/mesh.h"
#include "core/random.h"
#include "encode/error_summary.h"
#include "garment/resample.h"
#include "tests/encode/synthetic.h"

namespace pleat::encode {
namespace {

// Texels are floats: half a unit in the last place of a number below 1/16 m is 2e-9 m, and a read
// averages four.
constexpr double kFloat = 4e-9;  // m

Points3 round_trip(const TextureEncoder& encoder, const garment::GarmentTopology& topology,
                   const Points3& offsets) {
  return decode_texture(encoder.encode(offsets), topology, encoder.reads());
}

class BothFills : public testing::TestWithParam<Fill> {};
INSTANTIATE_TEST_SUITE_P(Texture, BothFills, testing::Values(Fill::kBarycentric, Fill::kFitted));

TEST_P(BothFills, ReturnConstantOffsetsExactly) {
  const garment::GarmentTopology topology = make_tube(20, 40).topology;
  const TextureEncoder encoder(topology, make_uv_layout(topology, 128), GetParam());
  Points3 offsets(topology.vertex_count, 3);
  offsets.rowwise() = Eigen::RowVector3d(0.03, -0.02, 0.05);
  EXPECT_LT((round_trip(encoder, topology, offsets) - offsets).cwiseAbs().maxCoeff(), kFloat);
}

TEST_P(BothFills, ReturnOffsetsAffineInUvExactly) {
  const garment::GarmentTopology topology =
      sheet_topology(10, 20);  // unsewn: a seam cannot be affine from both sides
  const TextureEncoder encoder(topology, make_uv_layout(topology, 128), GetParam());
  Eigen::Matrix<double, 2, 3> slope;
  slope << 0.03, -0.02, 0.01, 0.02, 0.04, -0.03;
  Points3 offsets = topology.uv * slope;
  offsets.rowwise() += Eigen::RowVector3d(0.001, 0.002, -0.003);
  EXPECT_LT((round_trip(encoder, topology, offsets) - offsets).cwiseAbs().maxCoeff(), kFloat);
}

TEST(Texture, FittedFillKeepsSmoothWrinkles) {
  for (const auto& [columns, rows] :
       {std::pair(24, 48), std::pair(36, 70)}) {  // 2352 and 5112 vertices
    const Tube tube = make_tube(columns, rows);
    const Points3 offsets = tube_wrinkles(tube, 0.01, 6);
    const TextureEncoder fitted(tube.topology, make_uv_layout(tube.topology, 128), Fill::kFitted);
    const TextureEncoder barycentric(tube.topology, make_uv_layout(tube.topology, 128),
                                     Fill::kBarycentric);
    const Eigen::VectorXd errors =
        vertex_distances_mm(round_trip(fitted, tube.topology, offsets), offsets);
    const Eigen::VectorXd of_paper =
        vertex_distances_mm(round_trip(barycentric, tube.topology, offsets), offsets);
    EXPECT_LT(errors.mean(), 0.1);
    EXPECT_LT(errors.maxCoeff(), 0.5);
    EXPECT_LT(of_paper.mean(), 1.0);
    EXPECT_LT(errors.mean(), 0.1 * of_paper.mean());
  }
}

TEST(Texture, FitDoesNotOvershoot) {
  const Tube tube = make_tube(24, 48);
  const Points3 offsets = tube_wrinkles(tube, 0.01, 6);
  const TextureEncoder encoder(tube.topology, make_uv_layout(tube.topology, 128), Fill::kFitted);
  const Texture texture = encoder.encode(offsets);
  float largest = 0;
  for (const float value : texture.values) largest = std::max(largest, std::abs(value));
  EXPECT_LT(static_cast<double>(largest), 1.6 * offsets.cwiseAbs().maxCoeff());
}

// At the vertices it is exact; between them it overshoots little against the barycentric fill,
// which is linear there.
TEST(Texture, FitKeepsWhatIsBetweenVertices) {
  const Tube tube = make_tube(36, 70);
  RandomStream random(5, "rough");
  Points3 offsets(tube.topology.vertex_count, 3);
  for (double& x : offsets.reshaped()) x = 0.003 * random.normal();
  const auto middles_mm = [&](Fill fill) {
    const TextureEncoder encoder(tube.topology, make_uv_layout(tube.topology, 128), fill);
    const std::vector<Edge> all = edges(tube.topology.panel_faces);
    Points2 uv(all.size(), 2);
    Points3 surface(all.size(), 3);
    for (size_t e = 0; e < all.size(); ++e) {
      const auto [a, b] = all[e].vertices;
      uv.row(e) = 0.5 * (tube.topology.uv.row(a) + tube.topology.uv.row(b));
      surface.row(e) = 0.5 * (offsets.row(tube.topology.sewn_vertex[a]) +
                              offsets.row(tube.topology.sewn_vertex[b]));
    }
    const TexelReads reads = bilinear_reads(uv, 128, encoder.layout().mask);
    return vertex_distances_mm(read_texture(encoder.encode(offsets), reads), surface).mean();
  };
  // 1.65 times as wrong, on noise; without regard to what is between it would be 1.98 times.
  EXPECT_LT(middles_mm(Fill::kFitted), 1.8 * middles_mm(Fill::kBarycentric));
}

TEST(Texture, BothSidesOfASeamAgree) {
  const Tube tube = make_tube(24, 48);
  const TextureEncoder encoder(tube.topology, make_uv_layout(tube.topology, 128), Fill::kFitted);
  const Points3 offsets = tube_wrinkles(tube, 0.01, 6);
  const Points3 sides = read_texture(encoder.encode(offsets), encoder.reads());
  std::vector<int> first(static_cast<size_t>(tube.topology.vertex_count), -1);
  int seams = 0;
  for (int i = 0; i < sides.rows(); ++i) {
    int& other = first[static_cast<size_t>(tube.topology.sewn_vertex[i])];
    if (other >= 0) {
      ++seams;
      EXPECT_LT((sides.row(i) - sides.row(other)).norm(), 1e-4);  // the fit's aim, as above
    }
    other = i;
  }
  EXPECT_EQ(seams, 2 * 49);
}

TEST(Texture, SewingAveragesThePanelVertices) {
  const garment::GarmentTopology topology = make_tube(4, 4).topology;
  Points3 values = Points3::Zero(topology.uv.rows(), 3);
  const int back = 25;  // first vertex of the back panel, sewn to the front's right side
  values.row(back) << 2, 4, 6;
  EXPECT_EQ(garment::sew(topology, values).row(topology.sewn_vertex[back]),
            Eigen::RowVector3d(1, 2, 3));
}

TEST_P(BothFills, DecodingIgnoresWhatIsOutsideTheMask) {
  const Tube tube = make_tube(24, 48);
  const TextureEncoder encoder(tube.topology, make_uv_layout(tube.topology, 128), GetParam());
  Texture texture = encoder.encode(tube_wrinkles(tube, 0.01, 6));
  const Points3 before = decode_texture(texture, tube.topology, encoder.reads());
  const std::vector<uint8_t>& mask = encoder.layout().mask;
  int outside = 0;
  for (size_t i = 0; i < mask.size(); ++i) {
    if (mask[i] != kEmpty) continue;
    ++outside;
    for (size_t c = 0; c < 3; ++c) {
      EXPECT_EQ(texture.values[c * mask.size() + i], 0.0f);
      texture.values[c * mask.size() + i] = 1000.0f;
    }
  }
  EXPECT_GT(outside, 1000);
  EXPECT_EQ(decode_texture(texture, tube.topology, encoder.reads()), before);
}

TEST(Texture, ReadsAnotherTessellationOfTheSameLayout) {
  const Tube coarse = make_tube(24, 48), fine = make_tube(48, 96);
  const TextureEncoder encoder(coarse.topology, make_uv_layout(coarse.topology, 128),
                               Fill::kFitted);
  const Texture texture = encoder.encode(tube_wrinkles(coarse, 0.01, 3));
  const TexelReads reads = bilinear_reads(fine.topology.uv, 128, encoder.layout().mask);
  const Points3 expected = tube_wrinkles(fine, 0.01, 3);
  // The coarse mesh is flat between its vertices: sagitta of a fold of 1 cm over an edge of 1/24 of
  // half the tube.
  EXPECT_LT(vertex_distances_mm(decode_texture(texture, fine.topology, reads), expected).mean(),
            0.3);
}

TEST(Texture, RefusesUvOutsideOfEveryPanel) {
  const garment::GarmentTopology topology = make_tube(10, 20).topology;
  const UvLayout layout = make_uv_layout(topology, 128);
  Points2 uv(1, 2);
  uv << 0.5, 0.01;
  EXPECT_THROW(bilinear_reads(uv, 128, layout.mask), InputError);
  uv << 0.25, 1.5;
  EXPECT_THROW(bilinear_reads(uv, 128, layout.mask), InputError);
}

TEST(Texture, RefusesAnUnknownFill) { EXPECT_THROW(parse_fill("nearest"), InputError); }

}  // namespace
}  // namespace pleat::encode
