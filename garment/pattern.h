// The sewing pattern: outlines of the four flat panels of one design, and which of their curves are
// sewn together.
//
// Each panel lies in its own plane, seen from the cloth's outside, mirror-symmetric about x = 0, y
// up the body (on a sleeve: up the arm). On the torso the origin is at the level of the
// shoulder-neck point, on a sleeve at the level of the underarm.
#pragma once

#include <array>
#include <vector>

#include "core/types.h"
#include "garment/design.h"

namespace pleat::garment {

enum class Panel { kFront, kBack, kLeftSleeve, kRightSleeve };
constexpr std::array<Panel, 4> kPanels = {Panel::kFront, Panel::kBack, Panel::kLeftSleeve,
                                          Panel::kRightSleeve};
inline bool is_sleeve(Panel panel) {
  return panel == Panel::kLeftSleeve || panel == Panel::kRightSleeve;
}
// Sign of x on the wearer's front, of a sleeve: +1 or -1.
inline int front_side(Panel sleeve) { return sleeve == Panel::kLeftSleeve ? -1 : 1; }
// Panel x points to the wearer's left (+1, world +x) or right (-1), of a torso panel.
inline int left_side(Panel torso) { return torso == Panel::kFront ? 1 : -1; }

// The curves of half an outline (x >= 0) in counter-clockwise order.
enum class Curve { kHem, kSide, kArmhole, kShoulder, kNeckline };
// Torso: all five. Sleeve: hem, side (its underarm seam) and armhole (its cap).
std::vector<Curve> curves_of(Panel panel);

// Each curve is a polyline of this many segments, equal in length along the curve.
constexpr int kCurveSegments = 32;

// The half with x >= 0, from the middle of the hem to the middle of the neckline or cap, m:
// curve k holds rows k * kCurveSegments .. (k + 1) * kCurveSegments.
Points2 half_outline(Panel panel, const Design& design);
// The whole panel, closed and counter-clockwise, starting in the middle of the hem.
Points2 outline(Panel panel, const Design& design);

// A design between the extremes: its panels are what is triangulated and laid out in UV.
Design reference_design();

}  // namespace pleat::garment
