// Two layers of cloth on a ball: every kind of force at work.
#pragma once

#include <vector>

#include "sim/solver/assemble.h"
#include "tests/sim/shapes.h"

namespace pleat::sim {

// Lays a level sheet on a ball of `radius` around the origin, turned by `angle` about the axis y.
inline Points3 lay_on_ball(const Sheet& sheet, double radius, double angle) {
  const Mat<3> turn = Eigen::AngleAxisd(angle, Vec<3>::UnitY()).toRotationMatrix();
  Points3 positions(sheet.rest.rows(), 3);
  for (Eigen::Index v = 0; v < positions.rows(); ++v) {
    const Vec<3> level(sheet.rest(v, 0), radius, -sheet.rest(v, 1));
    positions.row(v) = (turn * (radius * level.normalized())).transpose();
  }
  return positions;
}

// The lower layer lies 0.8 mm over a ball of 15 cm, the upper 1.2 mm over the lower, both within
// reach of springs and barriers and a little crumpled.
struct DressedBall {
  static constexpr double kRadius = 0.15;
  static constexpr int kCells = 7, kLayer = (kCells + 1) * (kCells + 1);  // vertices of a layer
  TriangleMesh ball = make_sphere(4, kRadius);
  BodyCollider body{ball.vertices, ball.faces};
  Points2 rest{2 * kLayer, 2};
  Faces faces{4 * kCells * kCells, 3};
  Eigen::VectorXd x{6 * kLayer};
  Cloth cloth;
  ContactConfig config;
  std::vector<Anchor> anchors{2 * kLayer};

  explicit DressedBall(const garment::Fabric& fabric = {}) {
    const Sheet sheet = make_sheet(0.12, kCells, 0);
    Points3 positions(2 * kLayer, 3);
    positions << lay_on_ball(sheet, kRadius + 0.0008, 0), lay_on_ball(sheet, kRadius + 0.002, 0.3);
    rest << sheet.rest, sheet.rest;
    faces << sheet.faces, sheet.faces.array() + kLayer;
    x = Eigen::Map<const Eigen::VectorXd>(positions.data(), positions.size());
    shake(x, 5e-5, "dressed ball");
    cloth = make_cloth(faces, faces, rest, 2 * kLayer, fabric);
  }

  ContactSearch search() const { return {faces, cloth.area, x, body, config, 0.4}; }
};

// What acts on a cloth, found once and held: a function of the positions with exact derivatives.
struct Held {
  const DressedBall& scene;
  Region region;
  Touching touching;
  std::vector<Barrier> elements;

  Held(DressedBall& scene, const Region& region) : scene(scene), region(region) {
    ContactSearch search = scene.search();
    search.prepare(scene.x, Eigen::VectorXd::Zero(scene.x.size()));
    touching = search.touching(region.vertices, scene.x, scene.anchors);
    for (const ActiveBarrier& barrier :
         search.barriers(search.pairs_at(region.place), scene.x, Order::kValue))
      elements.push_back(barrier.element);
  }

  std::vector<ActiveBarrier> barriers(const Eigen::VectorXd& x, Order order) const {
    std::vector<ActiveBarrier> result;
    for (const Barrier& element : elements) {
      PairPoints points;
      for (int k = 0; k < 4; ++k) {
        const int v = element.vertices[k], count = scene.cloth.vertex_count;
        points.col(k) = v < count ? Vec<3>(x.segment<3>(3 * v))
                                  : Vec<3>(scene.ball.vertices.row(v - count).transpose());
      }
      result.push_back({element, barrier_term(element, points, order)});
    }
    return result;
  }
  System system(const Eigen::VectorXd& x, Order order) const {
    System system;
    assemble(scene.cloth, region, touching, barriers(x, order), x, order, system);
    return system;
  }
};

inline Eigen::VectorXd random_vector(Eigen::Index size, const std::string& name) {
  RandomStream random(7, name);
  Eigen::VectorXd vector(size);
  for (double& number : vector) number = random.normal();
  return vector;
}

inline Eigen::MatrixXd dense(const BlockMatrix& matrix) {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(3 * matrix.rows(), 3 * matrix.rows());
  for (int row = 0; row < matrix.rows(); ++row)
    for (int k = matrix.row_start[row]; k < matrix.row_start[row + 1]; ++k)
      result.block<3, 3>(3 * row, 3 * matrix.column[k]) = matrix.block(k);
  return result;
}

}  // namespace pleat::sim
