// The solver on a square metre of cloth let down on a ball.
#include <cmath>
#include <numeric>
#include <string>

#include "core/random.h"
#include "sim/drape.h"
#include "tests/benchmarks/bench.h"
#include "tests/core/shapes.h"

namespace pleat::bench {
namespace {

constexpr double kBallRadius = 0.3;  // m

struct Sheet {
  Points2 flat;
  Faces faces;
  sim::Cloth cloth;
  Eigen::VectorXd start;  // level, just above the ball; y is up
};

Sheet make_sheet(int side, const garment::Fabric& fabric = {}) {
  Sheet sheet;
  sheet.flat.resize(side * side, 2);
  sheet.start.resize(3 * side * side);
  for (int v = 0; v < side * side; ++v) {
    sheet.flat.row(v) << (v % side) / (side - 1.0) - 0.5, (v / side) / (side - 1.0) - 0.5;
    sheet.start.segment<3>(3 * v) << sheet.flat(v, 0), kBallRadius + 0.002, sheet.flat(v, 1);
  }
  const int cells = side - 1;
  sheet.faces.resize(2 * cells * cells, 3);
  for (int c = 0; c < cells * cells; ++c) {
    const int a = c % cells + side * (c / cells), b = a + side;
    if ((c % cells + c / cells) % 2 == 0) {
      sheet.faces.row(2 * c) << a, a + 1, b + 1;
      sheet.faces.row(2 * c + 1) << a, b + 1, b;
    } else {
      sheet.faces.row(2 * c) << a, a + 1, b;
      sheet.faces.row(2 * c + 1) << a + 1, b + 1, b;
    }
  }
  sheet.cloth = sim::make_cloth(sheet.faces, sheet.faces, sheet.flat, side * side, fabric);
  return sheet;
}

// The sheet stretched by a few percent and shaken, so that its faces are in tension, in compression
// and between.
Eigen::VectorXd shaken(const Sheet& sheet) {
  RandomStream random(1, "shaken");
  Eigen::VectorXd x = 1.02 * sheet.start;
  for (double& coordinate : x) coordinate += 0.0005 * random.normal();
  return x;
}

// Gradient and projected Hessian of every element, without their sum.
void bench_forces(const std::string& law, const Sheet& sheet, Report& report) {
  const sim::Cloth& cloth = sheet.cloth;
  const Eigen::VectorXd x = shaken(sheet);
  double sum = 0;
  report.time_each("sim.membrane_" + law + ".ns_per_face", 20, cloth.membranes.size(), [&] {
    for (const sim::Membrane& membrane : cloth.membranes) {
      Vec<9> corners;
      for (int a = 0; a < 3; ++a)
        corners.segment<3>(3 * a) = x.segment<3>(3 * membrane.vertices[a]);
      sum +=
          sim::membrane_energy(membrane, cloth.membrane_law, corners, sim::Order::kProjectedHessian)
              .hessian(0, 0);
    }
  });
  const std::string bending = cloth.bending_law.is_measured ? "bending_table" : "bending";
  report.time_each("sim." + bending + ".ns_per_hinge", 20, cloth.bendings.size(), [&] {
    for (const sim::Bending& bending : cloth.bendings) {
      Vec<12> corners;
      for (int a = 0; a < 4; ++a) corners.segment<3>(3 * a) = x.segment<3>(3 * bending.vertices[a]);
      sum += sim::jump_energy(bending, cloth.bending_law, sim::normal_jump(bending, corners),
                              sim::Order::kProjectedHessian)
                 .hessian(0, 0);
    }
  });
  if (std::isnan(sum)) report.add("sim.membrane_" + law + ".nan", 1, "");  // and keeps the loops
  sim::System system;
  report.time("sim/assemble_5k_" + law, 20,
              [&] { sim::assemble(cloth, {}, x, sim::Order::kProjectedHessian, system); });
}

}  // namespace

void bench_sim(Report& report) {
  const Sheet sheet = make_sheet(71);
  sim::System system;
  report.time("sim/assemble_5k", 20, [&] {
    sim::assemble(sheet.cloth, {}, sheet.start, sim::Order::kProjectedHessian, system);
  });
  bench_forces("stvk", sheet, report);
  garment::FabricConfig measured;
  measured.name = "gray_interlock";
  garment::complete(measured);
  bench_forces("table", make_sheet(71, garment::middle_fabric(measured)), report);
  const Eigen::VectorXd shift = Eigen::VectorXd::Constant(sheet.flat.rows(), 1.0);
  report.time("sim/cholesky_analyse_5k", 5, [&] { sim::Cholesky factor(system.hessian); });
  sim::Cholesky factor(system.hessian);
  report.time("sim/cholesky_factor_5k", 10, [&] { factor.factor(system.hessian, shift); });
  report.time("sim/cholesky_solve_5k", 20, [&] { factor.solve(system.gradient); });

  const TriangleMesh ball = make_sphere(5, kBallRadius);
  const sim::BodyCollider collider(ball.vertices, ball.faces);
  const Sheet small = make_sheet(35);
  sim::Cholesky small_factor(small.cloth.bending_hessian);
  sim::NewtonResult result;
  report.time("sim/drape_ball_1k_cold", 1, [&] {
    sim::DrapeState state{small.start, std::vector<sim::Anchor>(small.flat.rows())};
    result = sim::drape(small.cloth, collider, 0.4, {}, {}, small_factor, state);
  });
  report.add("sim/drape_ball_1k_cold_residual", result.residual, "");
  report.add("sim/drape_ball_1k_cold_iterations", result.iterations, "");
}

}  // namespace pleat::bench
