// A step that lowers the quadratic model of the energy as far as conjugate gradients and a radius
// allow: Steihaug 1983, "The Conjugate Gradient Method and Trust Regions in Large Scale
// Optimization". Where the model curves downwards the step goes on no farther than it came: how far
// the model holds there nobody knows, and mostly it is not far. Only the first direction, and any
// at a saddle, is followed to the radius.
#pragma once

#include <functional>
#include <vector>

#include "sim/solver/newton_system.h"

namespace pleat::sim {

// Solves M z = r for the positive definite M in whose norm the radius is measured.
using Preconditioner = std::function<void(const Eigen::VectorXd& r, Eigen::VectorXd& z)>;

struct TrustRegionConfig {
  double tolerance = 0.1;  // stop at this share of the residual, in the norm of M^-1
  int max_iterations = 60;
  bool is_at_saddle = false;
};

struct TrustRegionStep {
  // The way to the step, along which the length grows and the model falls.
  struct Leg {
    Eigen::VectorXd along;
    double from, slope, square;  // squared length after a share t: from + t (2 slope + t square)
  };
  std::vector<Leg> legs;
  // What the step would be with a shorter radius.
  Eigen::VectorXd cut(double radius) const;

  Eigen::VectorXd step;
  double length = 0;  // in the norm of M
  double model = 0;   // change of energy that the model foretells, J, <= 0
  bool at_radius = false;
  bool has_negative_curvature = false;
  int iterations = 0;
};

// radius <= 0: that of the first preconditioned gradient.
TrustRegionStep trust_region_step(const NewtonSystem& system, const Eigen::VectorXd& gradient,
                                  double radius, const TrustRegionConfig& config,
                                  const Preconditioner& precondition);

}  // namespace pleat::sim
