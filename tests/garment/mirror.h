// The mirror image of each panel vertex in the middle plane of the body, found by position.
#pragma once

#include <cmath>
#include <map>
#include <stdexcept>
#include <tuple>
#include <vector>

#include "garment/panel_layout.h"
#include "garment/template.h"

namespace pleat::garment {

inline Panel across(Panel panel) {
  if (panel == Panel::kLeftSleeve) return Panel::kRightSleeve;
  if (panel == Panel::kRightSleeve) return Panel::kLeftSleeve;
  return panel;
}

inline std::vector<int> mirrored_panel_vertices(const GarmentTopology& topology) {
  const auto key = [](Panel panel, double x, double y) {
    return std::make_tuple(panel, std::llround(x * 1e7), std::llround(y * 1e7));
  };
  std::map<std::tuple<Panel, long long, long long>, int> at;
  std::vector<Eigen::RowVector2d> reference;
  for (Eigen::Index v = 0; v < topology.uv.rows(); ++v) {
    const Panel panel = topology.panel_of_vertex[v];
    reference.emplace_back(uv_to_reference(panel, topology.uv.row(v)));
    at[key(panel, reference.back().x(), reference.back().y())] = static_cast<int>(v);
  }
  std::vector<int> mirrored;
  for (Eigen::Index v = 0; v < topology.uv.rows(); ++v) {
    const Panel panel = across(topology.panel_of_vertex[v]);
    int found = -1;
    for (int dx = -1; dx <= 1; ++dx)  // the last digit may round either way
      for (int dy = -1; dy <= 1; ++dy) {
        auto [p, x, y] = key(panel, -reference[v].x(), reference[v].y());
        const auto place = at.find({p, x + dx, y + dy});
        if (place != at.end()) found = place->second;
      }
    if (found < 0) throw std::runtime_error("a panel vertex has no mirror image");
    mirrored.push_back(found);
  }
  return mirrored;
}

}  // namespace pleat::garment
