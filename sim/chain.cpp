#include "sim/chain.h"

#include <time.h>

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "body/skinning.h"
#include "core/error.h"
#include "core/mesh.h"
#include "core/proximity.h"
#include "garment/garment_weights.h"
#include "garment/resample.h"
#include "sim/opened_body.h"

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

Points3 posed(const body::BodyModel& model, const Wearer& wearer) {
  return body::pose_body(model, body::shape_body(model, wearer.shape), wearer.pose);
}

// The largest turn of one of these joints between two poses, rad.
double largest_turn(const body::Pose& a, const body::Pose& b, const std::vector<char>& joints) {
  double largest = 0;
  const auto rotation = [](const Vec<3>& axis_angle) {
    const double angle = axis_angle.norm();
    return Eigen::AngleAxisd(angle,
                             angle > 0 ? Vec<3>(axis_angle / angle) : Vec<3>(Vec<3>::UnitX()));
  };
  for (int j = 0; j < body::kJoints; ++j) {
    if (!joints[j]) continue;
    const Eigen::Quaterniond from(rotation(a.rotations.row(j).transpose())),
        to(rotation(b.rotations.row(j).transpose()));
    largest = std::max(largest, from.angularDistance(to));
  }
  return largest;
}

// A design at one fineness.
struct Cut {
  garment::GarmentTopology topology;
  Points2 panels;
};

// Whether one vertex in `times` is enough to stand for the garment.
bool has_coarser(int vertex_count, int times) {
  constexpr int kCoarsest = 600;
  return vertex_count >= times * kCoarsest;
}

Cut coarser(const garment::Design& design, int vertex_count, int times) {
  Cut cut{garment::make_topology(vertex_count / times), {}};
  cut.panels = garment::cut_panels(cut.topology, design);
  return cut;
}

// For a tessellation that only has to show a finer one the way: it need not settle fully.
SimulationConfig sketching(SimulationConfig config) {
  config.solver.residual = std::max(config.solver.residual, 0.02);
  config.solver.max_iterations = std::min(config.solver.max_iterations, 60);
  config.solver.must_be_stable = false;
  return config;
}

// Layers so far apart that a finer tessellation, laid on the surface, does not cross itself where
// it cuts corners.
SimulationConfig far_apart(SimulationConfig config) {
  config.contact.distance_m *= 2;
  config.contact.stiffness_N_per_m3 /= 2;
  config.contact.layer_distance_m *= 4;
  config.contact.barrier_distance_m *= 2;
  return config;
}

// How often on a step's way the body may wait for cloth that holds it up.
constexpr int kMostLooks = 16, kLooksWhereCaught = 4;

// One garment on one body, moving. Keeps the trees and the state between drapes.
class Chain {
 public:
  Chain(const garment::GarmentTopology& topology, const Points2& panels,
        const body::BodyModel& model, const garment::Fabric& fabric, const SimulationConfig& config,
        const std::function<bool()>& should_stop, const Wearer& start, const Points3& positions)
      : topology_(topology),
        panels_(panels),
        model_(model),
        config_(config),
        should_stop_(should_stop),
        cloth_(make_cloth(topology.faces, topology.panel_faces, panels, topology.vertex_count,
                          fabric)),
        wearer_(start),
        opener_(model),
        posed_(posed(model, start), model.faces),
        collider_(posed(model, {start.shape, body::Pose{}}), model.faces),
        next_tree_(opener_.open(posed_.vertices()), model.faces),
        factor_(cloth_.bending_hessian),
        contacts_(topology.faces, cloth_.area, as_vector(positions), collider_, config.contact,
                  fabric.friction) {
    collider_.move_to(next_tree_.vertices());  // made in the T-pose: see BodyCollider
    state_.x = as_vector(positions);
    state_.anchors.resize(topology.vertex_count);
    for (const Edge& edge : edges(topology.faces)) edges_.push_back(edge.vertices);
  }

