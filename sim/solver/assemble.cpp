#include "sim/solver/assemble.h"

#include <algorithm>
#include <numeric>
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

void add_membranes(const Cloth& cloth, const Region& region, const Eigen::VectorXd& x, Order order,
                   System& system) {
  for (const int e : region.membranes) {
    const Membrane& membrane = cloth.membranes[e];
    const LocalEnergy<9> local =
        membrane_energy(membrane, cloth.membrane_law, gather(x, membrane.vertices), order);
    system.energy += local.value;
    if (order >= Order::kGradient) add_gradient(local, membrane.vertices, system);
    if (order < Order::kProjectedHessian) continue;
    for (int a = 0; a < 3; ++a) {
      if (region.place[membrane.vertices[a]] < 0) continue;
      for (int b = 0; b < 3; ++b) {
        double* block = system.hessian.values.data() + 9 * cloth.membrane_blocks[e][3 * a + b];
        for (int r = 0; r < 3; ++r)  // rows of a symmetric matrix are its columns, which lie in one
          for (int c = 0; c < 3; ++c) block[3 * r + c] += local.hessian(3 * b + c, 3 * a + r);
      }
    }
  }
}

void add_bendings(const Cloth& cloth, const Region& region, const Eigen::VectorXd& x, Order order,
                  System& system) {
  // A constant law's Hessian is in the system already.
  const bool is_measured = cloth.bending_law.is_measured;
  const Order needed = is_measured ? order : std::min(order, Order::kGradient);
  for (const int e : region.bendings) {
    const Bending& bending = cloth.bendings[e];
    const Vec<3> jump = normal_jump(bending, gather(x, bending.vertices));
    const LocalEnergy<3> local = jump_energy(bending, cloth.bending_law, jump, needed);
    system.energy += local.value;
    if (needed < Order::kGradient) continue;
    for (int a = 0; a < 4; ++a)
      system.gradient.segment<3>(3 * bending.vertices[a]) += bending.stencil[a] * local.gradient;
    if (needed < Order::kProjectedHessian) continue;
    const Eigen::Map<const Vec<9>> numbers(local.hessian.data());
    for (int a = 0; a < 4; ++a) {
      if (region.place[bending.vertices[a]] < 0) continue;
      for (int b = 0; b < 4; ++b) {
        const int block = cloth.bending_blocks[e][4 * a + b];
        Eigen::Map<Vec<9>>(system.hessian.values.data() + 9 * block) +=
            bending.stencil[a] * bending.stencil[b] * numbers;
      }
    }
  }
}

}  // namespace

Region whole(const Cloth& cloth) {
  Region region;
  region.vertices.resize(cloth.vertex_count);
  std::iota(region.vertices.begin(), region.vertices.end(), 0);
  region.place = region.vertices;
  region.membranes.resize(cloth.membranes.size());
  std::iota(region.membranes.begin(), region.membranes.end(), 0);
  region.bendings.resize(cloth.bendings.size());
  std::iota(region.bendings.begin(), region.bendings.end(), 0);
  return region;
}

Region around(const Cloth& cloth, const std::vector<int>& seeds, int steps) {
  Region region;
  region.place.assign(cloth.vertex_count, -1);
  const BlockMatrix& pattern = cloth.bending_hessian;
  std::vector<int> front = seeds;
  for (int v : front) region.place[v] = 0;
  for (int step = 0; step < steps; ++step) {
    std::vector<int> next;
    for (int v : front)
      for (int k = pattern.row_start[v]; k < pattern.row_start[v + 1]; ++k)
        if (region.place[pattern.column[k]] < 0) {
          region.place[pattern.column[k]] = 0;
          next.push_back(pattern.column[k]);
        }
    front = std::move(next);
  }
  for (int v = 0; v < cloth.vertex_count; ++v)
    if (region.place[v] >= 0) {
      region.place[v] = static_cast<int>(region.vertices.size());
      region.vertices.push_back(v);
    }
  for (int v : region.vertices) {
    region.membranes.insert(region.membranes.end(), cloth.membranes_of[v].begin(),
                            cloth.membranes_of[v].end());
    region.bendings.insert(region.bendings.end(), cloth.bendings_of[v].begin(),
                           cloth.bendings_of[v].end());
  }
  for (std::vector<int>* list : {&region.membranes, &region.bendings}) {
    std::sort(list->begin(), list->end());
    list->erase(std::unique(list->begin(), list->end()), list->end());
  }
  return region;
}

void assemble(const Cloth& cloth, const Region& region, const Touching& touching,
              const std::vector<ActiveBarrier>& barriers, const Eigen::VectorXd& x, Order order,
              System& system) {
  system.energy = 0;
  if (order >= Order::kGradient) {
    if (system.gradient.size() != x.size()) system.gradient.setZero(x.size());
    for (int v : region.vertices) system.gradient.segment<3>(3 * v).setZero();
  }
  if (order >= Order::kProjectedHessian) {
    const BlockMatrix& constant = cloth.bending_hessian;
    if (system.hessian.rows() != constant.rows()) system.hessian = constant;
    for (int v : region.vertices)
      std::copy(constant.values.begin() + 9 * constant.row_start[v],
                constant.values.begin() + 9 * constant.row_start[v + 1],
                system.hessian.values.begin() + 9 * constant.row_start[v]);
  }
  add_membranes(cloth, region, x, order, system);
  add_bendings(cloth, region, x, order, system);
  for (int v : region.vertices) {
    const LocalEnergy<3> local =
        weight_energy(cloth.weights[v], x.segment<3>(3 * v), std::min(order, Order::kGradient));
    system.energy += local.value;
    if (order >= Order::kGradient) system.gradient.segment<3>(3 * v) += local.gradient;
  }
  const auto contact = [&](const Contact& element, const Vec<3>& at, Order o) {
    return contact_energy(element, *touching.body, at, o);
  };
  add_vertex_forces(touching.contacts, contact, x, order, system);
  add_vertex_forces(touching.frictions, friction_energy, x, order, system);
  for (const ActiveBarrier& barrier : barriers) {
    system.energy += barrier.term.value;
    if (order < Order::kGradient) continue;
    for (int k = 0; k < 4; ++k) {
      const int v = barrier.element.vertices[k];
      if (v < cloth.vertex_count)
        system.gradient.segment<3>(3 * v) += force_gradient(barrier.term, k);
    }
  }
  if (order >= Order::kGradient && !cloth.is_pinned.empty())
    for (int v : region.vertices)
      if (cloth.is_pinned[v]) system.gradient.segment<3>(3 * v).setZero();
}

}  // namespace pleat::sim
