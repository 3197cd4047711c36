#include "garment/resample.h"

#include "core/error.h"
#include "core/proximity.h"

namespace pleat::garment {

PanelPlaces locate(const GarmentTopology& topology, const Eigen::Ref<const Points2>& uv) {
  Points3 flat = Points3::Zero(topology.uv.rows(), 3);
  flat.leftCols(2) = topology.uv;
  const SurfaceTree tree(flat, topology.panel_faces);
  PanelPlaces places{Eigen::VectorXi(uv.rows()), Points3(uv.rows(), 3)};
  for (Eigen::Index i = 0; i < uv.rows(); ++i) {
    if (!((uv.row(i).array() >= 0).all() && (uv.row(i).array() <= 1).all()))
      throw InputError("UV vertex " + std::to_string(i) + " lies outside of [0,1]^2");
    constexpr double kReach = 2;  // the layout is one wide
    const ClosestPoint closest = tree.closest({uv(i, 0), uv(i, 1), 0}, kReach);
    places.faces[i] = closest.face;
    places.barycentrics.row(i) = closest.barycentric.transpose();
  }
  return places;
}

Points3 resample(const GarmentTopology& from, const Eigen::Ref<const Points3>& values,
                 const GarmentTopology& to) {
  const PanelPlaces places = locate(from, to.uv);
  Points3 sums = Points3::Zero(to.vertex_count, 3);
  Eigen::VectorXd counts = Eigen::VectorXd::Zero(to.vertex_count);
  for (Eigen::Index i = 0; i < to.uv.rows(); ++i) {
    const auto corners = from.faces.row(places.faces[i]);
    for (int c = 0; c < 3; ++c)
      sums.row(to.sewn_vertex[i]) += places.barycentrics(i, c) * values.row(corners[c]);
    counts[to.sewn_vertex[i]] += 1;
  }
  return sums.array().colwise() / counts.array();
}

}  // namespace pleat::garment