  // Moves the wearer to `next`, the cloth going along, in steps in which no joint turns far that
  // moves skin near the cloth, and settles it there.
  NewtonResult advance(const Wearer& next, const NewtonConfig& last_step, int looks = kMostLooks) {
    const Wearer from = wearer_;
    is_forced_ = false;
    const auto steps_for = [&](const std::vector<char>& joints) {
      const double turn = largest_turn(from.pose, next.pose, joints) * 180 / M_PI;
      return std::max(1, static_cast<int>(std::ceil(turn / config_.ease_deg)));
    };
    int steps = steps_for(std::vector<char>(model_.joint_count(), 1));
    if (steps > 1) steps = steps_for(joints_near());
    int iterations = 0;
    for (int s = 1; s <= steps; ++s) {
      iterations +=
          carry(s < steps ? blend(from, next, static_cast<double>(s) / steps) : next, looks);
      if (s < steps) iterations += settle(easing()).iterations;
    }
    NewtonConfig last = last_step;
    // Where the body went through the cloth it is worth more to look again for what is caught than
    // to come to rest.
    if (is_forced_) last.max_iterations = std::min(last.max_iterations, kForcedIterations);
    NewtonResult result = settle_free(last);
    result.iterations += iterations;
    return result;
  }

  // Where numbers break down the cloth stays as it was.
  NewtonResult settle(const NewtonConfig& solver) {
    const DrapeState before = state_;
    try {
      return drape(cloth_, contacts_, solver, factor_, state_, should_stop_);
    } catch (const SolverError&) {
      state_ = before;
      contacts_.forget();
      contacts_.follow_friction(1);
      NewtonResult none;
      none.residual = kBrokenDown;
      return none;
    }
  }

  // Pulls on what is caught in the body come to rest where their planes are, not always outside:
  // from there it is looked for anew. What is free where the body went through the cloth may go on
  // coming to rest.
  NewtonResult settle_free(const NewtonConfig& solver) {
    NewtonResult result = settle(solver);
    for (int i = 0; i < kMostFrees && !(should_stop_ && should_stop_()); ++i) {
      const bool is_caught = contacts_.has_loose() && is_in_body(certify(result), config_.accept);
      if (!is_caught && (!is_forced_ || result.has_converged)) break;
      if (is_caught) contacts_.free_again();
      const int iterations = result.iterations;
      result = settle(solver);
      result.iterations += iterations;
    }
    return result;
  }

  NewtonConfig easing() const {
    NewtonConfig easing = config_.solver;
    easing.residual = config_.ease_residual;
    easing.max_iterations = config_.ease_iterations;
    easing.must_be_stable = false;
    return easing;
  }

  garment::Certificate certify(const NewtonResult& solved) const {
    return sim::certify(positions(), topology_.faces, topology_.panel_faces, panels_, posed_,
                        collider_, solved, config_.accept);
  }

  // Whether nothing crosses anything.
  bool is_free() const {
    const garment::Certificate counts = certify({});
    return counts.body_intersections == 0 && counts.self_intersections == 0;
  }

  // Whether the body went through the cloth on the last way.
  bool was_forced() const { return is_forced_; }
  const Wearer& wearer() const { return wearer_; }
  Points3 positions() const { return as_points(state_.x); }

  garment::ClipState state(int frame, bool is_sound) const {
    const int count = cloth_.vertex_count;
    garment::ClipState state{frame, is_sound, positions(), Eigen::VectorXi(count),
                             Points3(count, 3)};
    for (int v = 0; v < count; ++v) {
      state.anchor_faces[v] = state_.anchors[v].face;
      state.anchor_barycentrics.row(v) = state_.anchors[v].barycentric.transpose();
    }
    return state;
  }
  void set_anchors(const garment::ClipState& state) {
    for (int v = 0; v < cloth_.vertex_count; ++v)
      state_.anchors[v] = {state.anchor_faces[v], state.anchor_barycentrics.row(v).transpose()};
  }

 private:
  static constexpr double kLeastShare = 0.02;
  static constexpr int kForcedIterations = 50;
  static constexpr int kMostFrees = 4;  // times that what is caught is looked for in one pose
  static constexpr double kBrokenDown = 1e9;  // residual of what has none

