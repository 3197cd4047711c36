#include "garment/panel_layout.h"

namespace pleat::garment {
namespace {

// At 128 x 128, in texels: islands stay 2.5 off the border and 4 apart.
constexpr double kBorder = 2.5 / 128, kGutter = 4.0 / 128;

// uv = scale * point + origin
struct Island {
  Eigen::Array2d scale, origin;
};

struct Box {
  double half_width, bottom, top;
};
Box box(Panel panel, const Design& design) {
  const Points2 half = half_outline(panel, design);
  return {half.col(0).maxCoeff(), half.col(1).minCoeff(), half.col(1).maxCoeff()};
}
double height(const Box& box) { return box.top - box.bottom; }

// Torso panels above, sleeves below, each in its half of the square. Rows share the height in
// proportion to the largest designs, so that a texel is as long on the longest sleeve as on the
// longest dress.
Island island(Panel panel) {
  const bool sleeve = is_sleeve(panel);
  const Design largest{"", 1, 1, 0, false};
  const double longest_torso = height(box(Panel::kBack, largest));
  const double longest_sleeve = height(box(Panel::kLeftSleeve, largest));
  const double column = (1 - 2 * kBorder - kGutter) / 2;
  const double rows = 1 - 2 * kBorder - kGutter;
  const double sleeve_row = rows * longest_sleeve / (longest_torso + longest_sleeve);
  const double row = sleeve ? sleeve_row : rows - sleeve_row;
  const double bottom = sleeve ? kBorder : kBorder + sleeve_row + kGutter;
  const bool on_right = panel == Panel::kBack || panel == Panel::kRightSleeve;
  // Front and back share the back's box, which is the higher one, so that the same place has the
  // same v.
  const Box reference = box(sleeve ? panel : Panel::kBack, reference_design());
  Island result;
  result.scale << column / (2 * reference.half_width), row / height(reference);
  result.origin << (on_right ? 1 - kBorder - column / 2 : kBorder + column / 2),
      bottom - result.scale.y() * reference.bottom;
  return result;
}

}  // namespace

Points2 reference_to_uv(Panel panel, const Eigen::Ref<const Points2>& reference) {
  const Island map = island(panel);
  return ((reference.array().rowwise() * map.scale.transpose()).rowwise() + map.origin.transpose())
      .matrix();
}

Points2 uv_to_reference(Panel panel, const Eigen::Ref<const Points2>& uv) {
  const Island map = island(panel);
  return ((uv.array().rowwise() - map.origin.transpose()).rowwise() / map.scale.transpose())
      .matrix();
}

}  // namespace pleat::garment
