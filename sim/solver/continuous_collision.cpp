#include "sim/solver/continuous_collision.h"

#include <algorithm>
#include <cmath>

namespace pleat::sim {

double free_motion(PairKind kind, const PairPoints& x, const PairPoints& motion, double keep) {
  // What both features do together does not bring them closer.
  const PairPoints relative = motion.colwise() - motion.rowwise().mean();
  const auto speed = [&](int corner) { return relative.col(corner).norm(); };
  const double closing =
      kind == PairKind::kPointFace
          ? speed(0) + std::max({speed(1), speed(2), speed(3)})
          : std::max(speed(0), speed(1)) + std::max(speed(2), speed(3));
  double distance = std::sqrt(squared_pair_distance(kind, x));
  const double least = keep * distance;
  if (closing <= distance - least) return 1;
  // Each advance leaves a tenth of the way to `least`, so that it is never passed by rounding.
  constexpr double kShare = 0.9;
  constexpr int kMostAdvances = 100;
  double t = 0;
  for (int i = 0; i < kMostAdvances; ++i) {
    const double advance = kShare * (distance - least) / closing;
    if (t + advance >= 1) return 1;
    distance = std::sqrt(squared_pair_distance(kind, x + (t + advance) * relative));
    if (distance <= least) return t;
    t += advance;
    if (advance < 1e-4 * t) return t;  // grazing: hardly any way is left
  }
  return t;
}

}  // namespace pleat::sim
