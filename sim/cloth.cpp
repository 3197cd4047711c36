#include "sim/cloth.h"

#include "core/mesh.h"

namespace pleat::sim {
namespace {

BlockMatrix constant_bending_hessian(const std::vector<Bending>& bendings, const BendingLaw& law,
                                     const std::vector<Membrane>& membranes, int vertex_count) {
  std::vector<std::pair<int, int>> coupled;
  for (const Bending& bending : bendings)
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < a; ++b) coupled.emplace_back(bending.vertices[a], bending.vertices[b]);
  for (const Membrane& membrane : membranes)
    for (int a = 0; a < 3; ++a)
      coupled.emplace_back(membrane.vertices[a], membrane.vertices[(a + 1) % 3]);
  BlockMatrix hessian = make_pattern(vertex_count, coupled);
  if (law.is_measured) return hessian;
  for (const Bending& bending : bendings) {
    const LocalEnergy<12> local = bending_energy(bending, law, Vec<12>::Zero(), Order::kHessian);
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < 4; ++b)
        hessian.block(hessian.find(bending.vertices[a], bending.vertices[b])) +=
            local.hessian.block<3, 3>(3 * a, 3 * b);
  }
  return hessian;
}

}  // namespace

Cloth make_cloth(const Faces& faces, const Faces& panel_faces,
                 const Eigen::Ref<const Points2>& panels, int vertex_count,
                 const garment::Fabric& fabric) {
  Cloth cloth;
  cloth.membrane_law = make_membrane_law(fabric);
  cloth.bending_law = make_bending_law(fabric);
  cloth.vertex_count = vertex_count;
  cloth.faces = faces;
  cloth.area = Eigen::VectorXd::Zero(vertex_count);
  const auto rest_corner = [&](int face, int corner) -> Vec<2> {
    return panels.row(panel_faces(face, corner)).transpose();
  };
  for (int f = 0; f < faces.rows(); ++f) {
    cloth.membranes.push_back(
        make_membrane({faces(f, 0), faces(f, 1), faces(f, 2)},
                      {rest_corner(f, 0), rest_corner(f, 1), rest_corner(f, 2)}));
    for (int c = 0; c < 3; ++c) cloth.area[faces(f, c)] += cloth.membranes.back().area / 3;
  }
  for (int v = 0; v < vertex_count; ++v) {
    cloth.weights.push_back({v, fabric.density_kg_per_m2 * cloth.area[v]});
  }
  cloth.weight_norm = fabric.density_kg_per_m2 * kGravity * cloth.area.norm();
  const auto corner_of = [&](int face, int vertex) {
    return faces(face, 0) == vertex ? 0 : faces(face, 1) == vertex ? 1 : 2;
  };
  for (const Edge& edge : edges(faces)) {
    if (edge.faces[1] < 0) continue;
    std::array<std::array<Vec<2>, 3>, 2> rest;
    for (int side = 0; side < 2; ++side) {
      const int face = edge.faces[side];
      rest[side] = {rest_corner(face, corner_of(face, edge.vertices[0])),
                    rest_corner(face, corner_of(face, edge.vertices[1])),
                    rest_corner(face, corner_of(face, edge.opposite[side]))};
    }
    cloth.bendings.push_back(
        make_bending({edge.vertices[0], edge.vertices[1], edge.opposite[0], edge.opposite[1]},
                     rest[0], rest[1]));
  }
  cloth.bending_hessian =
      constant_bending_hessian(cloth.bendings, cloth.bending_law, cloth.membranes, vertex_count);
  for (const Membrane& membrane : cloth.membranes) {
    std::array<int, 9> blocks;
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b)
        blocks[3 * a + b] = cloth.bending_hessian.find(membrane.vertices[a], membrane.vertices[b]);
    cloth.membrane_blocks.push_back(blocks);
  }
  cloth.membranes_of.resize(vertex_count);
  cloth.bendings_of.resize(vertex_count);
  for (size_t e = 0; e < cloth.membranes.size(); ++e)
    for (int v : cloth.membranes[e].vertices) cloth.membranes_of[v].push_back(static_cast<int>(e));
  for (size_t e = 0; e < cloth.bendings.size(); ++e)
    for (int v : cloth.bendings[e].vertices) cloth.bendings_of[v].push_back(static_cast<int>(e));
  if (!cloth.bending_law.is_measured) return cloth;
  for (const Bending& bending : cloth.bendings) {
    std::array<int, 16> blocks;
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < 4; ++b)
        blocks[4 * a + b] = cloth.bending_hessian.find(bending.vertices[a], bending.vertices[b]);
    cloth.bending_blocks.push_back(blocks);
  }
  return cloth;
}

}  // namespace pleat::sim
