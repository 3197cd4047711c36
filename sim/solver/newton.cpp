#include "sim/solver/newton.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/error.h"
#include "sim/solver/trust_region.h"

namespace pleat::sim {
namespace {

constexpr double kCaution = 30;  // 1/s^2 times the masses: what the factor adds to the Hessian
constexpr double kMostCaution = 1e12;  // times as much
constexpr double kNear = 30;  // residuals to reach: from there on the factor is the Hessian's own,
constexpr double kCloser = 0.3;      // and where it has none it is asked again this much nearer
constexpr double kSlow = 0.01;       // of the caution: curvature that a stable equilibrium may lack
constexpr double kHeld = 1e9;        // J/m^2: what the factor adds for a pinned vertex
constexpr int kStale = 8;            // products that a step may take before its factor is renewed
constexpr double kLanding = 0.6;     // of the contact distance: how deep a step may dip into it
constexpr double kLanded = 0.7;      // unless it starts from below this
constexpr double kFarthest = 0.05;   // m: no vertex is set down from deeper
constexpr double kArmijo = 1e-4;     // of the slope: the least fall of the energy
constexpr int kMostTries = 5;        // of ever shorter steps, in one iteration
constexpr int kPatience = 12;        // iterations in which the residual should halve,
constexpr double kFollow = 0.3;      // else this is how far friction follows in one
constexpr double kRounding = 1e-13;  // of the energy

// The worst part of a cloth, where it is small: vertices with most of the squared residual, and
// some rows around them.
constexpr double kWorstShare = 0.9;  // of the squared residual
constexpr double kMostWorst = 0.1;   // of all vertices
constexpr int kRowsAround = 3;       // in steps of the Hessian's pattern, two rows each
constexpr int kMostLocal = 20;       // iterations
constexpr double kLocalGoal = 0.3;   // of the residual of the rest

class Minimiser {
 public:
  Minimiser(const Cloth& cloth, ContactSearch& contacts, const NewtonConfig& config,
            Cholesky& factor, Eigen::VectorXd& x, std::vector<Anchor>& anchors,
            const std::function<bool()>& should_stop)
      : cloth_(cloth),
        contacts_(contacts),
        config_(config),
        factor_(factor),
        x_(x),
        anchors_(anchors),
        should_stop_(should_stop),
        shift_(cloth.vertex_count),
        step_(Eigen::VectorXd::Zero(x.size())) {
    for (const Weight& weight : cloth.weights) shift_[weight.vertex] = kCaution * weight.mass;
    if (!cloth.is_pinned.empty())
      for (int v = 0; v < cloth.vertex_count; ++v)
        if (cloth.is_pinned[v]) shift_[v] = kHeld;
  }

  NewtonResult run();

 private:
  // A part of the cloth under Newton's method, and what it keeps from step to step.
  struct Patch {
    Region region;
    bool is_whole;
    double radius = 0;
    std::vector<int> pairs = {};  // barriers that may act on it,
    int pairs_of = -1;            // and the search that they are from
    int products = 0;             // of the last step,
    bool was_good = true;         // which the model foretold
  };
  // What touches, and the system at x_. Returns the residual.
  double evaluate(Patch& patch, Order order);
  // The same of the whole cloth, friction following what is there by so much, and standing still
  // from then on: the worst part is settled in one energy.
  double evaluate_following(Patch& all, double share);
  void know_pairs(Patch& patch);
  // One step in the patch.
  void advance(Patch& patch);
  void prepare_step(Patch& patch);
  void land();
  struct Aim {
    double cap;     // of the direction's length, that no vertex moves too far
    double length;  // of step_, that nothing passes through anything; 0: the energy rises anyway
    bool is_weighed;  // trial_ has the energy there, but for barriers
  };
  Aim aim(Patch& patch, const Eigen::VectorXd& direction);
  double energy_at(const Patch& patch, const Aim& aim);
  double rounding() const { return kRounding * std::abs(system_.energy); }
  bool may_be_definite() const {
    return result_.residual <= kNear * config_.residual &&
           result_.residual <= kCloser * indefinite_at_;
  }
  void renew_factor(const Patch& all);
  bool is_minimum(const Patch& all);
  bool settle_worst();

