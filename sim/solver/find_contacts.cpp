#include "sim/solver/find_contacts.h"

#include <cmath>

#include "core/error.h"

namespace pleat::sim {

void validate(const ContactConfig& config) {
  if (!(config.distance_m > 0 && config.distance_m <= 0.02))
    throw InputError("contact.distance_m must lie in (0, 0.02]");
  if (!(config.stiffness_N_per_m3 > 0)) throw InputError("contact.stiffness_N_per_m3 must be > 0");
  if (!(config.slip_m > 0)) throw InputError("contact.slip_m must be > 0");
  if (!(config.search_depth_m > config.distance_m))
    throw InputError("contact.search_depth_m must be > contact.distance_m");
}

ContactSearch::ContactSearch(const Cloth& cloth, const BodyCollider& collider,
                             const ContactConfig& config, double friction)
    : cloth_(cloth),
      collider_(collider),
      config_(config),
      friction_(friction),
      asked_at_(Points3::Zero(cloth.vertex_count, 3)),
      clearance_(Eigen::VectorXd::Zero(cloth.vertex_count)) {}

Touching ContactSearch::find(const Eigen::VectorXd& x, std::vector<Anchor>& anchors) {
  Touching touching;
  for (int v = 0; v < cloth_.vertex_count; ++v) {
    const Vec<3> position = x.segment<3>(3 * v);
    const double moved = (position - asked_at_.row(v).transpose()).norm();
    if (clearance_[v] - moved > config_.distance_m) continue;
    const ClosestPoint closest =
        collider_.tree().closest(position, config_.search_depth_m, collider_.is_active());
    asked_at_.row(v) = position.transpose();
    clearance_[v] = closest.face < 0 ? config_.search_depth_m : std::sqrt(closest.squared_distance);
    if (closest.face < 0) continue;
    const Vec<3> normal = collider_.normal(closest.face, closest.barycentric);
    const double gap = normal.dot(position - closest.point);
    // Outside, the tangent plane may only understate the distance; what is farther than d is no
    // contact.
    if (gap >= config_.distance_m || (gap > 0 && clearance_[v] >= config_.distance_m)) continue;
    Contact contact{v,
                    closest.face,
                    closest.barycentric,
                    closest.point,
                    normal,
                    config_.distance_m,
                    config_.stiffness_N_per_m3 * cloth_.area[v]};
    const double force = normal_force(contact, position);
    touching.contacts.push_back(contact);
    if (anchors[v].face < 0) anchors[v] = {closest.face, closest.barycentric};
    touching.frictions.push_back({v, collider_.point(anchors[v].face, anchors[v].barycentric),
                                  normal, friction_ * force, config_.slip_m});
    if (gap < 0) clearance_[v] = 0;  // inside: ask every time
  }
  return touching;
}

void settle_anchors(const BodyCollider& collider, const Touching& touching,
                    const Eigen::VectorXd& x, const ContactConfig& config,
                    std::vector<Anchor>& anchors) {
  std::vector<Anchor> settled(anchors.size());
  for (size_t i = 0; i < touching.contacts.size(); ++i) {
    const Contact& contact = touching.contacts[i];
    const Friction& friction = touching.frictions[i];
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
