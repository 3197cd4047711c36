#include "sim/solver/assemble.h"

#include "core/mesh.h"

namespace pleat::sim {
namespace {

template <size_t N>
Vec<3 * N> gather(const Eigen::VectorXd& x, const std::array<int, N>& vertices) {
  Vec<3 * N> stacked;
  for (size_t a = 0; a < N; ++a) stacked.template segment<3>(3 * a) = x.segment<3>(3 * vertices[a]);
  return stacked;
}

template <size_t N, int M>
void add_gradient(const LocalEnergy<M>& element, const std::array<int, N>& vertices,
                  System& system) {
  for (size_t a = 0; a < N; ++a)
    system.gradient.segment<3>(3 * vertices[a]) += element.gradient.template segment<3>(3 * a);
}

// A force on single vertices: its Hessian is a block on the diagonal.
template <typename Element, typename Energy>
void add_vertex_forces(const std::vector<Element>& elements, Energy energy,
                       const Eigen::VectorXd& x, Order order, System& system) {
  for (const Element& element : elements) {
    const LocalEnergy<3> local = energy(element, x.segment<3>(3 * element.vertex), order);
    system.energy += local.value;
    if (order >= Order::kGradient) system.gradient.segment<3>(3 * element.vertex) += local.gradient;
    if (order >= Order::kProjectedHessian)
      system.hessian.block(system.hessian.diagonal[element.vertex]) += local.hessian;
  }
}

void add_membranes(const Cloth& cloth, const Eigen::VectorXd& x, Order order, System& system) {
  for (size_t e = 0; e < cloth.membranes.size(); ++e) {
    const Membrane& membrane = cloth.membranes[e];
    const LocalEnergy<9> local =
        membrane_energy(membrane, cloth.membrane_law, gather(x, membrane.vertices), order);
    system.energy += local.value;
    if (order >= Order::kGradient) add_gradient(local, membrane.vertices, system);
    if (order < Order::kProjectedHessian) continue;
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) {
        double* block = system.hessian.values.data() + 9 * cloth.membrane_blocks[e][3 * a + b];
        for (int r = 0; r < 3; ++r)  // rows of a symmetric matrix are its columns, which lie in one
          for (int c = 0; c < 3; ++c) block[3 * r + c] += local.hessian(3 * b + c, 3 * a + r);
      }
  }
}

void add_bendings(const Cloth& cloth, const Eigen::VectorXd& x, Order order, System& system) {
  // A constant law's Hessian is in the system already.
  const bool is_measured = cloth.bending_law.is_measured;
  const Order needed = is_measured ? order : std::min(order, Order::kGradient);
  for (size_t e = 0; e < cloth.bendings.size(); ++e) {
    const Bending& bending = cloth.bendings[e];
    const Vec<3> jump = normal_jump(bending, gather(x, bending.vertices));
    const LocalEnergy<3> local = jump_energy(bending, cloth.bending_law, jump, needed);
    system.energy += local.value;
    if (needed < Order::kGradient) continue;
    for (int a = 0; a < 4; ++a)
      system.gradient.segment<3>(3 * bending.vertices[a]) += bending.stencil[a] * local.gradient;
    if (needed < Order::kProjectedHessian) continue;
    const Eigen::Map<const Vec<9>> numbers(local.hessian.data());
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < 4; ++b) {
        const int block = cloth.bending_blocks[e][4 * a + b];
        Eigen::Map<Vec<9>>(system.hessian.values.data() + 9 * block) +=
            bending.stencil[a] * bending.stencil[b] * numbers;
      }
  }
}

// The pattern of the whole Hessian, with the part of it that no step changes.
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
    cloth.total_weight += cloth.weights.back().mass * kGravity;
  }
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

void assemble(const Cloth& cloth, const Touching& touching, const Eigen::VectorXd& x, Order order,
              System& system) {
  system.energy = 0;
  if (order >= Order::kGradient) system.gradient.setZero(x.size());
  if (order >= Order::kProjectedHessian) system.hessian = cloth.bending_hessian;
  add_membranes(cloth, x, order, system);
  add_bendings(cloth, x, order, system);
  add_vertex_forces(cloth.weights, weight_energy, x, order, system);
  add_vertex_forces(touching.contacts, contact_energy, x, order, system);
  add_vertex_forces(touching.frictions, friction_energy, x, order, system);
}

}  // namespace pleat::sim
