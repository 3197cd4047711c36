// A garment through a motion: dress in the T-pose, ease into shape and first pose, then a static
// drape every frame.
#pragma once

#include <functional>

#include "body/motion.h"
#include "garment/clip.h"
#include "garment/fabric.h"
#include "garment/template.h"
#include "sim/certificate.h"
#include "sim/drape.h"

namespace pleat::sim {

struct SimulationConfig {  // section `simulation`
  double ease_deg = 10;  // largest joint turn of one step on the way to a frame
  double ease_residual = 0.1;  // steps on the way need not settle fully
  int ease_iterations = 4;
  NewtonConfig solver;
  ContactConfig contact;
  AcceptConfig accept;
};
void validate(const SimulationConfig& config);

// Sews a design around the mean body in the T-pose and lets it settle: the template of this design.
// InputError where it does not.
garment::Garment settle_garment(const garment::Design& design,
                                const garment::GarmentTopology& topology,
                                const body::BodyModel& model, const garment::Fabric& fabric,
                                const SimulationConfig& config);

// on_frame is told each finished frame's certificate and answers whether to go on; a clip that was
// stopped is shorter.
garment::Clip simulate(const garment::Garment& garment, const body::BodyModel& model,
                       const Eigen::VectorXd& shape, const body::Motion& motion,
                       const garment::Fabric& fabric, const SimulationConfig& config,
                       const std::function<bool(const garment::Certificate&)>& on_frame);

}  // namespace pleat::sim
