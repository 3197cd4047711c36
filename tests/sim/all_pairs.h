// Pairs of features of cloth and body, one by one: the judge of every search.
#pragma once

#include <algorithm>
#include <array>
#include <set>
#include <tuple>
#include <vector>

#include "sim/solver/pair_distance.h"

namespace pleat::sim {

// A pair of features whatever the order in which its corners are named.
struct Feature {
  PairKind kind;
  std::array<int, 4> vertices;
  bool operator<(const Feature& other) const {
    return std::tie(kind, vertices) < std::tie(other.kind, other.vertices);
  }
};
inline Feature named(PairKind kind, std::array<int, 4> v) {
  if (kind == PairKind::kPointFace) {
    std::sort(v.begin() + 1, v.end());
  } else {
    std::sort(v.begin(), v.begin() + 2);
    std::sort(v.begin() + 2, v.end());
    if (v[0] > v[2]) v = {v[2], v[3], v[0], v[1]};
  }
  return {kind, v};
}

// action(kind, vertices) for each corner and face and each two edges that share no corner, cloth
// and cloth or cloth and body. The body's vertices follow the cloth's `count`.
template <typename Action>
void for_each_pair(const Faces& cloth, const Faces& body, int count, Action action) {
  std::vector<std::array<int, 3>> faces;
  std::set<std::array<int, 2>> edges;
  std::set<int> corners;
  for (const auto& [part, first] : {std::pair{&cloth, 0}, std::pair{&body, count}})
    for (Eigen::Index f = 0; f < part->rows(); ++f) {
      std::array<int, 3> face;
      for (int k = 0; k < 3; ++k) corners.insert(face[k] = first + (*part)(f, k));
      for (int k = 0; k < 3; ++k) {
        const auto [low, high] = std::minmax(face[k], face[(k + 1) % 3]);
        edges.insert({low, high});
      }
      faces.push_back(face);
    }
  for (const int v : corners)
    for (const auto& f : faces)
      if ((v < count || f[0] < count) && v != f[0] && v != f[1] && v != f[2])
        action(PairKind::kPointFace, std::array<int, 4>{v, f[0], f[1], f[2]});
  for (const auto& a : edges) {
    if (a[0] >= count) continue;
    for (const auto& b : edges)
      if (a < b && a[0] != b[0] && a[0] != b[1] && a[1] != b[0] && a[1] != b[1])
        action(PairKind::kEdgeEdge, std::array<int, 4>{a[0], a[1], b[0], b[1]});
  }
}

}  // namespace pleat::sim
