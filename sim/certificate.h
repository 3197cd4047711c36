// What may be trusted about one drape, and whether it is accepted: in equilibrium, stable, outside
// of the body, without an intersection, not overstretched.
#pragma once

#include "garment/clip.h"
#include "garment/template.h"
#include "sim/body_contact.h"
#include "sim/solver/newton.h"

namespace pleat::sim {

struct AcceptConfig {       // section `accept`
  double residual = 1e-3;   // |force imbalance| / |weight|, at most
  double min_gap_m = 0;     // of every vertex, but where the body passes through itself; at least
  double strain_95 = 0.25;  // 95th percentile over faces, at most
};
void validate(const AcceptConfig& config);

// posed: the body as its pose has it; collider: as it gave way to itself (BodyOpener). iterations
// and seconds are the caller's to fill in.
garment::Certificate certify(const Eigen::Ref<const Points3>& positions, const Faces& faces,
                             const Faces& panel_faces, const Eigen::Ref<const Points2>& panels,
                             const SurfaceTree& posed, const BodyCollider& collider,
                             const NewtonResult& solved, const AcceptConfig& accept);

// Whether the drape is rejected for crossing the body or lying inside it.
bool is_in_body(const garment::Certificate& certificate, const AcceptConfig& accept);

}  // namespace pleat::sim
