#include "sim/solver/find_contacts.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace pleat::sim {

void validate(const ContactConfig& config) {
  if (!(config.distance_m > 0 && config.distance_m <= 0.02))
    throw InputError("contact.distance_m must lie in (0, 0.02]");
  if (!(config.stiffness_N_per_m3 > 0)) throw InputError("contact.stiffness_N_per_m3 must be > 0");
  if (!(config.slip_m > 0)) throw InputError("contact.slip_m must be > 0");
  if (!(config.search_depth_m > 2 * config.distance_m))
    throw InputError("contact.search_depth_m must be > 2 contact.distance_m");
}

ContactSearch::ContactSearch(const Cloth& cloth, const BodyCollider& collider,
                             const ContactConfig& config, double friction, double reach_m)
    : cloth_(cloth),
      collider_(collider),
      config_(config),
      friction_(friction),
      reach_(config.distance_m + reach_m),
      asked_at_(Points3::Zero(cloth.vertex_count, 3)),
      clearance_(Eigen::VectorXd::Zero(cloth.vertex_count)),
      contacts_(cloth.vertex_count) {}

// The plane at a closest point, and how far it speaks for the vertex: fully where the vertex lies
// above it, not at all where the point is on the rim of a part and the plane runs past the vertex.
ContactSearch::Candidate ContactSearch::candidate(int vertex, const Vec<3>& position,
                                                  const ClosestPoint& closest) const {
  constexpr double kNone = 0.5, kFull = 0.9;  // cosine between normal and direction to the vertex
  const Vec<3> normal = collider_.normal(closest.face, closest.barycentric);
  const double gap = normal.dot(position - closest.point);
  const double distance = std::sqrt(closest.squared_distance);
  const double t =
      distance > 0 ? std::clamp((std::abs(gap) / distance - kNone) / (kFull - kNone), 0.0, 1.0) : 1;
  return {{vertex, closest.face, closest.barycentric, closest.point, normal, config_.distance_m,
           config_.stiffness_N_per_m3 * cloth_.area[vertex]},
          t * t * (3 - 2 * t)};
}

// The part that the vertex sticks to comes first, else the nearest one. What the others leave of a
// full weight goes to the nearest, so that no vertex slips through a crease.
std::vector<Contact> ContactSearch::contacts_of(int vertex, const Vec<3>& position,
                                                const ClosestPoint& closest,
                                                const Anchor& anchor) const {
  const int nearest = collider_.part(closest.face);
  const int stuck = anchor.face < 0 ? nearest : collider_.part(anchor.face);
  std::vector<Candidate> candidates = {candidate(vertex, position, closest)};
  double others = 0;
  for (int p = 0; p < collider_.part_count(); ++p) {
    if (p == nearest) continue;
    const ClosestPoint other =
        collider_.tree().closest(position, reach_, collider_.is_active_in(p));
    if (other.face < 0) continue;
    const Candidate c = candidate(vertex, position, other);
    if (c.weight == 0) continue;
    others += c.weight;
    candidates.insert(p == stuck ? candidates.begin() : candidates.end(), c);
  }
  std::vector<Contact> contacts;
  for (Candidate& c : candidates) {
    if (collider_.part(c.contact.body_face) == nearest) c.weight = std::max(c.weight, 1 - others);
    if (c.weight <= 0) continue;
    c.contact.stiffness *= c.weight;
    contacts.push_back(c.contact);
  }
  return contacts;
}

Touching ContactSearch::find(const Eigen::VectorXd& x, std::vector<Anchor>& anchors) {
  // Where closest points jump between two places, Newton's method would cycle: after a while planes
  // stay with a vertex until it moves farther, the longer the farther.
  constexpr int kPatience = 30;
  constexpr double kStay = 3e-5;  // m
  const double stay = kStay * std::max(0, ++finds_ - kPatience);
  Touching touching;
  std::vector<Contact> further;
  for (int v = 0; v < cloth_.vertex_count; ++v) {
    const Vec<3> position = x.segment<3>(3 * v);
    const double moved = (position - asked_at_.row(v).transpose()).norm();
    if (clearance_[v] - moved > reach_) continue;
    if (contacts_[v].empty() || moved >= stay) {
      const ClosestPoint closest =
          collider_.tree().closest(position, config_.search_depth_m, collider_.is_active());
      asked_at_.row(v) = position.transpose();
      contacts_[v].clear();
      clearance_[v] =
          closest.face < 0 ? config_.search_depth_m : std::sqrt(closest.squared_distance);
      if (closest.face < 0 || (clearance_[v] > reach_ && is_outside(position, closest))) continue;
      if (!is_outside(position, closest)) clearance_[v] = 0;  // ask every time
      contacts_[v] = contacts_of(v, position, closest, anchors[v]);
    }
    if (contacts_[v].empty()) continue;
    const Contact& first = contacts_[v].front();
    const double force = normal_force(first, position);
    if (force > 0 && anchors[v].face < 0) anchors[v] = {first.body_face, first.barycentric};
    const Vec<3> anchor =
        force > 0 ? collider_.point(anchors[v].face, anchors[v].barycentric) : first.point;
    touching.contacts.push_back(first);
    touching.frictions.push_back({v, anchor, first.normal, friction_ * force, config_.slip_m});
    further.insert(further.end(), contacts_[v].begin() + 1, contacts_[v].end());
  }
  touching.contacts.insert(touching.contacts.end(), further.begin(), further.end());
  return touching;
}

bool ContactSearch::is_outside(const Vec<3>& position, const ClosestPoint& closest) const {
  return collider_.normal(closest.face, closest.barycentric).dot(position - closest.point) >= 0;
}

void settle_anchors(const BodyCollider& collider, const Touching& touching,
                    const Eigen::VectorXd& x, const ContactConfig& config,
                    std::vector<Anchor>& anchors) {
  std::vector<Anchor> settled(anchors.size());
  for (size_t i = 0; i < touching.frictions.size(); ++i) {
    const Contact& contact = touching.contacts[i];
    const Friction& friction = touching.frictions[i];
    if (friction.limit == 0) continue;
    const Vec<3> position = x.segment<3>(3 * contact.vertex);
    const Vec<3> from_anchor = position - friction.anchor;
    const Vec<3> slip = from_anchor - friction.normal * friction.normal.dot(from_anchor);
    const double length = slip.norm();
    if (length <= config.slip_m) {
      settled[contact.vertex] = anchors[contact.vertex];
      continue;
    }
    const Vec<3> foot = position - contact.normal * contact.normal.dot(position - contact.point);
    const ClosestPoint follow = collider.tree().closest(
        foot - slip * (config.slip_m / length), config.search_depth_m, collider.is_active());
    if (follow.face >= 0) settled[contact.vertex] = {follow.face, follow.barycentric};
  }
  anchors = std::move(settled);
}

}  // namespace pleat::sim