  const Cloth& cloth_;
  ContactSearch& contacts_;
  const NewtonConfig& config_;
  Cholesky& factor_;
  Eigen::VectorXd& x_;
  std::vector<Anchor>& anchors_;
  const std::function<bool()>& should_stop_;
  Eigen::VectorXd shift_;  // #V, J/m^2
  Eigen::VectorXd step_;   // 3#V, m; zero outside the patch at work
  Touching touching_;
  std::vector<ActiveBarrier> barriers_;
  System system_, trial_;
  bool has_own_ = false;         // the factor is the Hessian's own
  double indefinite_at_ = 1e30;  // residual at which the Hessian was last found not to have one
  NewtonResult result_;
};

void Minimiser::know_pairs(Patch& patch) {
  if (patch.pairs_of == contacts_.search_count()) return;
  patch.pairs_of = contacts_.search_count();
  patch.pairs = contacts_.pairs_at(patch.region.place);
}

double Minimiser::evaluate(Patch& patch, Order order) {
  know_pairs(patch);
  touching_ = contacts_.touching(patch.region.vertices, x_, anchors_);
  barriers_ = contacts_.barriers(patch.pairs, x_, order);
  assemble(cloth_, patch.region, touching_, barriers_, x_, order, system_);
  return restrict_to(patch.region, system_.gradient).norm() / cloth_.weight_norm;
}

double Minimiser::evaluate_following(Patch& all, double share) {
  contacts_.follow_friction(share);
  const double residual = evaluate(all, Order::kHessian);
  contacts_.follow_friction(0);
  return residual;
}

// What preconditions the steps. Far from rest, a positive definite part of the Hessian serves; near
// it the Hessian itself, where that is positive definite.
void Minimiser::renew_factor(const Patch& all) {
  const auto factor = [&](const BlockMatrix& hessian, const std::vector<ActiveBarrier>& barriers,
                          double caution) {
    ++result_.factorisations;
    return factor_.factor_roughly(with_barriers({cloth_, all.region, hessian, barriers}),
                                  caution * shift_);
  };
  if (may_be_definite()) {
    has_own_ = factor(system_.hessian, barriers_, kSlow);
    if (has_own_) return;
    indefinite_at_ = result_.residual;
  }
  has_own_ = false;
  const std::vector<ActiveBarrier> barriers =
      contacts_.barriers(all.pairs, x_, Order::kProjectedHessian);
  assemble(cloth_, all.region, touching_, barriers, x_, Order::kProjectedHessian, trial_);
  double caution = 1;
  while (
      !factor(trial_.hessian, barriers, caution)) {  // by rounding, where barriers are very stiff
    caution *= 30;
    if (caution > kMostCaution) throw SolverError("no factor of the forces' derivatives");
  }
}

// Whether the Hessian has no negative curvature where x_ is.
bool Minimiser::is_minimum(const Patch& all) {
  ++result_.factorisations;
  return factor_.factor(with_barriers({cloth_, all.region, system_.hessian, barriers_}),
                        kSlow * shift_);
}

// Finds out what the step may meet. A patch rather takes a shorter step, where little is missing: a
// search costs more than an iteration of a patch.
void Minimiser::prepare_step(Patch& patch) {
  constexpr double kLeast = 0.5;
  if (!patch.is_whole) {
    const double known = contacts_.known_share(patch.region.vertices, x_, step_);
    if (known >= kLeast) {
      step_ *= known;
      return;
    }
  }
  const int before = contacts_.search_count();
  contacts_.prepare(x_, step_);
  if (contacts_.search_count() == before) return;
  know_pairs(patch);
  touching_ = contacts_.touching(patch.region.vertices, x_, anchors_);
}

// A step that would dip deep into the body ends on its surface: the model does not know of contacts
// that are still to come.
void Minimiser::land() {
  for (const Contact& contact : touching_.contacts) {
    const Vec<3> here = x_.segment<3>(3 * contact.vertex);
    if (step_.segment<3>(3 * contact.vertex).norm() < contact.room) continue;
    const BodyField field =
        contact_field(contact, *touching_.body, here + step_.segment<3>(3 * contact.vertex), 1);
    const double least = kLanding * contact.distance;
    if (field.phi >= least) continue;
    const double now = contact_field(contact, *touching_.body, here, 0).phi;
    if (now < kLanded * contact.distance) continue;  // the model knows of this one
    const double up = (least - field.phi) / field.gradient.norm();
    if (!(up <= kFarthest)) continue;  // not the surface, but where it fades
    step_.segment<3>(3 * contact.vertex) += up * field.gradient.normalized();
  }
}

double Minimiser::energy_at(const Patch& patch, const Aim& aim) {
  const Eigen::VectorXd at = x_ + aim.length * step_;
  if (!aim.is_weighed) assemble(cloth_, patch.region, touching_, {}, at, Order::kValue, trial_);
  return trial_.energy + contacts_.barrier_energy(patch.pairs, at);
}

// A step along `direction` as far as nothing meets.
Minimiser::Aim Minimiser::aim(Patch& patch, const Eigen::VectorXd& direction) {
  double longest = 0;
  for (Eigen::Index i = 0; i < direction.size(); i += 3)
    longest = std::max(longest, direction.segment<3>(i).norm());
  const double cap = std::min(1.0, config_.max_step_m / longest);
  spread(patch.region, cap * direction, step_);
  land();
  // What the cloth may meet on the way only adds to the energy at its end: no need to look.
  const Eigen::VectorXd weighed = step_;
  assemble(cloth_, patch.region, touching_, {}, x_ + weighed, Order::kValue, trial_);
  if (trial_.energy > system_.energy + rounding()) return {cap, 0, true};
  const int before = contacts_.search_count();
  prepare_step(patch);
  const bool knew = contacts_.search_count() == before;
  if (!knew) {
    land();
    prepare_step(patch);
  }
  const double length = contacts_.free_share(patch.pairs, x_, step_);
  return {cap, length, knew && length == 1 && step_ == weighed};
}

void Minimiser::advance(Patch& patch) {
  const NewtonSystem linear{cloth_, patch.region, system_.hessian, barriers_};
  const Eigen::VectorXd gradient = restrict_to(patch.region, system_.gradient);
  const double residual = gradient.norm() / cloth_.weight_norm;
  std::vector<Mat<3>> inverse;
  if (!patch.is_whole) inverse = inverse_blocks(linear);
  const auto precondition = [&](const Eigen::VectorXd& r, Eigen::VectorXd& z) {
    if (patch.is_whole) return factor_.solve_roughly(r, z);
    z.resize(r.size());
    for (size_t i = 0; i < inverse.size(); ++i)
      z.segment<3>(3 * i) = inverse[i] * r.segment<3>(3 * i);
  };
  const TrustRegionStep solved =
      trust_region_step(linear, gradient, patch.radius,
                        {std::min(0.1, std::sqrt(residual)), patch.is_whole ? 60 : 200,
                         patch.is_whole && residual <= config_.residual},
                        precondition);
  patch.products = solved.iterations;
  if (patch.is_whole) result_.products += solved.iterations;

  // Where a step fails, a shorter one along the way that led to it costs no more than a look.
  Eigen::VectorXd Hp;
  for (int tries = 0; tries < kMostTries; ++tries) {
    const double radius = tries == 0 ? solved.length : patch.radius;
    const Aim aimed = aim(patch, tries == 0 ? solved.step : solved.cut(radius));
    const double cap = aimed.cap, length = aimed.length;
    if (length == 0) {
      patch.was_good = false;
      patch.radius = 0.5 * radius * cap;
      continue;
    }

    // What the model foretells of the step as it became.
    const Eigen::VectorXd direction = restrict_to(patch.region, step_);
    multiply(linear, direction, Hp);
    const double rise = direction.dot(gradient);
    const double foretold = length * rise + 0.5 * length * length * direction.dot(Hp);
    const double fall = system_.energy - energy_at(patch, aimed);
    double ratio = -1;
    if (std::abs(foretold) <= rounding())
      ratio = 1;  // neither is known any better
    else if (foretold < 0)
      ratio = fall / -foretold;
    const bool is_lower = fall >= -kArmijo * length * std::min(0.0, rise) - rounding();
    patch.was_good = is_lower && ratio >= 0.25;
    if (!patch.was_good)
      patch.radius = 0.5 * radius * cap * std::max(length, 0.1);
    else if (tries > 0 || patch.radius <= 0)
      patch.radius = ratio > 0.75 ? 2 * radius : radius;
    else if (ratio > 0.75)
      patch.radius = std::max(patch.radius, 2 * radius);
    if (!is_lower) continue;
    x_ += length * step_;
    return;
  }
}

// Where few vertices hold most of the residual, they and their surroundings are settled alone.
bool Minimiser::settle_worst() {
  std::vector<std::pair<double, int>> squares(cloth_.vertex_count);
  double total = 0;
  for (int v = 0; v < cloth_.vertex_count; ++v) {
    const double square = system_.gradient.segment<3>(3 * v).squaredNorm();
    squares[v] = {-square, v};
    total += square;
  }
  std::sort(squares.begin(), squares.end());
  std::vector<int> worst;
  double sum = 0;
  for (const auto& [square, v] : squares) {
    if (sum >= kWorstShare * total) break;
    sum -= square;
    worst.push_back(v);
  }
  if (static_cast<double>(worst.size()) > kMostWorst * cloth_.vertex_count) return false;
  Patch patch{around(cloth_, worst, kRowsAround), false};
  if (2 * patch.region.vertices.size() > static_cast<size_t>(cloth_.vertex_count)) return false;
  const double goal =
      std::max(0.3 * config_.residual, kLocalGoal * std::sqrt(total - sum) / cloth_.weight_norm);
  step_.setZero();
  for (int i = 0; i < kMostLocal; ++i) {
    if (evaluate(patch, Order::kHessian) <= goal) break;
    advance(patch);
    ++result_.local_iterations;
  }
  return true;
}

NewtonResult Minimiser::run() {
  Patch all{whole(cloth_), true};
  contacts_.look_around(x_);
  bool is_fresh = false, was_local = false, is_cautious = false;
  double least = std::numeric_limits<double>::infinity();
  int least_at = 0;
  while (true) {
    result_.residual = evaluate_following(all, is_cautious ? kFollow : 1);
    if (!std::isfinite(result_.residual))
      throw SolverError("the forces on the cloth are not finite");
    if (is_cautious && result_.residual <= config_.residual)
      result_.residual = evaluate_following(all, 1);
    const bool is_settled = result_.residual <= config_.residual;
    if (is_settled) {
      result_.is_stable = config_.must_be_stable && is_minimum(all);
      result_.has_converged = result_.is_stable || !config_.must_be_stable;
      if (result_.has_converged) break;
      indefinite_at_ = 0;  // whatever single precision makes of it
      is_fresh = false;
    }
    if ((should_stop_ && should_stop_()) || result_.iterations >= config_.max_iterations) break;
    if (result_.residual < 0.5 * least) {
      least = result_.residual;
      least_at = result_.iterations;
    }
    is_cautious = is_cautious || result_.iterations > least_at + kPatience;
    if (!is_settled && result_.iterations > 0 && !was_local) {
      was_local = settle_worst();
      if (was_local) {
        contacts_.look_around(x_);
        continue;
      }
    }
    was_local = false;
    if (!is_fresh || (!has_own_ && may_be_definite())) renew_factor(all);
    advance(all);
    contacts_.look_around(x_);
    is_fresh = all.products <= kStale && all.was_good;
    ++result_.iterations;
  }
  contacts_.follow_friction(1);
  return result_;
}

}  // namespace

void validate(const NewtonConfig& config) {
  if (!(config.residual > 0 && config.residual < 1))
    throw InputError("solver.residual must lie in (0, 1)");
  if (config.max_iterations < 1) throw InputError("solver.max_iterations must be >= 1");
  if (!(config.max_step_m > 0)) throw InputError("solver.max_step_m must be > 0");
}

NewtonResult minimise(const Cloth& cloth, ContactSearch& contacts, const NewtonConfig& config,
                      Cholesky& factor, Eigen::VectorXd& x, std::vector<Anchor>& anchors,
                      const std::function<bool()>& should_stop) {
  return Minimiser(cloth, contacts, config, factor, x, anchors, should_stop).run();
}

}  // namespace pleat::sim
