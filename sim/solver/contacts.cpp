#include "sim/solver/contacts.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/error.h"
#include "sim/solver/continuous_collision.h"

namespace pleat::sim {
namespace {

constexpr double kKeep = 0.1;       // of the distance of two features is left by any one step
constexpr double kOutside = 0.005;  // m: how far the smooth surface may lie outside of the mesh
constexpr double kSteep = 1.6;      // the field grows no faster, where it matters
constexpr double kApart = 1e-4;  // m: what never comes as near as twice this on the way is left out
constexpr double kStray = 0.002;    // m: pairs stay known while vertices move as little as this
constexpr double kDeep = 0.04;      // m: as deep inside the body loose vertices are found
constexpr double kParallel = 1e-3;  // sin^2 of 1.8 degrees, between edges of mean length
constexpr double kLift = 2;         // contact distances that loose vertices are pulled out to

Eigen::VectorXd moves(const Eigen::VectorXd& from, const Eigen::VectorXd& to) {
  Eigen::VectorXd result(from.size() / 3);
  for (Eigen::Index v = 0; v < result.size(); ++v)
    result[v] = (to.segment<3>(3 * v) - from.segment<3>(3 * v)).norm();
  return result;
}

// The larger move in each feature, added up.
double approach(const NearPair& pair, const Eigen::VectorXd& move) {
  const int count = static_cast<int>(move.size());
  const auto of = [&](int k) { return pair.vertices[k] < count ? move[pair.vertices[k]] : 0.0; };
  return pair.kind == PairKind::kPointFace ? of(0) + std::max({of(1), of(2), of(3)})
                                           : std::max(of(0), of(1)) + std::max(of(2), of(3));
}

double smoothstep(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

}  // namespace

void validate(const ContactConfig& config) {
  if (!(config.distance_m > 0 && config.distance_m <= 0.02))
    throw InputError("contact.distance_m must lie in (0, 0.02]");
  if (!(config.stiffness_N_per_m3 > 0)) throw InputError("contact.stiffness_N_per_m3 must be > 0");
  if (!(config.stick_N_per_m3 > 0)) throw InputError("contact.stick_N_per_m3 must be > 0");
  if (!(config.layer_distance_m > 0 && config.layer_distance_m <= 0.01))
    throw InputError("contact.layer_distance_m must lie in (0, 0.01]");
  if (!(config.barrier_distance_m > 0 && config.barrier_distance_m < config.distance_m))
    throw InputError("contact.barrier_distance_m must lie in (0, contact.distance_m)");
  if (!(config.barrier_Pa > 0)) throw InputError("contact.barrier_Pa must be > 0");
}

ContactSearch::ContactSearch(const Faces& cloth, const Eigen::VectorXd& areas,
                             const Eigen::VectorXd& x, const BodyCollider& body,
                             const ContactConfig& config, double friction)
    : body_(body),
      config_(config),
      friction_(friction),
      areas_(areas),
      mean_area_(areas.mean()),
      finder_(cloth, Eigen::Map<const Points3>(x.data(), areas.size(), 3), body.faces(),
              body.vertices()),
      cloth_tree_(Eigen::Map<const Points3>(x.data(), areas.size(), 3), cloth),
      is_loose_(areas.size(), 0),
      supports_(areas.size()) {}

void ContactSearch::forget() {
  is_known_ = false;
  std::fill(supports_.begin(), supports_.end(), Supports{});
}

void ContactSearch::free_again() {
  forget();
  may_cross_ = true;
}

double ContactSearch::room_of(int vertex, const Eigen::VectorXd& x) const {
  return reach_[vertex] - (x.segment<3>(3 * vertex) - found_at_.segment<3>(3 * vertex)).norm();
}

double ContactSearch::known_share(const std::vector<int>& vertices, const Eigen::VectorXd& x,
                                  const Eigen::VectorXd& step) const {
  if (!is_known_) return 0;
  double share = 1;
  for (const int v : vertices) {
    const double room = room_of(v, x), length = step.segment<3>(3 * v).norm();
    if (share * length > room) share = std::max(0.0, room / length);
  }
  return share;
}

Scene ContactSearch::scene_at(const Eigen::VectorXd& x) const {
  Scene scene;
  scene.positions.resize(count() + body_.vertices().rows(), 3);
  scene.positions.topRows(count()) = Eigen::Map<const Points3>(x.data(), count(), 3);
  scene.positions.bottomRows(body_.vertices().rows()) = body_.vertices();
  scene.reach = Eigen::VectorXd::Zero(scene.positions.rows());
  scene.is_face_off = body_.is_off();
  if (has_loose_) scene.is_loose = is_loose_;
  return scene;
}

void ContactSearch::look_around(const Eigen::VectorXd& x) {
  if (may_cross_ || has_loose_) find_loose(x);
  prepare(x, Eigen::VectorXd::Zero(x.size()));
}

void ContactSearch::prepare(const Eigen::VectorXd& x, const Eigen::VectorXd& step) {
  std::vector<char> is_asked(count(), 1);
  int asked = count();
  if (is_known_) {
    asked = 0;
    for (int v = 0; v < count(); ++v) {
      is_asked[v] = step.segment<3>(3 * v).norm() > room_of(v, x);
      asked += is_asked[v];
    }
    if (asked == 0) return measure(x, found_.pairs.size());
  } else {
    found_at_ = measured_at_ = x;
    reach_.resize(count());
    found_ = {};
    found_.rest_start.assign(count() + 1, 0);
  }
  for (int v = 0; v < count(); ++v) {
    if (!is_asked[v]) continue;
    found_at_.segment<3>(3 * v) = x.segment<3>(3 * v);
    reach_[v] = step.segment<3>(3 * v).norm() + kStray;
  }
  Scene scene = scene_at(found_at_);
  scene.reach.head(count()) = reach_;
  if (asked < count()) scene.is_asked = is_asked;
  const size_t old =
      learn(finder_.find(scene, {config_.layer_distance_m, config_.barrier_distance_m,
                                 config_.distance_m + kOutside}),
            is_asked);
  measure(x, old);
  is_known_ = true;
  ++search_count_;
}

// Bounds the distances of pairs at x, of those that may matter soon by measuring them. The first
// `old` were measured at measured_at_, the others as they were found.
void ContactSearch::measure(const Eigen::VectorXd& x, size_t old) {
  constexpr double kSoon = 0.002;    // m, over the range
  constexpr double kWorth = 0.0002;  // m: if nothing has moved as much, bounds are good enough
  const Eigen::VectorXd move = moves(measured_at_, x);
  if (old == found_.pairs.size() && !(move.maxCoeff() > kWorth)) return;
  const Eigen::VectorXd fresh_move = moves(found_at_, x);
  for (size_t i = 0; i < found_.pairs.size(); ++i) {
    NearPair& pair = found_.pairs[i];
    pair.distance -= approach(pair, i < old ? move : fresh_move);
    if (pair.distance < range_of(pair) + kSoon)
      pair.distance = std::sqrt(squared_pair_distance(pair.kind, points_of(pair, x)));
  }
  measured_at_ = x;
}

// What was found takes the place of what is known of the vertices that were asked for. Returns how
// many pairs are still the old ones; the others follow.
size_t ContactSearch::learn(const PairFinder::Found& fresh, const std::vector<char>& is_asked) {
  std::vector<NearPair>& pairs = found_.pairs;
  pairs.erase(std::remove_if(pairs.begin(), pairs.end(),
                             [&](const NearPair& pair) {
                               return std::any_of(
                                   pair.vertices.begin(), pair.vertices.end(),
                                   [&](int v) { return v < count() && is_asked[v]; });
                             }),
              pairs.end());
  const size_t old = pairs.size();
  pairs.insert(pairs.end(), fresh.pairs.begin(), fresh.pairs.end());
  std::vector<int> start = {0}, faces;
  for (int v = 0; v < count(); ++v) {
    const PairFinder::Found& from = is_asked[v] ? fresh : found_;
    faces.insert(faces.end(), from.rest_faces.begin() + from.rest_start[v],
                 from.rest_faces.begin() + from.rest_start[v + 1]);
    start.push_back(static_cast<int>(faces.size()));
  }
  found_.rest_start = std::move(start);
  found_.rest_faces = std::move(faces);
  return old;
}

void ContactSearch::find_loose(const Eigen::VectorXd& x) {
  if (!may_cross_ && loose_at_ == x) return;
  loose_at_ = x;
  const bool has_moved_on = may_cross_;
  may_cross_ = false;
  std::vector<char> before = std::move(is_loose_);
  is_loose_.assign(count(), 0);
  cloth_tree_.refit(Eigen::Map<const Points3>(x.data(), count(), 3));
  for (const auto& [f, g] : intersecting_faces(cloth_tree_, body_.tree()))
    for (int k = 0; k < 3 && !body_.is_off()[g]; ++k) is_loose_[cloth_tree_.faces()(f, k)] = 1;
  std::vector<int> asked;
  for (int v = 0; v < count(); ++v) {
    if (is_loose_[v]) continue;
    const Vec<3> place = x.segment<3>(3 * v);
    const ClosestPoint nearest = body_.tree().closest(place, kDeep);
    if (nearest.face < 0 || body_.share_on(nearest.face, nearest.barycentric) == 0) continue;
    if (body_.normal(nearest.face, nearest.barycentric).dot(place - nearest.point) < 0)
      asked.push_back(v);
  }
  Points3 queries(asked.size(), 3);
  for (size_t i = 0; i < asked.size(); ++i) queries.row(i) = x.segment<3>(3 * asked[i]).transpose();
  const Eigen::VectorXd winding = winding_numbers(body_.tree(), queries);
  for (size_t i = 0; i < asked.size(); ++i) is_loose_[asked[i]] = winding[i] > 0.5;
  // What comes free stays so until the body moves on, and no more comes loose: what is pulled out
  // would draw in what hangs on it, and that again, without end.
  for (int v = 0; v < count() && !has_moved_on; ++v) is_loose_[v] &= before[v];
  has_loose_ = std::find(is_loose_.begin(), is_loose_.end(), 1) != is_loose_.end();
  if (is_loose_ != before) is_known_ = false;
}

std::vector<int> ContactSearch::pairs_at(const std::vector<int>& place) const {
  std::vector<int> result;
  for (size_t i = 0; i < found_.pairs.size(); ++i)
    for (const int v : found_.pairs[i].vertices)
      if (v < count() && place[v] >= 0) {
        result.push_back(static_cast<int>(i));
        break;
      }
  return result;
}

double ContactSearch::range_of(const NearPair& pair) const {
  const bool is_with_body =
      *std::max_element(pair.vertices.begin(), pair.vertices.end()) >= count();
  return is_with_body ? config_.barrier_distance_m : config_.layer_distance_m;
}

PairPoints ContactSearch::points_of(const NearPair& pair, const Eigen::VectorXd& x) const {
  PairPoints points;
  for (int k = 0; k < 4; ++k) {
    const int v = pair.vertices[k];
    points.col(k) = v < count() ? Vec<3>(x.segment<3>(3 * v))
                                : Vec<3>(body_.vertices().row(v - count()).transpose());
  }
  return points;
}

// The nearest body face supports the vertex; where another part of the body faces it from the other
// side, as in an armpit, that part does too.
void ContactSearch::find_supports(int vertex, const Vec<3>& x, Supports& found) const {
  struct Support {
    int face = -1;
    Vec<3> barycentric, point, normal;
    double distance;
  };
  const int begin = found_.rest_start[vertex], end = found_.rest_start[vertex + 1];
  if (begin == end) return;
  const Points3& vertices = body_.vertices();
  const auto support = [&](int face) {
    const Vec<3> a = vertices.row(body_.faces()(face, 0)), b = vertices.row(body_.faces()(face, 1)),
                 c = vertices.row(body_.faces()(face, 2));
    Support s;
    s.face = face;
    s.barycentric = closest_on_triangle(x, a, b, c);
    s.point = s.barycentric[0] * a + s.barycentric[1] * b + s.barycentric[2] * c;
    s.distance = (x - s.point).norm();
    s.normal = (b - a).cross(c - a).normalized();
    return s;
  };
  std::array<Support, 2> supports;
  std::vector<Support> all;
  for (int i = begin; i < end; ++i) {
    all.push_back(support(found_.rest_faces[i]));
    if (supports[0].face < 0 || all.back().distance < supports[0].distance)
      supports[0] = all.back();
  }
  const double on = body_.share_on(supports[0].face, supports[0].barycentric);
  if (on == 0) return;
  constexpr double kOpposite = -0.5, kAlong = 0;  // cosine of the two normals
  for (const Support& s : all)
    if (!body_.is_off()[s.face] && s.normal.dot(supports[0].normal) < kAlong &&
        s.normal.dot(x - s.point) > 0 &&
        (supports[1].face < 0 || s.distance < supports[1].distance))
      supports[1] = s;
  for (const Support& s : supports) {
    if (s.face < 0) continue;
    const double share =
        &s == &supports[0]
            ? on
            : smoothstep((s.normal.dot(supports[0].normal) - kAlong) / (kOpposite - kAlong));
    Contact contact{vertex,
                    s.face,
                    s.barycentric,
                    body_.normal(s.face, s.barycentric),
                    config_.distance_m,
                    share * config_.stiffness_N_per_m3 * areas_[vertex],
                    x,
                    0,
                    false};
    contact.room = (contact_field(contact, body_, x, 0).phi - contact.distance) / kSteep;
    found.contacts.push_back(contact);
  }
}

void ContactSearch::Supports::begin_at(const Vec<3>& x) {
  at = x;
  contacts.clear();
  leader = 0;
  normal.setZero();
}

void ContactSearch::Supports::note_change_from(int old_face) {
  if (face() == old_face) return;
  if (face() == before) still *= 2;
  before = old_face;
}

void ContactSearch::add_contacts(int vertex, const Vec<3>& x, Anchor& anchor, Touching& touching) {
  Supports& seen = supports_[vertex];
  const bool is_loose = is_loose_[vertex];
  if (seen.contacts.empty() || seen.contacts[0].is_flat != is_loose ||
      (x - seen.at).squaredNorm() > seen.still * seen.still) {
    const int face = seen.face();
    seen.begin_at(x);
    is_loose ? find_pull(vertex, x, seen) : find_supports(vertex, x, seen);
    seen.note_change_from(face);
  }
  if (is_loose) {
    touching.contacts.insert(touching.contacts.end(), seen.contacts.begin(), seen.contacts.end());
    return;
  }
  std::array<double, 2> force = {0, 0};
  std::array<Vec<3>, 2> direction;
  for (size_t i = 0; i < seen.contacts.size(); ++i) {
    touching.contacts.push_back(seen.contacts[i]);
    Contact& contact = touching.contacts.back();
    if (is_clear(contact, x)) continue;
    contact.known = contact_field(contact, body_, x, 2);  // the forces will ask for it
    contact.known_at = x;
    force[i] = normal_force(contact, contact.known.phi);
    direction[i] = contact.known.gradient.normalized();
  }
  if (!(force[0] + force[1] > 0)) return;
  const bool has_lost = force[1 - seen.leader] > seen.stronger * force[seen.leader];
  if (has_lost) {
    seen.leader = 1 - seen.leader;
    seen.stronger *= 2;
  }
  const Vec<3>& normal = direction[seen.leader];
  const double limit = friction_ * (force[0] + force[1]);
  if (has_lost || follow_ == 1 || seen.normal.isZero(0)) {
    seen.normal = normal;
    seen.limit = limit;
  } else {
    seen.normal = (seen.normal + follow_ * (normal - seen.normal)).normalized();
    seen.limit += follow_ * (limit - seen.limit);
  }
  if (anchor.face < 0) anchor = anchor_below(x, seen.normal);
  if (anchor.face < 0) return;  // too deep inside
  touching.frictions.push_back({vertex, body_.point(anchor.face, anchor.barycentric), seen.normal,
                                seen.limit, config_.stick_N_per_m3 * areas_[vertex]});
}

// The smooth surface does not reach deep inside: loose vertices are pulled to planes.
void ContactSearch::find_pull(int vertex, const Vec<3>& x, Supports& found) const {
  const ClosestPoint nearest = body_.tree().closest(x, kDeep);
  if (nearest.face < 0 || body_.is_off()[nearest.face]) return;
  found.contacts.push_back(
      {vertex, nearest.face, nearest.barycentric, body_.normal(nearest.face, nearest.barycentric),
       kLift * config_.distance_m, config_.stiffness_N_per_m3 * areas_[vertex], x, 0, true});
}

// Where the body lies straight under a place, against the smooth normal there. Its nearest point
// will not do: seen from 3 mm above, the facets' own normals put it aside by as much as a vertex
// slips.
Anchor ContactSearch::anchor_below(const Vec<3>& place, const Vec<3>& normal) const {
  constexpr int kMostTries = 8;
  constexpr double kAside = 1e-7;  // m
  Anchor anchor;
  Vec<3> near = place;
  for (int i = 0; i < kMostTries; ++i) {
    const ClosestPoint closest = body_.tree().closest(near, 4 * config_.distance_m);
    if (closest.face < 0) break;
    anchor = {closest.face, closest.barycentric};
    const Vec<3> off = closest.point - place;
    const Vec<3> aside = off - normal * normal.dot(off);
    if (aside.norm() < kAside) break;
    near = closest.point - aside;
  }
  return anchor;
}

Touching ContactSearch::touching(const std::vector<int>& vertices, const Eigen::VectorXd& x,
                                 std::vector<Anchor>& anchors) {
  Touching touching;
  touching.body = &body_;
  touching.contacts.reserve(vertices.size());
  touching.frictions.reserve(vertices.size());
  for (int v : vertices) add_contacts(v, x.segment<3>(3 * v), anchors[v], touching);
  return touching;
}

template <typename Action>
void ContactSearch::for_each_barrier(const std::vector<int>& pairs, const Eigen::VectorXd& x,
                                     Action action) const {
  const Eigen::VectorXd move = moves(measured_at_, x);
  const double near = largest_range() + 2 * move.maxCoeff();
  for (const int i : pairs) {
    const NearPair& pair = found_.pairs[i];
    if (pair.distance >= near) continue;
    const double range = range_of(pair);
    if (pair.distance - approach(pair, move) >= range) continue;
    const PairPoints points = points_of(pair, x);
    if (squared_pair_distance(pair.kind, points) >= range * range) continue;
    action(Barrier{pair.vertices, pair.kind, range, config_.barrier_Pa * mean_area_,
                   kParallel * mean_area_ * mean_area_},
           points);
  }
}

double ContactSearch::barrier_energy(const std::vector<int>& pairs,
                                     const Eigen::VectorXd& x) const {
  double energy = 0;
  for_each_barrier(pairs, x, [&](const Barrier& barrier, const PairPoints& points) {
    energy += barrier_term(barrier, points, Order::kValue).value;
  });
  return energy;
}

std::vector<ActiveBarrier> ContactSearch::barriers(const std::vector<int>& pairs,
                                                   const Eigen::VectorXd& x, Order order) const {
  std::vector<ActiveBarrier> result;
  for_each_barrier(pairs, x, [&](const Barrier& barrier, const PairPoints& points) {
    result.push_back({barrier, barrier_term(barrier, points, order)});
  });
  return result;
}

double ContactSearch::free_share(const std::vector<int>& pairs, const Eigen::VectorXd& x,
                                 const Eigen::VectorXd& step) const {
  const Eigen::VectorXd reach = moves(measured_at_, x) + moves(x, x + step);
  const double near = largest_range() + 2 * reach.maxCoeff();
  double share = 1;
  for (const int i : pairs) {
    const NearPair& pair = found_.pairs[i];
    if (pair.distance >= near) continue;
    if (pair.distance - approach(pair, reach) >= range_of(pair) / 2) continue;
    PairPoints motion = PairPoints::Zero();
    for (int k = 0; k < 4; ++k)
      if (pair.vertices[k] < count()) motion.col(k) = share * step.segment<3>(3 * pair.vertices[k]);
    share *= free_motion(pair.kind, points_of(pair, x), motion, kKeep);
  }
  return share;
}

namespace {

// Where the features of a pair would meet: what the ends of their motions must keep apart.
struct Meeting {
  std::array<int, 4> vertices;
  Vec<4> weights;  // of the vertices in the features' difference,
  Vec<3> normal;   // the part of it along which
  double least;    // must not fall below this, m
  double when;     // share of the motion
};

Meeting meeting_of(const NearPair& pair, const PairPoints& points, const PairPoints& motion,
                   double when) {
  constexpr double kLeft = 0.5;  // of what is between them
  const PairDistance met = pair_distance(pair.kind, points + when * motion);
  const Vec<3> normal = met.difference.normalized();
  const double between = std::min(std::sqrt(squared_pair_distance(pair.kind, points)),
                                  normal.dot(points * met.weights));
  return {pair.vertices, met.weights, normal, kLeft * std::max(0.0, between), when};
}

}  // namespace

// Each pair that would meet gives a plane between its features; the ends of the cloth's motions are
// projected to the right sides of all planes, one after another (Mueller et al. 2007, "Position
// based dynamics", section 3.5), and pairs are looked for again.
double ContactSearch::make_way(const Scene& still, const Points3& body_motion,
                               Eigen::VectorXd& step) {
  constexpr int kMostPasses = 8, kSweeps = 20;
  Scene scene = still;
  scene.reach.setConstant(kApart);
  scene.motion.resize(still.positions.rows(), 3);
  scene.motion.topRows(count()) = Eigen::Map<const Points3>(step.data(), count(), 3);
  scene.motion.bottomRows(body_motion.rows()) = body_motion;
  std::vector<Meeting> meetings;
  double best = 0;
  for (int pass = 0;; ++pass) {
    double share = 1;
    for (const NearPair& pair : finder_.find(scene, {0, 0, 0}).pairs) {
      PairPoints points, motion;
      for (int k = 0; k < 4; ++k) {
        points.col(k) = scene.positions.row(pair.vertices[k]).transpose();
        motion.col(k) = scene.motion.row(pair.vertices[k]).transpose();
      }
      const double free = free_motion(pair.kind, points, motion, kKeep);
      if (free == 1) continue;
      share = std::min(share, free);
      meetings.push_back(meeting_of(pair, points, motion, free));
    }
    if (share > best) {
      best = share;
      step = Eigen::Map<const Eigen::VectorXd>(scene.motion.data(), 3 * count());
    }
    if (share == 1 || pass == kMostPasses) return best;
    std::stable_sort(meetings.begin(), meetings.end(),
                     [](const Meeting& a, const Meeting& b) { return a.when < b.when; });
    for (int sweep = 0; sweep < kSweeps; ++sweep)
      for (const Meeting& meeting : meetings) {
        double apart = 0, weight = 0;
        for (int k = 0; k < 4; ++k) {
          const int v = meeting.vertices[k];
          apart +=
              meeting.weights[k] * meeting.normal.dot(scene.positions.row(v) + scene.motion.row(v));
          if (v < count()) weight += meeting.weights[k] * meeting.weights[k];
        }
        if (apart >= meeting.least || weight == 0) continue;
        for (int k = 0; k < 4; ++k)
          if (meeting.vertices[k] < count())
            scene.motion.row(meeting.vertices[k]) +=
                (meeting.least - apart) * meeting.weights[k] / weight * meeting.normal.transpose();
      }
  }
}

double ContactSearch::free_share_with_body(const Eigen::VectorXd& x, const Points3& body_next,
                                           const std::vector<char>& is_off_next,
                                           Eigen::VectorXd& step) {
  Scene scene = scene_at(x);
  for (size_t f = 0; f < is_off_next.size(); ++f) {
    scene.is_face_off[f] |= is_off_next[f];
    may_cross_ |= scene.is_face_off[f] != 0;
  }
  return make_way(scene, body_next - body_.vertices(), step);
}

double ContactSearch::free_share_without_body(const Eigen::VectorXd& x, Eigen::VectorXd& step) {
  may_cross_ = true;
  Scene scene = scene_at(x);
  scene.is_face_off.assign(body_.faces().rows(), 1);
  return make_way(scene, Points3::Zero(body_.vertices().rows(), 3), step);
}

void ContactSearch::settle_anchors(const Eigen::VectorXd& x, std::vector<Anchor>& anchors) {
  std::vector<Anchor> before = anchors, settled(anchors.size());
  std::vector<int> all(areas_.size());
  std::iota(all.begin(), all.end(), 0);
  const Touching touching = this->touching(all, x, before);
  for (const Friction& friction : touching.frictions) {
    const Vec<3> position = x.segment<3>(3 * friction.vertex);
    const Vec<3> from_anchor = position - friction.anchor;
    const Vec<3> slip = from_anchor - friction.normal * friction.normal.dot(from_anchor);
    const double length = slip.norm();
    const double slip_m = friction.limit / friction.stiffness;
    if (length <= slip_m) {
      settled[friction.vertex] = before[friction.vertex];
      continue;
    }
    const Anchor follow = anchor_below(position - slip * (slip_m / length), friction.normal);
    if (follow.face >= 0) settled[friction.vertex] = follow;
  }
  anchors = std::move(settled);
}

}  // namespace pleat::sim
