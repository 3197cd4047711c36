#include "sim/certificate.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/mesh_quality.h"

namespace pleat::sim {
namespace {

constexpr double kGapSearch = 0.05;  // m: gaps are measured up to here

// Smallest signed distance to the body, but of vertices whose nearest face overlaps another part.
double min_gap(const Eigen::Ref<const Points3>& positions, const BodyCollider& collider) {
  double smallest = kGapSearch;
  for (Eigen::Index v = 0; v < positions.rows(); ++v) {
    const Vec<3> x = positions.row(v).transpose();
    const ClosestPoint closest = collider.tree().closest(x, kGapSearch);
    if (closest.face < 0 || collider.is_near_overlap()[closest.face]) continue;
    const double side = collider.normal(closest.face, closest.barycentric).dot(x - closest.point);
    smallest = std::min(smallest, std::copysign(std::sqrt(closest.squared_distance), side));
  }
  return smallest;
}

int count_body_intersections(const SurfaceTree& cloth, const BodyCollider& collider) {
  std::vector<int> crossing;
  for (const auto& [cloth_face, body_face] : intersecting_faces(cloth, collider.tree()))
    if (!collider.is_near_overlap()[body_face]) crossing.push_back(cloth_face);
  std::sort(crossing.begin(), crossing.end());
  return static_cast<int>(std::unique(crossing.begin(), crossing.end()) - crossing.begin());
}

std::string reason_to_reject(const garment::Certificate& c, const AcceptConfig& accept) {
  if (!(c.residual <= accept.residual)) return "not settled";
  if (!(c.strain_95 <= accept.strain_95)) return "too much strain";
  if (!(c.min_gap_m >= accept.min_gap_m)) return "inside the body";
  if (c.body_intersections > accept.body_intersections) return "crosses the body";
  return "";
}

}  // namespace

void validate(const AcceptConfig& config) {
  if (!(config.residual > 0)) throw InputError("accept.residual must be > 0");
  if (!(config.strain_95 > 0)) throw InputError("accept.strain_95 must be > 0");
  if (config.body_intersections < 0) throw InputError("accept.body_intersections must be >= 0");
}

garment::Certificate certify(const Eigen::Ref<const Points3>& positions, const Faces& faces,
                             const Faces& panel_faces, const Eigen::Ref<const Points2>& panels,
                             const BodyCollider& collider, const NewtonResult& solved,
                             const AcceptConfig& accept) {
  const SurfaceTree cloth(positions, faces);
  const Strain stretch = strain(positions, faces, panels, panel_faces);
  garment::Certificate certificate;
  certificate.residual = solved.residual;
  certificate.min_gap_m = min_gap(positions, collider);
  certificate.max_strain = stretch.max;
  certificate.strain_95 = stretch.percentile_95;
  certificate.body_intersections = count_body_intersections(cloth, collider);
  certificate.self_intersections = static_cast<int>(self_intersecting_faces(cloth).size());
  certificate.reason = reason_to_reject(certificate, accept);
  certificate.is_accepted = certificate.reason.empty();
  return certificate;
}

}  // namespace pleat::sim