  // Moves the body, the cloth going along, and settles it on the way where it is caught. Nothing
  // passes through anything but where the body passes through itself, and, where the cloth is
  // pinched and holds the body up, the body through the cloth. Returns the iterations that this
  // took.
  int carry(const Wearer& next, int looks) {
    posed_.refit(posed(model_, next));
    const Points3 body_next = opener_.open(posed_.vertices());
    next_tree_.refit(body_next);
    const std::vector<char> is_off_next = collider_.overlaps(next_tree_);
    int iterations = 0;
    double t = 0;
    for (int step = 0; t < 1; ++step) {
      const Points3 here = collider_.vertices();
      Eigen::VectorXd motion = as_vector(carried(body_next)) - state_.x;
      double share = contacts_.free_share_with_body(state_.x, body_next, is_off_next, motion);
      if (step == looks || (step > 0 && share < kLeastShare)) {
        const double cloth_share = contacts_.free_share_without_body(state_.x, motion);
        state_.x += cloth_share * motion;
        share = 1;
        is_forced_ = true;
      } else {
        state_.x += share * motion;
      }
      t = share == 1 ? 1 : t + share * (1 - t);
      if (share == 1)
        collider_.move_to(next_tree_, is_off_next);
      else
        collider_.move_to(here + share * (body_next - here));
      contacts_.forget();
      if (t < 1) iterations += settle(easing()).iterations;
    }
    wearer_ = next;
    return iterations;
  }

  // Joints that skin near the cloth hangs on, and those before them.
  std::vector<char> joints_near() const {
    constexpr double kNear = 0.05, kLeast = 0.1;  // m; of a vertex's skin weights
    std::vector<char> is_near(model_.joint_count(), 0), is_seen(model_.faces.rows(), 0);
    for (int v = 0; v < cloth_.vertex_count; ++v) {
      const int face = collider_.tree().closest(state_.x.segment<3>(3 * v), kNear).face;
      if (face < 0 || is_seen[face]) continue;
      is_seen[face] = 1;
      for (int c = 0; c < 3; ++c)
        for (SkinWeights::InnerIterator w(model_.weights, model_.faces(face, c)); w; ++w)
          if (w.value() >= kLeast) is_near[w.col()] = 1;
    }
    for (int j = model_.joint_count() - 1; j > 0; --j)
      if (is_near[j]) is_near[model_.parents[j]] = 1;
    return is_near;
  }

  // Where the cloth goes when the body moves on: what lies on the body goes with its surface, what
  // hangs free follows smoothly (a harmonic field between).
  Points3 carried(const Points3& body_next) {
    constexpr double kOn = 0.005, kOff = 0.02;  // m
    const Points3& body_here = collider_.vertices();
    const int count = cloth_.vertex_count;
    Points3 pulled = Points3::Zero(count, 3);
    Eigen::VectorXd pull(count);
    for (int v = 0; v < count; ++v) {
      const Vec<3> x = state_.x.segment<3>(3 * v);
      const ClosestPoint closest = collider_.tree().closest(x, kOff);
      pull[v] = 1e-6;
      if (closest.face < 0) continue;
      const double away =
          std::clamp((std::sqrt(closest.squared_distance) - kOn) / (kOff - kOn), 0.0, 1.0);
      const double share = 1 - away * away * (3 - 2 * away);
      pull[v] += 10 * share / (1.001 - share);
      const Mat<3> frame_here = frame(body_here, closest.face),
                   frame_next = frame(body_next, closest.face);
      Vec<3> point_next = Vec<3>::Zero();
      for (int c = 0; c < 3; ++c)
        point_next +=
            closest.barycentric[c] * body_next.row(model_.faces(closest.face, c)).transpose();
      const Vec<3> offset = frame_next * (frame_here.transpose() * (x - closest.point));
      pulled.row(v) = pull[v] * (point_next + offset - x).transpose();
    }
    std::vector<Eigen::Triplet<double>> entries;
    for (int v = 0; v < count; ++v) entries.emplace_back(v, v, pull[v]);
    for (const auto& e : edges_) {
      entries.emplace_back(e[0], e[0], 1);
      entries.emplace_back(e[1], e[1], 1);
      entries.emplace_back(e[0], e[1], -1);
      entries.emplace_back(e[1], e[0], -1);
    }
    Eigen::SparseMatrix<double> matrix(count, count);
    matrix.setFromTriplets(entries.begin(), entries.end());
    if (!is_analysed_) harmonic_.analyzePattern(matrix);
    is_analysed_ = true;
    harmonic_.factorize(matrix);
    const Eigen::MatrixXd motion = harmonic_.solve(Eigen::MatrixXd(pulled));
    return as_points(state_.x) + Points3(motion);
  }

