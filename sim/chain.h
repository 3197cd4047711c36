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

struct SimulationConfig {      // section `simulation`
  double ease_deg = 10;        // largest turn of a joint near the cloth in one step to a frame
  double ease_residual = 0.1;  // steps on the way need not settle fully
  int ease_iterations = 4;
  // Other ways to a frame that is rejected: 1 in smaller steps, 2 also coarse-to-fine (dressed anew
  // and brought there with a coarse tessellation, refined there), 3 also dressed anew as it is.
  // Behind a rejected frame: 1 straight from the last accepted one, and every fourth in the last two.
  int retries = 3;
  int checkpoint_frames = 20;  // after so many a chain begins anew from what its state says
  NewtonConfig solver;
  ContactConfig contact;
  AcceptConfig accept;
};
void validate(const SimulationConfig& config);

// Sews a design around the mean body in the T-pose and lets it settle: the template of this design.
// InputError where it does not, or was stopped.
garment::Garment settle_garment(const garment::Design& design,
                                const garment::GarmentTopology& topology,
                                const body::BodyModel& model, const garment::Fabric& fabric,
                                const SimulationConfig& config,
                                const std::function<bool()>& should_stop = {});

// How a simulation is looked after from outside. Empty functions are not called.
struct Supervision {
  std::function<void(const garment::Certificate&)> on_frame = {};
  std::function<void(const garment::Clip&)> on_part = {};
  std::function<bool()> should_stop = {};  // asked between iterations; what is under way is dropped
  double max_seconds_per_drape = 0;        // of processor time; 0: any. Frames that take longer are
                                           // rejected, as out of time
};

// Frames from->frame (0 where there is none) to the last, in parts of checkpoint_frames, each with
// the state that the next starts from. Taking up from that state gives the same bits as going on.
// A frame that is rejected is tried in other ways (config.retries); where none serves, the first
// counts. False where it was stopped.
bool simulate_parts(const garment::Garment& garment, const body::BodyModel& model,
                    const Eigen::VectorXd& shape, const body::Motion& motion,
                    const garment::Fabric& fabric, const SimulationConfig& config,
                    const garment::ClipState* from, const Supervision& supervision);

// The whole clip, in memory; shorter by the unfinished part where it was stopped.
garment::Clip simulate(const garment::Garment& garment, const body::BodyModel& model,
                       const Eigen::VectorXd& shape, const body::Motion& motion,
                       const garment::Fabric& fabric, const SimulationConfig& config,
                       const Supervision& supervision = {});

}  // namespace pleat::sim
