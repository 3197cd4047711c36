#include "sim/certificate.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/mesh_quality.h"
#include "core/proximity.h"

namespace pleat::sim {
namespace {

constexpr double kGapSearch = 0.05;  // m: gaps are measured up to here

// Smallest signed distance to the body, but of vertices whose nearest face is switched off or next
// to one that is: which side is inside cannot be told there. Where the blended
// normal does not tell clearly that a place is outside, as between folds of skin, where it
// may lean either way, the pseudonormal does.
double min_gap(const Eigen::Ref<const Points3>& positions, const BodyCollider& body) {
  constexpr double kClear = 0.5;  // cosine of the normal and the way from the body to the place
  double smallest = kGapSearch;
  std::vector<int> unclear;
  for (Eigen::Index v = 0; v < positions.rows(); ++v) {
    const Vec<3> x = positions.row(v).transpose();
    const ClosestPoint nearest = body.tree().closest(x, kGapSearch);
    if (nearest.face < 0 || !body.is_clear(nearest.face)) continue;
    const double distance = std::sqrt(nearest.squared_distance);
    const Vec<3> normal = body.normal(nearest.face, nearest.barycentric);
    if (normal.dot(x - nearest.point) > kClear * distance)
      smallest = std::min(smallest, distance);
    else
      unclear.push_back(static_cast<int>(v));
  }
  if (unclear.empty()) return smallest;
  const Points3 places = positions(unclear, Eigen::all);
  return std::min(smallest, signed_distances(body.tree(), places, kGapSearch).minCoeff());
}

// Faces of the posed body that are not the collider's.
std::vector<char> faces_that_gave_way(const SurfaceTree& posed, const BodyCollider& collider) {
  constexpr double kMoved = 1e-4;  // m
  std::vector<char> gave_way(collider.faces().rows());
  for (size_t f = 0; f < gave_way.size(); ++f) {
    gave_way[f] = !collider.is_clear(static_cast<int>(f));
    for (int c = 0; c < 3; ++c) {
      const int v = collider.faces()(f, c);
      gave_way[f] |= (collider.vertices().row(v) - posed.vertices().row(v)).norm() > kMoved;
    }
  }
  return gave_way;
}

std::string reason_to_reject(const garment::Certificate& c, const AcceptConfig& accept) {
  if (c.self_intersections > 0) return "crosses itself";
  if (is_in_body(c, accept))
    return c.body_intersections > 0 ? "crosses the body" : "inside the body";
  if (!(c.residual <= accept.residual)) return "not settled";
  if (!c.is_stable) return "not stable";
  if (!(c.strain_95 <= accept.strain_95)) return "too much strain";
  return "";
}

}  // namespace

void validate(const AcceptConfig& config) {
  if (!(config.residual > 0)) throw InputError("accept.residual must be > 0");
  if (!(config.strain_95 > 0)) throw InputError("accept.strain_95 must be > 0");
}

bool is_in_body(const garment::Certificate& certificate, const AcceptConfig& accept) {
  return certificate.body_intersections > 0 || !(certificate.min_gap_m >= accept.min_gap_m);
}

garment::Certificate certify(const Eigen::Ref<const Points3>& positions, const Faces& faces,
                             const Faces& panel_faces, const Eigen::Ref<const Points2>& panels,
                             const SurfaceTree& posed, const BodyCollider& collider,
                             const NewtonResult& solved, const AcceptConfig& accept) {
  const SurfaceTree cloth(positions, faces);
  const Strain stretch = strain(positions, faces, panels, panel_faces);
  garment::Certificate certificate;
  certificate.residual = solved.residual;
  certificate.min_gap_m = min_gap(positions, collider);
  certificate.max_strain = stretch.max;
  certificate.strain_95 = stretch.percentile_95;
  certificate.is_stable = solved.is_stable;
  for (const auto& [cloth_face, body_face] : intersecting_faces(cloth, collider.tree()))
    certificate.body_intersections += collider.is_clear(body_face);
  const std::vector<char> gave_way = faces_that_gave_way(posed, collider);
  for (const auto& [cloth_face, body_face] : intersecting_faces(cloth, posed))
    certificate.overlap_intersections += gave_way[body_face];
  certificate.self_intersections = static_cast<int>(self_intersecting_faces(cloth).size());
  certificate.reason = reason_to_reject(certificate, accept);
  certificate.is_accepted = certificate.reason.empty();
  return certificate;
}

}  // namespace pleat::sim
