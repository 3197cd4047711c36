#include "encode/uv_layout.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/error.h"
#include "encode/texture.h"
#include "tests/encode/synthetic.h"

namespace pleat::encode {
namespace {

Vec<2> uv_of_texel(int texel, int size) {
  return {(texel % size + 0.5) / size, 1 - (texel / size + 0.5) / size};
}

Vec<2> uv_at(const garment::GarmentTopology& topology, int face, const Vec<3>& barycentric) {
  Vec<2> uv = Vec<2>::Zero();
  for (int k = 0; k < 3; ++k)
    uv += barycentric[k] * topology.uv.row(topology.panel_faces(face, k)).transpose();
  return uv;
}

TEST(UvLayout, InsideTexelsLieInTheirFaceAtTheirBarycentric) {
  const garment::GarmentTopology topology = make_tube(20, 40).topology;
  const UvLayout layout = make_uv_layout(topology, 128);
  int inside = 0;
  for (int texel = 0; texel < layout.face.size(); ++texel) {
    if (layout.mask[static_cast<size_t>(texel)] != kInside) continue;
    ++inside;
    const Vec<3> barycentric = layout.barycentric.row(texel).transpose();
    EXPECT_GE(barycentric.minCoeff(), -1e-8);
    EXPECT_LT((uv_at(topology, layout.face[texel], barycentric) - uv_of_texel(texel, 128)).norm(),
              1e-12);
  }
  double area = 0;  // of the panels in UV
  for (int f = 0; f < topology.panel_faces.rows(); ++f) {
    const Vec<2> a = topology.uv.row(topology.panel_faces(f, 0)),
                 b = topology.uv.row(topology.panel_faces(f, 1)),
                 c = topology.uv.row(topology.panel_faces(f, 2));
    area += 0.5 * std::abs((b - a).x() * (c - a).y() - (b - a).y() * (c - a).x());
  }
  // Texel centres counted against the area: the border, about 4 * 128 texels long, is decided to
  // within a texel at random.
  EXPECT_NEAR(inside, area * 128 * 128, 60);
}

TEST(UvLayout, RowZeroIsTheTop) {
  garment::GarmentTopology topology = sheet_topology(4, 4);
  topology.uv.col(1) = 0.7 + 0.25 * topology.uv.col(1).array();  // v in 0.7 .. 1
  const UvLayout layout = make_uv_layout(topology, 64);
  const auto first =
      std::find(layout.mask.begin(), layout.mask.end(), kInside) - layout.mask.begin();
  const auto last =
      layout.mask.rend() - std::find(layout.mask.rbegin(), layout.mask.rend(), kInside);
  EXPECT_LT(first / 64, 6);
  EXPECT_LT(last / 64, 20);
}

TEST(UvLayout, GuttersSurroundThePanels) {
  const int size = 128;
  const UvLayout layout = make_uv_layout(make_tube(20, 40).topology, size);
  for (int texel = 0; texel < layout.face.size(); ++texel) {
    double nearest = 1e9;  // distance to an inside texel
    for (int r = -7; r <= 7; ++r) {
      for (int c = -7; c <= 7; ++c) {
        const int row = texel / size + r, column = texel % size + c;
        if (row < 0 || row >= size || column < 0 || column >= size) continue;
        if (layout.mask[static_cast<size_t>(row * size + column)] == kInside)
          nearest = std::min(nearest, std::hypot(r, c));
      }
    }
    const uint8_t coverage = layout.mask[static_cast<size_t>(texel)];
    if (nearest <= kGutterTexels - 1 && nearest > 0) {
      EXPECT_EQ(coverage, kGutter) << texel;
    }
    // Two more, since a sharp corner may hold no texel's centre.
    if (nearest > kGutterTexels + 2) {
      EXPECT_EQ(coverage, kEmpty) << texel;
    }
    EXPECT_EQ(coverage == kEmpty, layout.face[texel] < 0);
  }
}

TEST(UvLayout, NoReadTouchesAnEmptyTexel) {
  for (const int size : {64, 128, 256, 512}) {
    const garment::GarmentTopology topology = make_tube(24, 48).topology;
    const UvLayout layout = make_uv_layout(topology, size);
    const std::vector<uint8_t> all_filled(layout.mask.size(), kInside);
    const TexelReads reads = bilinear_reads(topology.uv, size, all_filled);
    for (Eigen::Index i = 0; i < reads.texels.rows(); ++i) {
      for (int k = 0; k < 4; ++k) {
        if (reads.weights(i, k) > 0) {
          EXPECT_NE(layout.mask[static_cast<size_t>(reads.texels(i, k))], kEmpty) << size;
        }
      }
    }
  }
}

TEST(UvLayout, NothingBleedsBetweenThePanelsOfTheGarment) {
  const garment::GarmentTopology topology = garment::make_topology(2500);
  for (const int size : {64, 128, 256}) {
    const UvLayout layout = make_uv_layout(topology, size);
    const std::vector<uint8_t> all_filled(layout.mask.size(), kInside);
    const TexelReads reads = bilinear_reads(topology.uv, size, all_filled);
    for (Eigen::Index i = 0; i < reads.texels.rows(); ++i) {
      for (int k = 0; k < 4; ++k) {
        if (reads.weights(i, k) == 0) continue;
        const int face = layout.face[reads.texels(i, k)];
        ASSERT_GE(face, 0) << "vertex " << i << " reads an empty texel at size " << size;
        const int corner = topology.panel_faces(face, 0);
        EXPECT_EQ(topology.panel_of_vertex[static_cast<size_t>(corner)],
                  topology.panel_of_vertex[static_cast<size_t>(i)])
            << "vertex " << i << " at size " << size;
      }
    }
  }
}

TEST(UvLayout, RefusesSizesOutOfRange) {
  EXPECT_THROW(make_uv_layout(make_tube(4, 4).topology, 8), InputError);
  EXPECT_THROW(make_uv_layout(make_tube(4, 4).topology, 5000), InputError);
}

}  // namespace
}  // namespace pleat::encode
