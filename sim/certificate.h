// What may be trusted about one drape, and whether it is accepted.
#pragma once

#include "garment/clip.h"
#include "garment/template.h"
#include "sim/body_contact.h"
#include "sim/solver/newton.h"

namespace pleat::sim {

struct AcceptConfig {          // section `accept`
  double residual = 2e-3;      // |force imbalance| / |weight|
  double min_gap_m = 0;        // of every vertex, outside the parts where the body overlaps itself
  double strain_95 = 0.15;     // 95th percentile over faces
  int body_intersections = 0;  // cloth faces crossing the body, same exception
};
void validate(const AcceptConfig& config);

// iterations and seconds are the caller's to fill in.
garment::Certificate certify(const Eigen::Ref<const Points3>& positions, const Faces& faces,
                             const Faces& panel_faces, const Eigen::Ref<const Points2>& panels,
                             const BodyCollider& collider, const NewtonResult& solved,
                             const AcceptConfig& accept);

}  // namespace pleat::sim
