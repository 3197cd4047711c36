#include "body/fill_holes.h"

#include <functional>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "core/error.h"

namespace pleat::body {

std::vector<std::vector<int>> boundary_loops(const Faces& faces) {
  std::set<std::pair<int, int>> directed;
  for (int f = 0; f < faces.rows(); ++f) {
    for (int c = 0; c < 3; ++c) directed.emplace(faces(f, c), faces(f, (c + 1) % 3));
  }
  std::map<int, int> next;
  for (const auto& [from, to] : directed) {
    if (directed.count({to, from})) continue;
    if (!next.emplace(to, from).second) {
      throw InputError("the surface has openings that meet in vertex " + std::to_string(to));
    }
  }
  std::vector<std::vector<int>> loops;
  while (!next.empty()) {
    std::vector<int> loop;
    auto it = next.begin();
    while (it != next.end()) {
      loop.push_back(it->first);
      const int following = it->second;
      next.erase(it);
      it = next.find(following);
    }
    loops.push_back(loop);
  }
  return loops;
}

Faces fill_hole(const Eigen::Ref<const Points3>& vertices, const Faces& faces,
                const std::vector<int>& loop) {
  const int n = static_cast<int>(loop.size());
  const std::set<int> on_loop(loop.begin(), loop.end());
  std::set<std::pair<int, int>> taken;  // edges of the surface between vertices of the loop
  for (int f = 0; f < faces.rows(); ++f) {
    for (int c = 0; c < 3; ++c) {
      const int a = faces(f, c), b = faces(f, (c + 1) % 3);
      if (on_loop.count(a) && on_loop.count(b)) taken.emplace(std::minmax(a, b));
    }
  }
  const double impossible = std::numeric_limits<double>::infinity();
  const auto length = [&](int i, int j) {
    if (j == i + 1 || (i == 0 && j == n - 1)) return 0.0;  // on the loop itself
    if (taken.count(std::minmax(loop[i], loop[j]))) return impossible;
    return (vertices.row(loop[i]) - vertices.row(loop[j])).norm();
  };
  // best(i, j): least length within the polygon loop[i..j], its closing edge included.
  Eigen::MatrixXd best = Eigen::MatrixXd::Zero(n, n);
  Eigen::MatrixXi apex = Eigen::MatrixXi::Constant(n, n, -1);
  for (int span = 2; span < n; ++span) {
    for (int i = 0; i + span < n; ++i) {
      const int j = i + span;
      double least = impossible;
      for (int k = i + 1; k < j; ++k) {
        const double candidate = best(i, k) + best(k, j);
        if (candidate < least) least = candidate, apex(i, j) = k;
      }
      best(i, j) = least + length(i, j);
    }
  }
  if (n < 3 || !(best(0, n - 1) < impossible)) {
    throw InputError("an opening of " + std::to_string(n) + " vertices at vertex " +
                     std::to_string(loop.front()) + " cannot be closed");
  }
  Faces filling(n - 2, 3);
  int count = 0;
  const std::function<void(int, int)> collect = [&](int i, int j) {
    if (j < i + 2) return;
    const int k = apex(i, j);
    filling.row(count++) << loop[i], loop[k], loop[j];
    collect(i, k);
    collect(k, j);
  };
  collect(0, n - 1);
  return filling;
}

Faces joined(const Faces& a, const Faces& b) {
  Faces all(a.rows() + b.rows(), 3);
  all << a, b;
  return all;
}

}  // namespace pleat::body
