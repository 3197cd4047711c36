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

Points3 sew(const GarmentTopology& topology, const Eigen::Ref<const Points3>& panel_values) {
  Points3 sewn = Points3::Zero(topology.vertex_count, 3);
  Eigen::VectorXd count = Eigen::VectorXd::Zero(topology.vertex_count);
  for (Eigen::Index i = 0; i < panel_values.rows(); ++i) {
    sewn.row(topology.sewn_vertex[i]) += panel_values.row(i);
    count[topology.sewn_vertex[i]] += 1;
  }
  return sewn.array().colwise() / count.array();
}

Points3 resample(const GarmentTopology& from, const Eigen::Ref<const Points3>& values,
                 const GarmentTopology& to) {
  const PanelPlaces places = locate(from, to.uv);
  Points3 panel_values = Points3::Zero(to.uv.rows(), 3);
  for (Eigen::Index i = 0; i < to.uv.rows(); ++i)
    for (int c = 0; c < 3; ++c)
      panel_values.row(i) += places.barycentrics(i, c) * values.row(from.faces(places.faces[i], c));
  return sew(to, panel_values);
}

}  // namespace pleat::garment
