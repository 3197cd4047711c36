// Closest points and overlaps against a surface of a body's size: 14k triangles, 5k queries.
#include <cmath>

#include "core/mesh_quality.h"
#include "core/proximity.h"
#include "core/random.h"
#include "tests/benchmarks/bench.h"

namespace pleat::bench {
namespace {

struct Surface {
  Points3 vertices;
  Faces faces;
};

// Globe of 84 x 85 points (14112 triangles), 0.4 m across, dented as a body is.
Surface make_surface(double phase) {
  constexpr int kRound = 84, kDown = 85;
  Surface surface;
  surface.vertices.resize(kRound * kDown, 3);
  for (int v = 0; v < surface.vertices.rows(); ++v) {
    const double longitude = 2 * M_PI * (v % kRound) / kRound;
    const double latitude = M_PI * (v / kRound + 0.5) / kDown;
    const double radius =
        0.2 * (1 + 0.2 * std::sin(5 * longitude + phase) * std::sin(3 * latitude));
    surface.vertices.row(v) << radius * std::sin(latitude) * std::cos(longitude),
        radius * std::sin(latitude) * std::sin(longitude), radius * std::cos(latitude);
  }
  surface.faces.resize(2 * kRound * (kDown - 1), 3);
  for (int f = 0; f < surface.faces.rows(); f += 2) {
    const int a = f / 2, b = a % kRound + 1 == kRound ? a + 1 - kRound : a + 1;
    surface.faces.row(f) << a, a + kRound, b + kRound;
    surface.faces.row(f + 1) << a, b + kRound, b;
  }
  return surface;
}

}  // namespace

void bench_core(Report& report) {
  const Surface surface = make_surface(0), moved = make_surface(0.1);
  SurfaceTree tree(surface.vertices, surface.faces);
  report.time("core/tree_build_14k", 20, [&] { SurfaceTree(surface.vertices, surface.faces); });
  report.time("core/tree_refit_14k", 50, [&] { tree.refit(surface.vertices); });

  RandomStream random(1, "bench/core");
  Points3 queries(5000, 3);
  for (int q = 0; q < queries.rows(); ++q) {
    const int v = static_cast<int>(random.below(surface.vertices.rows()));
    queries.row(q) = surface.vertices.row(v) * (1 + 0.1 * random.uniform());  // up to 20 mm off
  }
  double sum = 0;
  for (const double band : {0.005, 0.02}) {
    const std::string name =
        "core/closest_5k_in_" + std::to_string(static_cast<int>(1000 * band)) + "mm";
    report.time(name, 50, [&] {
      for (int q = 0; q < queries.rows(); ++q) {
        sum += tree.closest(queries.row(q).transpose(), band).squared_distance;
      }
    });
  }
  report.time("core/signed_distances_5k", 20,
              [&] { sum += signed_distances(tree, queries, 0.02).sum(); });
  report.time("core/winding_numbers_500", 5,
              [&] { sum += winding_numbers(tree, queries.topRows(500)).sum(); });
  const SurfaceTree other(moved.vertices, moved.faces);
  size_t pairs = 0;
  report.time("core/intersecting_faces_14k_14k", 10,
              [&] { pairs = intersecting_faces(tree, other).size(); });
  report.add("core/intersecting_faces_found", static_cast<double>(pairs), "pairs");
  report.time("core/self_intersecting_faces_14k", 10,
              [&] { sum += static_cast<double>(self_intersecting_faces(tree).size()); });
  if (!std::isfinite(sum)) report.add("core/not_finite", sum, "");  // and keeps the work alive
}

}  // namespace pleat::bench
