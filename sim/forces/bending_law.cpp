#include "sim/forces/bending_law.h"

#include <algorithm>

namespace pleat::sim {
namespace {

constexpr double kSpacing = 10;  // 1/m, between the table's curvatures
// The table's numbers go with Bridson's force, whose hinge is four times as soft as a plate's.
constexpr double kPlate = 0.25;

// Slope of a curve that does not overshoot, between two pieces with these slopes.
double smooth_slope(double before, double after) {
  return before > 0 && after > 0 ? 2 * before * after / (before + after) : 0;
}

// Monotone cubic pieces (Fritsch and Carlson 1980) through (10 i, M_i).
std::array<Vec<5>, BendingLaw::kPieces> make_curve(const std::array<double, 5>& table) {
  constexpr double h = kSpacing;
  std::array<double, 5> moment, slope;
  std::array<double, 4> rise;
  moment[0] = 0;
  for (int i = 1; i < 5; ++i) {
    moment[i] = std::max(moment[i - 1], kPlate * table[i] * h * i);
    rise[i - 1] = (moment[i] - moment[i - 1]) / h;
  }
  const double last = kPlate * table[4];
  slope[0] = std::min(kPlate * table[0], 3 * rise[0]);
  for (int i = 1; i < 4; ++i) slope[i] = smooth_slope(rise[i - 1], rise[i]);
  slope[4] = std::min(last, 3 * rise[3]);

  std::array<Vec<5>, BendingLaw::kPieces> curve;
  double energy = 0;
  for (int i = 0; i < 4; ++i) {
    const double q = (3 * rise[i] - 2 * slope[i] - slope[i + 1]) / h;
    const double r = (slope[i] + slope[i + 1] - 2 * rise[i]) / (h * h);
    curve[i] << energy, moment[i], slope[i], q, r;
    energy += h * (moment[i] + h * (slope[i] / 2 + h * (q / 3 + h * r / 4)));
  }
  curve[4] << energy, moment[4], last, 0, 0;
  return curve;
}

}  // namespace

BendingLaw make_bending_law(const garment::Fabric& fabric) {
  BendingLaw law;
  law.rigidity = fabric.bending_N_m;
  law.is_measured = fabric.tables.has_value();
  if (law.is_measured)
    for (int d = 0; d < 3; ++d) law.curves[d] = make_curve(fabric.tables->bending[d]);
  return law;
}

BendingResponse measured_bending(const BendingLaw& law, const Vec<3>& weights, double curvature) {
  const double steps = curvature / kSpacing;
  const int last = BendingLaw::kPieces - 1, piece = steps < last ? static_cast<int>(steps) : last;
  const Vec<5> k = weights[0] * law.curves[0][piece] + weights[1] * law.curves[1][piece] +
                   weights[2] * law.curves[2][piece];
  const double u = curvature - kSpacing * piece;
  const double w = k[0] + u * (k[1] + u * (k[2] / 2 + u * (k[3] / 3 + u * k[4] / 4)));
  const double secant = k[2] + u * (k[3] + u * k[4]);  // from the piece's start
  const double moment = k[1] + u * secant;
  return {w, piece == 0 ? secant : moment / curvature, k[2] + u * (2 * k[3] + 3 * u * k[4])};
}

}  // namespace pleat::sim