  // Unit axes that turn with a face.
  Mat<3> frame(const Points3& vertices, int face) const {
    const Vec<3> a = vertices.row(model_.faces(face, 0)), b = vertices.row(model_.faces(face, 1)),
                 c = vertices.row(model_.faces(face, 2));
    Mat<3> axes;
    axes.col(0) = (b - a).normalized();
    axes.col(2) = (b - a).cross(c - a).normalized();
    axes.col(1) = axes.col(2).cross(axes.col(0));
    return axes;
  }

  const garment::GarmentTopology& topology_;
  const Points2& panels_;
  const body::BodyModel& model_;
  SimulationConfig config_;
  std::function<bool()> should_stop_;
  Cloth cloth_;
  Wearer wearer_;
  BodyOpener opener_;
  SurfaceTree posed_;      // the body as the pose has it, and
  BodyCollider collider_;  // as it gives way to itself
  SurfaceTree next_tree_;  // of the body where it goes
  Cholesky factor_;
  ContactSearch contacts_;
  DrapeState state_;
  std::vector<std::array<int, 2>> edges_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> harmonic_;
  bool is_analysed_ = false;
  bool is_forced_ = false;
};

// From the T-pose on the mean body to the clip's shape, then to its first pose.
void ease_in(Chain& chain, const Wearer& first) {
  const Wearer shaped{first.shape, chain.wearer().pose};
  chain.advance(shaped, chain.easing());
  chain.advance(first, chain.easing());
}

}  // namespace

void validate(const SimulationConfig& config) {
  if (!(config.ease_deg > 0)) throw InputError("simulation.ease_deg must be > 0");
  if (!(config.ease_residual > 0)) throw InputError("simulation.ease_residual must be > 0");
  if (config.ease_iterations < 1) throw InputError("simulation.ease_iterations must be >= 1");
  if (config.retries < 0 || config.retries > 3)
    throw InputError("simulation.retries must be 0, 1, 2 or 3");
  if (config.checkpoint_frames < 1) throw InputError("simulation.checkpoint_frames must be >= 1");
  try {
    validate(config.solver);
    validate(config.contact);
    validate(config.accept);
  } catch (const InputError& error) {  // they know their own section only
    throw InputError(std::string("simulation.") + error.what());
  }
}

namespace {

// Smaller steps, settled better on the way.
SimulationConfig patient(SimulationConfig config) {
  config.ease_deg /= 2;
  config.ease_residual /= 2;
  config.ease_iterations *= 2;
  return config;
}

// A garment on its way through a motion, frame by frame.
class Walk {
 public:
  Walk(const garment::Garment& garment, const body::BodyModel& model, const Eigen::VectorXd& shape,
       const body::Motion& motion, const garment::Fabric& fabric, const SimulationConfig& config,
       const Supervision& supervision)
      : garment_(garment),
        model_(model),
        shape_(shape),
        motion_(motion),
        fabric_(fabric),
        config_(config),
        supervision_(supervision) {}

  bool is_cancelled() const { return supervision_.should_stop && supervision_.should_stop(); }

  // As the frame before left it.
  void start(const garment::ClipState* from) {
    chain_ = from ? taken_up(*from, config_) : nullptr;
    is_sound_ = !from || from->is_sound;
    last_sound_.reset();
    if (from && is_sound_) last_sound_ = *from;
  }

