#include "sim/solver/trust_region.h"

#include <algorithm>
#include <cmath>

namespace pleat::sim {

// p: the step, d: the direction, r: what is left of -gradient - H p, z = M^-1 r. pp, pd, dd are
// products in the norm of M, which needs no product with M (Conn, Gould and Toint 2000,
// "Trust-Region Methods", section 7.5.1).
TrustRegionStep trust_region_step(const NewtonSystem& system, const Eigen::VectorXd& gradient,
                                  double radius, const TrustRegionConfig& config,
                                  const Preconditioner& precondition) {
  constexpr double kFarther = 2;  // times as long may negative curvature make the step
  constexpr double kFlat = 1e-6;  // curvature over that of M below which a direction counts as flat
  TrustRegionStep result;
  result.step = Eigen::VectorXd::Zero(gradient.size());
  Eigen::VectorXd r = -gradient, z, Hd;
  precondition(r, z);
  Eigen::VectorXd d = z;
  double rz = r.dot(z);
  if (!(rz > 0)) return result;
  if (!(radius > 0)) radius = std::sqrt(rz);
  const double stop = config.tolerance * config.tolerance * rz;
  double pp = 0, pd = 0, dd = rz;
  while (true) {
    ++result.iterations;
    multiply(system, d, Hd);
    const double curvature = d.dot(Hd), alpha = rz / curvature;
    result.has_negative_curvature = !(curvature > kFlat * dd);
    if (result.has_negative_curvature && pp > 0 && !config.is_at_saddle)
      radius = std::min(radius, kFarther * std::sqrt(pp));
    const double next_pp = pp + 2 * alpha * pd + alpha * alpha * dd;
    if (result.has_negative_curvature || next_pp > radius * radius) {
      const double tau = (-pd + std::sqrt(pd * pd + dd * (radius * radius - pp))) / dd;
      result.legs.push_back({tau * d, pp, tau * pd, tau * tau * dd});
      result.step += result.legs.back().along;
      result.model += -tau * rz + 0.5 * tau * tau * curvature;
      result.at_radius = true;
      result.length = radius;
      return result;
    }
    result.legs.push_back({alpha * d, pp, alpha * pd, alpha * alpha * dd});
    result.step += result.legs.back().along;
    result.model -= 0.5 * alpha * rz;
    pp = next_pp;
    result.length = std::sqrt(pp);
    r -= alpha * Hd;
    precondition(r, z);
    const double next = r.dot(z), beta = next / rz;
    if (!(next > stop) || result.iterations >= config.max_iterations) return result;
    pd = beta * (pd + alpha * dd);
    dd = next + beta * beta * dd;
    d = z + beta * d;
    rz = next;
  }
}

Eigen::VectorXd TrustRegionStep::cut(double radius) const {
  Eigen::VectorXd point = Eigen::VectorXd::Zero(step.size());
  for (const Leg& leg : legs) {
    const double left = radius * radius - leg.from;
    if (2 * leg.slope + leg.square > left) {
      const double share =
          left / (leg.slope + std::sqrt(leg.slope * leg.slope + leg.square * std::max(0.0, left)));
      return point + std::clamp(share, 0.0, 1.0) * leg.along;
    }
    point += leg.along;
  }
  return point;
}

}  // namespace pleat::sim
