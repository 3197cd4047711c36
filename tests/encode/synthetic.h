// A garment small enough to reason about: two panels, sewn at their sides into a tube, with
// jittered vertices and curved sides, so that nothing lines up with the texels.
#pragma once

#include <cmath>

#include "core/random.h"
#include "garment/template.h"

namespace pleat::encode {

struct Tube {
  garment::GarmentTopology topology;
  Points2 at;  // of each panel vertex: height 0 .. 0.8 m, angle round the tube 0 .. 2 pi
};

// columns x rows quads a panel. The panels fill most of the UV square, side by side.
inline Tube make_tube(int columns, int rows) {
  Tube tube;
  garment::GarmentTopology& topology = tube.topology;
  const int per_panel = (columns + 1) * (rows + 1);
  topology.uv.resize(2 * per_panel, 2);
  tube.at.resize(2 * per_panel, 2);
  topology.sewn_vertex.resize(2 * per_panel);
  topology.panel_of_vertex.resize(static_cast<size_t>(2 * per_panel));
  topology.panel_faces.resize(4 * columns * rows, 3);
  RandomStream random(0, "tube");
  int face = 0;
  for (int panel = 0; panel < 2; ++panel) {
    for (int r = 0; r <= rows; ++r) {
      for (int c = 0; c <= columns; ++c) {
        const int v = panel * per_panel + r * (columns + 1) + c;
        const bool is_inner = c > 0 && c < columns && r > 0 && r < rows;
        const double x = (c + (is_inner ? 0.5 * (random.uniform() - 0.5) : 0)) / columns;
        const double y = (r + (is_inner ? 0.5 * (random.uniform() - 0.5) : 0)) / rows;
        const double width = 0.34 + 0.06 * std::cos(5 * y);
        topology.uv.row(v) << 0.25 + 0.5 * panel + (x - 0.5) * width,
            0.06 + 0.88 * y + 0.02 * std::sin(6 * x);
        tube.at.row(v) << 0.8 * y, M_PI * (x + panel);
        topology.panel_of_vertex[static_cast<size_t>(v)] =
            panel ? garment::Panel::kBack : garment::Panel::kFront;
        // Sewn: the front is 0 .. per_panel - 1; the back's left side is the front's right one and
        // the other way round.
        if (panel == 0) topology.sewn_vertex[v] = v;
        if (panel == 1 && c == 0) topology.sewn_vertex[v] = r * (columns + 1) + columns;
        if (panel == 1 && c == columns) topology.sewn_vertex[v] = r * (columns + 1);
        if (panel == 1 && c > 0 && c < columns) {
          topology.sewn_vertex[v] = per_panel + r * (columns - 1) + c - 1;
        }
      }
    }
    for (int r = 0; r < rows; ++r) {
      for (int c = 0; c < columns; ++c) {
        const int a = panel * per_panel + r * (columns + 1) + c, b = a + 1, d = a + columns + 1,
                  e = d + 1;
        topology.panel_faces.row(face++) << a, b, e;
        topology.panel_faces.row(face++) << a, e, d;
      }
    }
  }
  topology.faces = topology.panel_faces.unaryExpr([&](int v) { return topology.sewn_vertex[v]; });
  topology.vertex_count = per_panel + (rows + 1) * (columns - 1);
  return tube;
}

// The front panel alone, unsewn.
inline garment::GarmentTopology sheet_topology(int columns, int rows) {
  garment::GarmentTopology topology = make_tube(columns, rows).topology;
  const int per_panel = (columns + 1) * (rows + 1);
  topology.uv.conservativeResize(per_panel, 2);
  topology.sewn_vertex = Eigen::VectorXi::LinSpaced(per_panel, 0, per_panel - 1);
  topology.panel_of_vertex.resize(static_cast<size_t>(per_panel));
  topology.panel_faces.conservativeResize(2 * columns * rows, 3);
  topology.faces = topology.panel_faces;
  topology.vertex_count = per_panel;
  return topology;
}

// Smooth folds of this amplitude (m), so many round the tube, the same on both sides of a seam. Of
// the sewn vertices.
inline Points3 tube_wrinkles(const Tube& tube, double amplitude, int folds) {
  Points3 offsets(tube.topology.vertex_count, 3);
  for (int i = 0; i < tube.at.rows(); ++i) {
    const double height = tube.at(i, 0), angle = tube.at(i, 1);
    const double wave = std::sin(folds * angle + 8 * height) * std::cos(12 * height);
    offsets.row(tube.topology.sewn_vertex[i]) << amplitude * wave,
        0.3 * amplitude * std::sin(11 * height + angle),
        0.5 * amplitude * std::cos((folds - 1) * angle);
  }
  return offsets;
}

// A cylinder of radius 0.2 m round the y axis, of the sewn vertices.
inline Points3 tube_positions(const Tube& tube) {
  Points3 positions(tube.topology.vertex_count, 3);
  for (int i = 0; i < tube.at.rows(); ++i) {
    const double angle = tube.at(i, 1);
    positions.row(tube.topology.sewn_vertex[i]) << 0.2 * std::cos(angle), tube.at(i, 0),
        0.2 * std::sin(angle);
  }
  return positions;
}

}  // namespace pleat::encode