  garment::Certificate drape_frame(int t) {
    start_ = processor_seconds();
    was_stopped_ = false;
    std::vector<Way> ways = {has_coarse() ? Way::kRefined : Way::kAnew, Way::kAnew};
    int most = 1 + config_.retries;
    if (t > 0 && is_sound_) {
      ways = {Way::kOn, Way::kPatient, Way::kRefined, Way::kAnew};
    } else if (t > 0) {  // caught: only another beginning helps
      ways = {Way::kOn};
      if (config_.retries >= 1 && last_sound_) ways.push_back(Way::kAround);
      if (config_.retries >= 2 && t % kCaught == 0) ways.push_back(Way::kRefined);
      if (config_.retries >= 3 && t % kCaught == 0) ways.push_back(Way::kAnew);
      most = static_cast<int>(ways.size());
    }
    garment::Certificate certificate;
    int tries = 0;
    for (const Way way : ways) {
      if (certificate.is_accepted || tries == most || (tries > 0 && is_stopped())) break;
      // The slowest way of all, where the body went through the cloth, and seldom a better one.
      if (way == Way::kPatient && chain_->was_forced()) continue;
      std::unique_ptr<Chain> chain = brought(way, t, tries > 0);
      if (!chain) continue;
      garment::Certificate tried = try_frame(*chain, t);
      tried.attempts = ++tries;
      if (tries == 1) {
        certificate = tried;
        chain_ = std::move(chain);
      } else if (tried.is_accepted) {
        certificate = tried;
        chain_ = taken_up(chain->state(t + 1, true), config_);
      }
    }
    if (!certificate.is_accepted && is_out_of_time()) certificate.reason = garment::kOutOfTime;
    is_sound_ = certificate.is_accepted;
    if (is_sound_) last_sound_ = chain_->state(t + 1, true);
    certificate.seconds = processor_seconds() - start_;
    return certificate;
  }

  const Chain& chain() const { return *chain_; }
  bool is_sound() const { return is_sound_; }

 private:
  static constexpr int kCaught = 4;  // frames between tries to get the cloth loose

  // To a frame.
  enum class Way {
    kOn,       // from the frame before
    kPatient,  // the same in smaller steps
    kAround,   // from the last accepted frame of the part, straight, not as the poses between went
    kRefined,  // dressed in the T-pose and brought there with a coarse tessellation, refined there
    kAnew      // dressed in the T-pose and brought there
  };

  bool is_out_of_time() const {
    return supervision_.max_seconds_per_drape > 0 &&
           processor_seconds() - start_ > supervision_.max_seconds_per_drape;
  }
  // Remembered: a try that was cut short anywhere on its way is none.
  bool is_stopped() {
    was_stopped_ = was_stopped_ || is_cancelled() || is_out_of_time();
    return was_stopped_;
  }

  Wearer wearer(int t) const { return {shape_, motion_.frames[static_cast<size_t>(t)]}; }

  std::unique_ptr<Chain> chain_on(const Wearer& wearer, const Points3& positions,
                                  const SimulationConfig& config) {
    return std::make_unique<Chain>(
        garment_.topology, garment_.panels, model_, fabric_, config,
        [this] { return is_stopped(); }, wearer, positions);
  }
  std::unique_ptr<Chain> taken_up(const garment::ClipState& state, const SimulationConfig& config) {
    auto chain = chain_on(wearer(state.frame - 1), state.positions, config);
    chain->set_anchors(state);
    return chain;
  }
  // As far as the last step, or steps, to frame t. Nothing where this way is closed.
  std::unique_ptr<Chain> brought(Way way, int t, bool is_patient) {
    const SimulationConfig config = is_patient ? patient(config_) : config_;
    if (way == Way::kOn) return std::move(chain_);
    if (way == Way::kPatient) return taken_up(*last_sound_, config);
    if (way == Way::kAround) return taken_up(*last_sound_, config_);
    const Wearer mean{Eigen::VectorXd::Zero(shape_.size()), body::Pose{}};
    if (way == Way::kAnew) {
      auto chain = chain_on(mean, garment_.t_pose, config);
      ease_in(*chain, wearer(t));
      return chain;
    }
    if (!has_coarse()) return nullptr;
    const Cut& cut = coarse();
    const SimulationConfig sketch = far_apart(sketching(config));
    Chain drawn(
        cut.topology, cut.panels, model_, fabric_, sketch, [this] { return is_stopped(); }, mean,
        garment::resample(garment_.topology, garment_.t_pose, cut.topology));
    ease_in(drawn, wearer(t));
    drawn.settle(sketch.solver);
    auto chain = chain_on(
        wearer(t), garment::resample(cut.topology, drawn.positions(), garment_.topology), config);
    return chain->is_free() ? std::move(chain) : nullptr;
  }

