// Cloth vertices near the body, with the distances kept between iterations so that far vertices are
// not asked again.
#pragma once

#include <vector>

#include "sim/body_contact.h"
#include "sim/solver/assemble.h"

namespace pleat::sim {

struct ContactConfig {              // section `contact`
  double distance_m = 0.004;        // gap at which the body begins to push
  double stiffness_N_per_m3 = 6e6;  // spring constant a unit of cloth area
  double slip_m = 0.0005;           // friction sticks like a spring up to this slip
  double search_depth_m =
      0.03;  // a vertex that got into the body this deep still finds its way out
};
void validate(const ContactConfig& config);

// The body point that a cloth vertex sticks to; face -1 where it touches nothing.
struct Anchor {
  int face = -1;
  Vec<3> barycentric = Vec<3>::Zero();
};

class ContactSearch {
 public:
  ContactSearch(const Cloth& cloth, const BodyCollider& collider, const ContactConfig& config,
                double friction, double reach_m);

  // Planes of the body for every vertex that touches it at x or may after a step of reach_m, with
  // friction towards the anchors. A vertex that touches without an anchor gets one where it
  // touches.
  Touching find(const Eigen::VectorXd& x, std::vector<Anchor>& anchors);

 private:
  struct Candidate {
    Contact contact;
    double weight;  // 0 .. 1
  };
  Candidate candidate(int vertex, const Vec<3>& position, const ClosestPoint& closest) const;
  std::vector<Contact> contacts_of(int vertex, const Vec<3>& position, const ClosestPoint& closest,
                                   const Anchor& anchor) const;
  bool is_outside(const Vec<3>& position, const ClosestPoint& closest) const;

  const Cloth& cloth_;
  const BodyCollider& collider_;
  ContactConfig config_;
  double friction_, reach_;
  Points3 asked_at_;  // where each vertex was when its distance was measured
  Eigen::VectorXd
      clearance_;  // distance to the body measured there, capped at search_depth_m; 0: not yet
  std::vector<std::vector<Contact>> contacts_;  // of each vertex, from when it was last asked
  int finds_ = 0;
};

// After a drape: anchors of vertices that slid follow to the slip limit behind them, those that
// left the body are dropped.
void settle_anchors(const BodyCollider& collider, const Touching& touching,
                    const Eigen::VectorXd& x, const ContactConfig& config,
                    std::vector<Anchor>& anchors);

}  // namespace pleat::sim
