#include "sim/chain.h"

#include <time.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "body/skinning.h"
#include "core/error.h"
#include "garment/garment_weights.h"

namespace pleat::sim {
namespace {

double processor_seconds() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return now.tv_sec + 1e-9 * now.tv_nsec;
}

Eigen::Map<const Points3> as_points(const Eigen::VectorXd& x) {
  return {x.data(), x.size() / 3, 3};
}
Eigen::VectorXd as_vector(const Points3& points) {
  return Eigen::Map<const Eigen::VectorXd>(points.data(), points.size());
}

// Whom the cloth hangs on at one instant.
struct Wearer {
  Eigen::VectorXd shape;
  body::Pose pose;
};

Wearer blend(const Wearer& a, const Wearer& b, double t) {
  return {(1 - t) * a.shape + t * b.shape, body::blend(a.pose, b.pose, t)};
}

// The largest turn of a joint between two poses, rad.
double largest_turn(const body::Pose& a, const body::Pose& b) {
  double largest = 0;
  const auto rotation = [](const Vec<3>& axis_angle) {
    const double angle = axis_angle.norm();
    return Eigen::AngleAxisd(angle,
                             angle > 0 ? Vec<3>(axis_angle / angle) : Vec<3>(Vec<3>::UnitX()));
  };
  for (int j = 0; j < body::kJoints; ++j) {
    const Eigen::Quaterniond from(rotation(a.rotations.row(j).transpose())),
        to(rotation(b.rotations.row(j).transpose()));
    largest = std::max(largest, from.angularDistance(to));
  }
  return largest;
}

// One garment on one body, moving. Keeps the factor's analysis, the collider's tree and the state
// between drapes.
class Chain {
 public:
  Chain(const garment::GarmentTopology& topology, const Points2& panels, const SkinWeights& weights,
        const body::BodyModel& model, const garment::Fabric& fabric, const SimulationConfig& config,
        const Wearer& start, const Points3& positions)
      : topology_(topology),
        panels_(panels),
        weights_(weights),
        model_(model),
        config_(config),
        friction_(fabric.friction),
        cloth_(make_cloth(topology.faces, topology.panel_faces, panels, topology.vertex_count,
                          fabric)),
        factor_(cloth_.bending_hessian),
        wearer_(start),
        shaped_(body::shape_body(model, start.shape)),
        collider_(body::pose_body(model, shaped_, start.pose), model.faces, body_parts(model)) {
    state_.x = as_vector(positions);
    state_.anchors.resize(topology.vertex_count);
  }

  // Moves the wearer to `next` in steps small against the cloth, carrying the cloth along and
  // settling it at each.
  NewtonResult advance(const Wearer& next, const NewtonConfig& last_step) {
    const Wearer from = wearer_;
    const int steps = step_count(next);
    int iterations = 0;
    for (int s = 1; s < steps; ++s) {
      carry(blend(from, next, double(s) / steps));
      iterations += settle(easing()).iterations;
    }
    carry(next);
    NewtonResult result = settle(last_step);
    result.iterations += iterations;
    return result;
  }

  NewtonResult settle(const NewtonConfig& solver) {
    return drape(cloth_, collider_, friction_, config_.contact, solver, factor_, state_);
  }

  NewtonConfig easing() const {
    NewtonConfig easing = config_.solver;
    easing.residual = config_.ease_residual;
    easing.max_iterations = config_.ease_iterations;
    return easing;
  }

  garment::Certificate certify(const NewtonResult& solved) const {
    return sim::certify(positions(), topology_.faces, topology_.panel_faces, panels_, collider_,
                        solved, config_.accept);
  }

  const Wearer& wearer() const { return wearer_; }
  Points3 positions() const { return as_points(state_.x); }

 private:
  Points3 carried(const body::ShapedBody& shaped, const body::Pose& pose) const {
    const Points3 unposed = body::unskin_linear(
        as_points(state_.x), weights_, body::joint_transforms(model_, shaped_, wearer_.pose));
    return body::skin_linear(unposed, weights_, body::joint_transforms(model_, shaped, pose));
  }

  // How far the body shifts against the cloth that touches or nearly touches it, in steps of
  // config_.step_m.
  int step_count(const Wearer& next) const {
    constexpr double kNear = 0.02;  // m
    const body::ShapedBody shaped = body::shape_body(model_, next.shape);
    const Points3 body_next = body::pose_body(model_, shaped, next.pose);
    const Points3 cloth_next = carried(shaped, next.pose);
    const Points3 cloth_now = positions();
    double largest = 0;
    for (Eigen::Index v = 0; v < cloth_now.rows(); ++v) {
      const ClosestPoint closest =
          collider_.tree().closest(cloth_now.row(v).transpose(), kNear, collider_.is_active());
      if (closest.face < 0) continue;
      Vec<3> body_shift = -closest.point;
      for (int c = 0; c < 3; ++c)
        body_shift +=
            closest.barycentric[c] * body_next.row(model_.faces(closest.face, c)).transpose();
      const Vec<3> cloth_shift = (cloth_next.row(v) - cloth_now.row(v)).transpose();
      largest = std::max(largest, (body_shift - cloth_shift).norm());
    }
    return std::clamp(static_cast<int>(std::ceil(largest / config_.step_m)), 1, 20);
  }

