#include "garment/template.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/mesh.h"
#include "core/random.h"
#include "garment/design_map.h"
#include "garment/panel_layout.h"
#include "tests/core/input_error.h"
#include "tests/garment/mirror.h"

namespace pleat::garment {
namespace {

double cross(const Eigen::RowVector2d& a, const Eigen::RowVector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// Twice the area over the sum of squared sides, 1 for an equilateral triangle, negative where it is
// turned over.
double quality(const Points2& points, const Faces& faces, Eigen::Index f) {
  const Eigen::RowVector2d a = points.row(faces(f, 0)), b = points.row(faces(f, 1)),
                           c = points.row(faces(f, 2));
  return 2 * std::sqrt(3.0) * cross(b - a, c - a) /
         ((b - a).squaredNorm() + (c - b).squaredNorm() + (a - c).squaredNorm());
}

double worst_quality(const Points2& points, const Faces& faces) {
  double worst = 1;
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    worst = std::min(worst, quality(points, faces, f));
  return worst;
}

TEST(Template, HasAboutAsManyVerticesAsAsked) {
  for (const int wanted : {1200, 2500, 5000, 10000, 20000})
    EXPECT_NEAR(make_topology(wanted).vertex_count, wanted, 0.05 * wanted);
  EXPECT_INPUT_ERROR(make_topology(10), "vertex_count = 10");
}

TEST(Template, IsASurfaceWithFourOpenings) {
  for (const int wanted : {1200, 5000}) {
    const GarmentTopology t = make_topology(wanted);
    const Topology sewn = topology(t.faces, t.vertex_count);
    EXPECT_EQ(sewn.nonmanifold_edges, 0);
    EXPECT_EQ(sewn.misoriented_edges, 0);
    EXPECT_EQ(sewn.components, 1);
    EXPECT_EQ(sewn.euler_characteristic, 2 - 4);  // neck, hem, two sleeves
    // Their loops: each boundary vertex has two boundary edges.
    std::map<int, int> degree;
    for (const Edge& edge : edges(t.faces))
      if (edge.faces[1] < 0)
        for (const int v : edge.vertices) ++degree[v];
    for (const auto& [vertex, count] : degree) EXPECT_EQ(count, 2) << vertex;

    const Topology cut = topology(t.panel_faces, static_cast<int>(t.uv.rows()));
    EXPECT_EQ(cut.components, 4);
    EXPECT_EQ(cut.euler_characteristic, 4);
    std::set<int> used(t.sewn_vertex.begin(), t.sewn_vertex.end());
    EXPECT_EQ(static_cast<int>(used.size()), t.vertex_count);
    EXPECT_EQ(*used.rbegin(), t.vertex_count - 1);
  }
}

TEST(Template, NoTriangleIsLockedOnTheOutline) {
  const GarmentTopology t = make_topology(1200);
  std::set<int> outline;
  for (const Edge& edge : edges(t.panel_faces))
    if (edge.faces[1] < 0) outline.insert(edge.vertices.begin(), edge.vertices.end());
  for (Eigen::Index f = 0; f < t.panel_faces.rows(); ++f) {
    int on_outline = 0;
    for (int k = 0; k < 3; ++k) on_outline += static_cast<int>(outline.count(t.panel_faces(f, k)));
    EXPECT_LT(on_outline, 3) << "face " << f;
  }
}

TEST(Template, TrianglesAreSoundForEveryDesign) {
  const GarmentTopology t = make_topology(500);
  EXPECT_GT(worst_quality(cut_panels(t, reference_design()), t.panel_faces), 0.5);
  // The strip of a sleeveless design holds a sleeve's triangles, pressed flat: the lowest of all.
  for (const Design& design : paper_grid())
    EXPECT_GT(worst_quality(cut_panels(t, design), t.panel_faces), 0.12) << design.name;
  RandomStream random(1, "designs");
  const GarmentTopology fine = make_topology(2500);
  for (int i = 0; i < 8; ++i) {
    const Design design{"", random.uniform(), random.uniform(), random.uniform(), false};
    EXPECT_GT(worst_quality(cut_panels(fine, design), fine.panel_faces), 0.08)
        << design.length << " " << design.sleeve << " " << design.cleavage;
  }
}

TEST(Template, BothSidesOfASeamAreCutAlike) {
  const GarmentTopology t = make_topology(1200);
  for (const Design& design : {Design{"", 0, 0, 1, false}, Design{"", 1, 1, 0, false},
                               Design{"", 0.3, 0.25, 0.2, false}}) {
    const Points2 panels = cut_panels(t, design);
    std::map<std::array<int, 2>, std::vector<double>> sides;
    for (const Edge& edge : edges(t.panel_faces)) {
      if (edge.faces[1] >= 0) continue;
      const int a = t.sewn_vertex[edge.vertices[0]], b = t.sewn_vertex[edge.vertices[1]];
      sides[{std::min(a, b), std::max(a, b)}].push_back(
          (panels.row(edge.vertices[0]) - panels.row(edge.vertices[1])).norm());
    }
    int seam_edges = 0;
    for (const auto& [edge, lengths] : sides) {
      ASSERT_LE(lengths.size(), 2u);
      if (lengths.size() < 2) continue;
      ++seam_edges;
      EXPECT_NEAR(lengths[0] / lengths[1], 1, 0.03);
    }
    EXPECT_GT(seam_edges, 60);
  }
}

TEST(Template, IsMirrorSymmetric) {
  const GarmentTopology t = make_topology(2500);
  const std::vector<int> mirrored = mirrored_panel_vertices(t);
  std::set<std::array<int, 3>> faces;
  const auto sorted = [](int a, int b, int c) {
    std::array<int, 3> face = {a, b, c};
    std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
    return face;
  };
  for (Eigen::Index f = 0; f < t.panel_faces.rows(); ++f)
    faces.insert(sorted(t.panel_faces(f, 0), t.panel_faces(f, 1), t.panel_faces(f, 2)));
  for (Eigen::Index f = 0; f < t.panel_faces.rows(); ++f)
    EXPECT_TRUE(faces.count(sorted(mirrored[t.panel_faces(f, 0)], mirrored[t.panel_faces(f, 2)],
                                   mirrored[t.panel_faces(f, 1)])));
  std::map<int, int> sewn_mirror;
  for (Eigen::Index v = 0; v < t.uv.rows(); ++v) {
    const auto [place, is_new] = sewn_mirror.emplace(t.sewn_vertex[v], t.sewn_vertex[mirrored[v]]);
    EXPECT_TRUE(is_new || place->second == t.sewn_vertex[mirrored[v]]);
  }
  const Points2 panels = cut_panels(t, Design{"", 0.8, 0.1, 0.9, false});
  for (Eigen::Index v = 0; v < panels.rows(); ++v) {
    EXPECT_NEAR(panels(v, 0), -panels(mirrored[v], 0), 1e-9);
    EXPECT_NEAR(panels(v, 1), panels(mirrored[v], 1), 1e-9);
  }
}

// Island of each texel of a 128 x 128 image by its centre, -1 where there is none.
std::vector<int> rasterise(const GarmentTopology& t, int size, int& overlaps) {
  std::vector<int> island(static_cast<size_t>(size * size), -1);
  for (Eigen::Index f = 0; f < t.panel_faces.rows(); ++f) {
    const Eigen::RowVector2d a = t.uv.row(t.panel_faces(f, 0)) * size,
                             b = t.uv.row(t.panel_faces(f, 1)) * size,
                             c = t.uv.row(t.panel_faces(f, 2)) * size;
    const Eigen::RowVector2d low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
    for (int i = static_cast<int>(low.x()); i <= high.x(); ++i)
      for (int j = static_cast<int>(low.y()); j <= high.y(); ++j) {
        const Eigen::RowVector2d p(i + 0.5, j + 0.5);
        if (cross(b - a, p - a) <= 0 || cross(c - b, p - b) <= 0 || cross(a - c, p - c) <= 0)
          continue;
        int& texel = island[static_cast<size_t>(j * size + i)];
        overlaps += texel >= 0;
        texel = static_cast<int>(t.panel_of_vertex[t.panel_faces(f, 0)]);
      }
  }
  return island;
}

TEST(Layout, IslandsAreApartAndFillTheSquare) {
  constexpr int kSize = 128;
  const GarmentTopology t = make_topology(5000);
  int overlaps = 0;
  const std::vector<int> island = rasterise(t, kSize, overlaps);
  EXPECT_EQ(overlaps, 0);
  EXPECT_GT(worst_quality(t.uv, t.panel_faces), 0.2);  // all the same way round
  const auto filled = std::count_if(island.begin(), island.end(), [](int i) { return i >= 0; });
  EXPECT_GT(static_cast<double>(filled) / (kSize * kSize), 0.55);
  EXPECT_GT(t.uv.minCoeff(), 2.0 / kSize);
  EXPECT_LT(t.uv.maxCoeff(), 1 - 2.0 / kSize);
  double nearest = 1;
  for (Eigen::Index a = 0; a < t.uv.rows(); ++a)
    for (Eigen::Index b = 0; b < a; ++b)
      if (t.panel_of_vertex[a] != t.panel_of_vertex[b])
        nearest = std::min(nearest, (t.uv.row(a) - t.uv.row(b)).norm());
  EXPECT_GT(nearest, 3.0 / kSize);
}

TEST(Layout, TessellationsShareIt) {
  // Interior vertices of a coarse garment, found in the fine one by their UV, are the same place of
  // the cloth.
  const GarmentTopology coarse = make_topology(1200), fine = make_topology(20000);
  const Design design{"", 0.9, 0.7, 0.9, false};
  const Points2 coarse_panels = cut_panels(coarse, design), fine_panels = cut_panels(fine, design);
  int found = 0;
  for (Eigen::Index v = 0; v < coarse.uv.rows(); v += 7) {
    const Eigen::RowVector2d p = coarse.uv.row(v);
    for (Eigen::Index f = 0; f < fine.panel_faces.rows(); ++f) {
      const Eigen::RowVector2d a = fine.uv.row(fine.panel_faces(f, 0)),
                               b = fine.uv.row(fine.panel_faces(f, 1)),
                               c = fine.uv.row(fine.panel_faces(f, 2));
      const double area = cross(b - a, c - a), wa = cross(b - p, c - p) / area,
                   wb = cross(c - p, a - p) / area;
      if (wa < 0 || wb < 0 || wa + wb > 1) continue;
      ++found;
      EXPECT_EQ(coarse.panel_of_vertex[v], fine.panel_of_vertex[fine.panel_faces(f, 0)]);
      const Eigen::RowVector2d there = wa * fine_panels.row(fine.panel_faces(f, 0)) +
                                       wb * fine_panels.row(fine.panel_faces(f, 1)) +
                                       (1 - wa - wb) * fine_panels.row(fine.panel_faces(f, 2));
      EXPECT_LT((there - coarse_panels.row(v)).norm(),
                0.0005);  // bending of the map within a fine triangle
      break;
    }
  }
  EXPECT_GT(found, 120);
}

TEST(DesignMap, IsTheIdentityOnTheReference) {
  const GarmentTopology t = make_topology(1200);
  const Points2 panels = cut_panels(t, reference_design());
  for (Eigen::Index v = 0; v < panels.rows(); ++v)
    EXPECT_LT((panels.row(v) - uv_to_reference(t.panel_of_vertex[v], t.uv.row(v))).norm(), 1e-9);
}

TEST(DesignMap, TakesTheOutlineToTheOutlineEvenInSinglePrecision) {
  const Design design{"", 0.1, 0.9, 1, false};
  for (const Panel panel : kPanels) {
    const Points2 uv =
        reference_to_uv(panel, outline(panel, reference_design())).cast<float>().cast<double>();
    const Points2 mapped = map_to_design(panel, uv_to_reference(panel, uv), design);
    EXPECT_LT((mapped - outline(panel, design)).rowwise().norm().maxCoeff(), 2e-5);
  }
}

}  // namespace
}  // namespace pleat::garment