  static constexpr int kTimesCoarser = 4;
  bool has_coarse() const { return has_coarser(garment_.topology.vertex_count, kTimesCoarser); }
  const Cut& coarse() {
    if (!coarse_) coarse_ = coarser(garment_.design, garment_.topology.vertex_count, kTimesCoarser);
    return *coarse_;
  }

  garment::Certificate try_frame(Chain& chain, int t) {
    const NewtonResult solved =
        chain.advance(wearer(t), config_.solver, is_sound_ ? kMostLooks : kLooksWhereCaught);
    garment::Certificate certificate = chain.certify(solved);
    certificate.iterations = solved.iterations;
    if (was_stopped_) {
      certificate.is_accepted = false;
      certificate.reason = garment::kOutOfTime;
    }
    return certificate;
  }

  const garment::Garment& garment_;
  const body::BodyModel& model_;
  const Eigen::VectorXd& shape_;
  const body::Motion& motion_;
  const garment::Fabric& fabric_;
  const SimulationConfig& config_;
  const Supervision& supervision_;
  std::unique_ptr<Chain> chain_;
  std::optional<Cut> coarse_;  // made where it is first needed
  bool is_sound_ = true;
  std::optional<garment::ClipState> last_sound_;  // of the part; of the frame before if is_sound_
  double start_ = 0;  // of the frame, processor seconds
  bool was_stopped_ = false;
};

// It may be from a file.
void check_state(const garment::ClipState& state, const garment::Garment& garment,
                 const body::BodyModel& model, int frames) {
  const bool is_fitting = state.frame >= 1 && state.frame <= frames &&
                          state.positions.rows() == garment.topology.vertex_count &&
                          state.anchor_faces.size() == state.positions.rows() &&
                          state.anchor_barycentrics.rows() == state.positions.rows() &&
                          state.anchor_faces.minCoeff() >= -1 &&
                          state.anchor_faces.maxCoeff() < model.faces.rows();
  if (!is_fitting)
    throw InputError("the state of frame " + std::to_string(state.frame) +
                     " does not fit garment, body and motion");
}

}  // namespace

bool simulate_parts(const garment::Garment& garment, const body::BodyModel& model,
                    const Eigen::VectorXd& shape, const body::Motion& motion,
                    const garment::Fabric& fabric, const SimulationConfig& config,
                    const garment::ClipState* from, const Supervision& supervision) {
  const int frames = static_cast<int>(motion.frames.size());
  garment::Clip part;
  part.design = garment.design;
  part.fabric = fabric;
  part.motion_name = motion.name;
  part.frame_rate_hz = motion.frame_rate_hz;
  part.shape = shape;
  part.first_frame = from ? from->frame : 0;
  part.from_sha256 = from ? garment::state_hash(*from) : "";
  if (from) check_state(*from, garment, model, frames);
  Walk walk(garment, model, shape, motion, fabric, config, supervision);
  walk.start(from);
  for (int t = part.first_frame; t < frames; ++t) {
    const garment::Certificate certificate = walk.drape_frame(t);
    if (walk.is_cancelled()) return false;
    part.poses.push_back(motion.frames[static_cast<size_t>(t)]);
    part.positions.push_back(walk.chain().positions());
    part.certificates.push_back(certificate);
    if (supervision.on_frame) supervision.on_frame(certificate);
    if ((t + 1) % config.checkpoint_frames != 0 && t + 1 < frames) continue;
    part.states = {walk.chain().state(t + 1, walk.is_sound())};
    if (supervision.on_part) supervision.on_part(part);
    part.first_frame = t + 1;
    part.from_sha256 = garment::state_hash(part.states.front());
    part.poses.clear();
    part.positions.clear();
    part.certificates.clear();
    if (t + 1 < frames) walk.start(&part.states.front());
  }
  return true;
}

