// The texels of one UV layout: which lie inside a panel, and which around it are filled so that
// reads never bleed.
#pragma once

#include <cstdint>
#include <vector>

#include "garment/template.h"

namespace pleat::encode {

enum Coverage : uint8_t { kEmpty = 0, kInside = 1, kGutter = 2 };

// Texels count row by row from the top: texel r * size + c has its centre at
// u = (c + 0.5) / size, v = 1 - (r + 0.5) / size.
struct UvLayout {
  int size = 0;               // R, texels a side
  std::vector<uint8_t> mask;  // R*R, a Coverage each
  Eigen::VectorXi face;       // R*R, panel face that the texel takes its value from, -1 where empty
  Points3 barycentric;        // R*R, on that face; negative where a gutter texel lies off it
};

// Gutters reach so far from the panels, in texels; a bilinear read looks at most sqrt(2) away.
constexpr double kGutterTexels = 4;

// size: 16 .. 4096.
UvLayout make_uv_layout(const garment::GarmentTopology& topology, int size);

}  // namespace pleat::encode
