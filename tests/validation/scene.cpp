#include "tests/validation/scene.h"

#include <cmath>
#include <cstdio>
#include <map>

#include "garment/fabric_file.h"
#include "tests/core/shapes.h"

namespace pleat::sim {

Sheet make_grid(const Vec<2>& size, int columns, int rows, Diagonal diagonal) {
  const int stride = columns + 1;
  Sheet sheet;
  sheet.rest.resize(stride * (rows + 1), 2);
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i <= columns; ++i)
      sheet.rest.row(j * stride + i) << size[0] * i / columns, size[1] * j / rows;
  sheet.faces = grid_faces(columns, rows, [&](int i, int j) {
    return diagonal == Diagonal::kAlternating ? (i + j) % 2 == 0 : diagonal == Diagonal::kRising;
  });
  return sheet;
}

Sheet make_lattice(double edge, int rows, int count) {
  std::vector<Vec<2>> points;
  std::vector<Vec<3>> faces;
  std::vector<int> first;
  for (int i = 0; i <= rows; ++i) {
    first.push_back(static_cast<int>(points.size()));
    const int short_by = i % 2;
    for (int j = 0; j <= count - short_by; ++j)
      points.emplace_back(i * edge * std::sqrt(3) / 2, (j + 0.5 * short_by) * edge);
  }
  for (int i = 0; i < rows; ++i) {
    const bool from_long = i % 2 == 0;
    const int wide = from_long ? first[i] : first[i + 1];
    const int narrow = from_long ? first[i + 1] : first[i];
    const auto add = [&](int a, int b, int c) {
      faces.emplace_back(a, from_long ? c : b, from_long ? b : c);
    };
    for (int j = 0; j < count; ++j) add(wide + j, wide + j + 1, narrow + j);
    for (int j = 0; j + 1 < count; ++j) add(narrow + j, wide + j + 1, narrow + j + 1);
  }
  Sheet sheet;
  sheet.rest.resize(points.size(), 2);
  sheet.faces.resize(faces.size(), 3);
  for (size_t v = 0; v < points.size(); ++v) sheet.rest.row(v) = points[v].transpose();
  for (size_t f = 0; f < faces.size(); ++f)
    sheet.faces.row(f) = faces[f].cast<int>().transpose();
  return sheet;
}

Eigen::VectorXd place(const Sheet& sheet, const std::function<Vec<3>(const Vec<2>&)>& where) {
  Eigen::VectorXd x(3 * sheet.rest.rows());
  for (Eigen::Index v = 0; v < sheet.rest.rows(); ++v)
    x.segment<3>(3 * v) = where(sheet.rest.row(v).transpose());
  return x;
}

Points3 as_rows(const Eigen::VectorXd& stacked) {
  return Eigen::Map<const Points3>(stacked.data(), stacked.size() / 3, 3);
}

Cloth make_cloth(const Sheet& sheet, const garment::Fabric& fabric) {
  return make_cloth(sheet.faces, sheet.faces, sheet.rest, static_cast<int>(sheet.rest.rows()),
                    fabric);
}

void pin(Cloth& cloth, const std::function<bool(int vertex)>& is_pinned) {
  cloth.is_pinned.resize(cloth.vertex_count);
  for (int v = 0; v < cloth.vertex_count; ++v) cloth.is_pinned[v] = is_pinned(v);
}

garment::Fabric shipped(const std::string& name) {
  garment::FabricConfig config;
  config.file = std::string(PLEAT_SOURCE_DIR) + "/configs/fabrics/" + name + ".json";
  complete(config);
  return middle_fabric(config);
}

TriangleMesh make_nobody() {
  TriangleMesh mesh;
  mesh.vertices.resize(4, 3);
  mesh.vertices << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
  mesh.vertices.array() += 100;
  mesh.faces.resize(4, 3);
  mesh.faces << 0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3;
  return mesh;
}

TriangleMesh make_box(const Vec<3>& size, double edge) {
  Eigen::Vector3i cells;
  for (int k = 0; k < 3; ++k) cells[k] = static_cast<int>(std::ceil(size[k] / edge - 1e-9));
  std::map<std::array<int, 3>, int> number;
  std::vector<std::array<int, 3>> corners, faces;
  const auto vertex = [&](const std::array<int, 3>& at) {
    const auto [place, is_new] = number.emplace(at, static_cast<int>(corners.size()));
    if (is_new) corners.push_back(at);
    return place->second;
  };
  for (int axis = 0; axis < 3; ++axis)
    for (const int side : {0, 1}) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      for (int i = 0; i < cells[u]; ++i)
        for (int j = 0; j < cells[v]; ++j) {
          const auto corner = [&](int di, int dj) {
            std::array<int, 3> at{};
            at[axis] = side * cells[axis];
            at[u] = i + di;
            at[v] = j + dj;
            return vertex(at);
          };
          const int a = corner(0, 0), b = corner(1, 0), c = corner(1, 1), d = corner(0, 1);
          const bool rises = (i + j) % 2 == 0;
          std::array<int, 3> one = rises ? std::array{a, b, c} : std::array{a, b, d};
          std::array<int, 3> two = rises ? std::array{a, c, d} : std::array{b, c, d};
          for (std::array<int, 3>* face : {&one, &two}) {
            if (side == 0) std::swap((*face)[1], (*face)[2]);
            faces.push_back(*face);
          }
        }
    }
  TriangleMesh box;
  box.vertices.resize(corners.size(), 3);
  box.faces.resize(faces.size(), 3);
  for (size_t v = 0; v < corners.size(); ++v)
    for (int k = 0; k < 3; ++k) box.vertices(v, k) = size[k] * corners[v][k] / cells[k];
  for (size_t f = 0; f < faces.size(); ++f)
    for (int k = 0; k < 3; ++k) box.faces(f, k) = faces[f][k];
  return box;
}

DrapeState at_rest(const Eigen::VectorXd& x) {
  return {x, std::vector<Anchor>(x.size() / 3)};
}

NewtonResult settle(const Cloth& cloth, const Stage& stage, DrapeState& state) {
  ContactSearch contacts(cloth.faces, cloth.area, state.x, stage.body, stage.contact,
                         stage.friction);
  Cholesky factor(cloth.bending_hessian);
  return drape(cloth, contacts, stage.solver, factor, state);
}

Points3 forces_on(const Cloth& cloth, const Stage& stage, const DrapeState& state) {
  Cloth loose = cloth;
  loose.is_pinned.clear();
  ContactSearch contacts(cloth.faces, cloth.area, state.x, stage.body, stage.contact,
                         stage.friction);
  contacts.prepare(state.x, Eigen::VectorXd::Zero(state.x.size()));
  const Region all = whole(loose);
  std::vector<Anchor> anchors = state.anchors;
  const Touching touching = contacts.touching(all.vertices, state.x, anchors);
  const std::vector<ActiveBarrier> barriers =
      contacts.barriers(contacts.pairs_at(all.place), state.x, Order::kGradient);
  System system;
  assemble(loose, all, touching, barriers, state.x, Order::kGradient, system);
  return -as_rows(system.gradient);
}

double weight_of(const Cloth& cloth) {
  double mass = 0;
  for (const Weight& weight : cloth.weights) mass += weight.mass;
  return mass * kGravity;
}

void report(const std::string& what, double value, const std::string& unit) {
  std::printf("  %-60s %.4g %s\n", what.c_str(), value, unit.c_str());
}

}  // namespace pleat::sim