garment::Clip simulate(const garment::Garment& garment, const body::BodyModel& model,
                       const Eigen::VectorXd& shape, const body::Motion& motion,
                       const garment::Fabric& fabric, const SimulationConfig& config,
                       const Supervision& supervision) {
  garment::Clip clip;
  Supervision collecting = supervision;
  collecting.on_part = [&](const garment::Clip& part) {
    if (supervision.on_part) supervision.on_part(part);
    garment::Clip joined = part;
    joined.first_frame = 0;
    joined.from_sha256.clear();
    joined.poses.insert(joined.poses.begin(), clip.poses.begin(), clip.poses.end());
    joined.positions.insert(joined.positions.begin(), clip.positions.begin(), clip.positions.end());
    joined.certificates.insert(joined.certificates.begin(), clip.certificates.begin(),
                               clip.certificates.end());
    joined.states.insert(joined.states.begin(), clip.states.begin(), clip.states.end());
    clip = std::move(joined);
  };
  simulate_parts(garment, model, shape, motion, fabric, config, nullptr, collecting);
  return clip;
}

namespace {

Chain chain_on_mean(const Cut& cut, const body::BodyModel& model, const garment::Fabric& fabric,
                    const SimulationConfig& config, const std::function<bool()>& should_stop,
                    const Points3& positions) {
  return Chain(cut.topology, cut.panels, model, fabric, config, should_stop,
               {Eigen::VectorXd::Zero(model.shape_directions.size()), body::Pose{}}, positions);
}

constexpr int kTimesCoarserSewn = 2;

// Where settling starts: around the body, or, settled there, a coarser tessellation.
Points3 sewn(const Cut& cut, const garment::Design& design, const body::BodyModel& model,
             const garment::Fabric& fabric, const SimulationConfig& config,
             const std::function<bool()>& should_stop) {
  if (!has_coarser(cut.topology.vertex_count, kTimesCoarserSewn))
    return garment::place_around_body(
        cut.topology, cut.panels, model,
        body::shape_body(model, Eigen::VectorXd::Zero(model.shape_directions.size())));
  const Cut coarse = coarser(design, cut.topology.vertex_count, kTimesCoarserSewn);
  const SimulationConfig sketch = sketching(config);
  Chain chain = chain_on_mean(coarse, model, fabric, sketch, should_stop,
                              sewn(coarse, design, model, fabric, config, should_stop));
  chain.settle(sketch.solver);
  return garment::resample(coarse.topology, chain.positions(), cut.topology);
}

}  // namespace

garment::Garment settle_garment(const garment::Design& design,
                                const garment::GarmentTopology& topology,
                                const body::BodyModel& model, const garment::Fabric& fabric,
                                const SimulationConfig& config,
                                const std::function<bool()>& should_stop) {
  garment::Garment garment;
  garment.design = design;
  garment.topology = topology;
  garment.panels = garment::cut_panels(topology, design);
  const body::ShapedBody shaped =
      body::shape_body(model, Eigen::VectorXd::Zero(model.shape_directions.size()));
  const Cut cut{topology, garment.panels};
  garment::Certificate certificate;
  for (const bool is_coarse_first : {true, false}) {
    if (is_coarse_first && !has_coarser(topology.vertex_count, kTimesCoarserSewn)) continue;
    if (should_stop && should_stop()) break;
    const Points3 start = is_coarse_first
                              ? sewn(cut, design, model, fabric, config, should_stop)
                              : garment::place_around_body(topology, garment.panels, model, shaped);
    Chain chain = chain_on_mean(cut, model, fabric, config, should_stop, start);
    constexpr int kTries = 4;  // sewing starts far from rest
    for (int i = 0; i < kTries && !certificate.is_accepted && !(should_stop && should_stop()); ++i)
      certificate = chain.certify(chain.settle(config.solver));
    garment.t_pose = chain.positions();
    if (certificate.is_accepted) break;
  }
  if (!certificate.is_accepted)
    throw InputError("design '" + design.name + "' does not settle on the mean body (" +
                     certificate.reason + "); give it other numbers, or loosen simulation.accept");
  garment.weights = garment::garment_weights(garment.t_pose, topology.faces, model, shaped);
  return garment;
}

}  // namespace pleat::sim