  void carry(const Wearer& next) {
    const body::ShapedBody shaped = body::shape_body(model_, next.shape);
    state_.x = as_vector(carried(shaped, next.pose));
    shaped_ = shaped;
    wearer_ = next;
    collider_.move_to(body::pose_body(model_, shaped_, wearer_.pose));
  }

  const garment::GarmentTopology& topology_;
  const Points2& panels_;
  const SkinWeights& weights_;
  const body::BodyModel& model_;
  const SimulationConfig& config_;
  double friction_;
  Cloth cloth_;
  Cholesky factor_;
  Wearer wearer_;
  body::ShapedBody shaped_;
  BodyCollider collider_;
  DrapeState state_;
};

// From the T-pose on the mean body to the clip's shape, then to its first pose.
void ease_in(Chain& chain, const Wearer& first, const SimulationConfig& config) {
  const Wearer shaped{first.shape, chain.wearer().pose};
  chain.advance(shaped, chain.easing());
  const double turn = largest_turn(shaped.pose, first.pose);
  const int steps = std::max(1, static_cast<int>(std::ceil(turn * 180 / M_PI / config.ease_deg)));
  for (int s = 1; s <= steps; ++s)
    chain.advance(blend(shaped, first, double(s) / steps), chain.easing());
}

}  // namespace

void validate(const SimulationConfig& config) {
  if (!(config.step_m > 0)) throw InputError("simulation.step_m must be > 0");
  if (!(config.ease_deg > 0)) throw InputError("simulation.ease_deg must be > 0");
  if (!(config.ease_residual > 0)) throw InputError("simulation.ease_residual must be > 0");
  if (config.ease_iterations < 1) throw InputError("simulation.ease_iterations must be >= 1");
  try {
    validate(config.solver);
    validate(config.contact);
    validate(config.accept);
  } catch (const InputError& error) {  // they know their own section only
    throw InputError(std::string("simulation.") + error.what());
  }
}

garment::Clip simulate(const garment::Garment& garment, const body::BodyModel& model,
                       const Eigen::VectorXd& shape, const body::Motion& motion,
                       const garment::Fabric& fabric, const SimulationConfig& config,
                       const std::function<bool(const garment::Certificate&)>& on_frame) {
  garment::Clip clip;
  clip.design = garment.design;
  clip.fabric = fabric;
  clip.motion_name = motion.name;
  clip.frame_rate_hz = motion.frame_rate_hz;
  clip.shape = shape;
  const Wearer mean{Eigen::VectorXd::Zero(shape.size()), body::Pose{}};
  Chain chain(garment.topology, garment.panels, garment.weights, model, fabric, config, mean,
              garment.t_pose);
  double start = processor_seconds();
  ease_in(chain, {shape, motion.frames.front()}, config);
  for (const body::Pose& pose : motion.frames) {
    const NewtonResult solved = chain.advance({shape, pose}, config.solver);
    garment::Certificate certificate = chain.certify(solved);
    certificate.iterations = solved.iterations;
    certificate.seconds = processor_seconds() - start;
    start = processor_seconds();
    clip.poses.push_back(pose);
    clip.positions.push_back(chain.positions());
    clip.certificates.push_back(certificate);
    if (!on_frame(certificate)) break;
  }
  return clip;
}

garment::Garment settle_garment(const garment::Design& design,
                                const garment::GarmentTopology& topology,
                                const body::BodyModel& model, const garment::Fabric& fabric,
                                const SimulationConfig& config) {
  garment::Garment garment;
  garment.design = design;
  garment.topology = topology;
  garment.panels = garment::cut_panels(topology, design);
  const Eigen::VectorXd mean = Eigen::VectorXd::Zero(model.shape_directions.size());
  const body::ShapedBody shaped = body::shape_body(model, mean);
  const Points3 start = garment::place_around_body(topology, garment.panels, model, shaped);
  SkinWeights at_root(topology.vertex_count, model.joint_count());
  for (int v = 0; v < topology.vertex_count; ++v) at_root.insert(v, 0) = 1;
  Chain chain(topology, garment.panels, at_root, model, fabric, config, {mean, body::Pose{}},
              start);
  constexpr int kTries = 4;  // sewing starts far from rest
  garment::Certificate certificate;
  for (int i = 0; i < kTries && !certificate.is_accepted; ++i)
    certificate = chain.certify(chain.settle(config.solver));
  if (!certificate.is_accepted)
    throw InputError("design '" + design.name + "' does not settle on the mean body (" +
                     certificate.reason + "); give it other numbers, or loosen simulation.accept");
  garment.t_pose = chain.positions();
  garment.weights = garment::garment_weights(garment.t_pose, topology.faces, model, shaped);
  return garment;
}

}  // namespace pleat::sim
