#include "app/lists.h"

#include <gmock/gmock.h>

#include <cmath>
#include <set>

#include "tests/core/input_error.h"
#include "tests/core/scratch.h"

namespace pleat::app {
namespace {

using testing::ElementsAre;

std::vector<double> numbers_of(const garment::Design& design) {
  return {design.length, design.sleeve, design.cleavage};
}

template <typename Named>
std::vector<std::string> names_of(const std::vector<Named>& items) {
  std::vector<std::string> names;
  for (const Named& item : items) names.push_back(item.name);
  return names;
}

TEST(DesignGrid, HoldsEveryCombinationTheLastAxisFastest) {
  const auto designs = designs_of(DesignGrid{{0.35, 1}, {0.2}, {0, 0.5, 0.25}});
  ASSERT_EQ(designs.size(), 6u);
  EXPECT_THAT(numbers_of(designs[0]), ElementsAre(0.35, 0.2, 0));
  EXPECT_THAT(numbers_of(designs[1]), ElementsAre(0.35, 0.2, 0.5));
  EXPECT_THAT(numbers_of(designs[2]), ElementsAre(0.35, 0.2, 0.25));
  EXPECT_THAT(numbers_of(designs[3]), ElementsAre(1, 0.2, 0));
  EXPECT_THAT(names_of(designs), ElementsAre("l0.35_s0.2_c0", "l0.35_s0.2_c0.5", "l0.35_s0.2_c0.25",
                                             "l1_s0.2_c0", "l1_s0.2_c0.5", "l1_s0.2_c0.25"));
  for (const garment::Design& design : designs) EXPECT_FALSE(design.is_held_out);
}

TEST(DesignGrid, KeepsTheDefaultOfAnAxisNotGiven) {
  DesignGrid grid;
  grid.sleeve = {0, 1};
  const auto designs = designs_of(grid);
  ASSERT_EQ(designs.size(), 2u);
  EXPECT_EQ(designs[1].length, garment::Design{}.length);
  EXPECT_EQ(designs[1].sleeve, 1);
  EXPECT_EQ(designs[1].cleavage, garment::Design{}.cleavage);
}

TEST(DesignGrid, NamesNeighbouringNumbersDifferently) {
  const double third = 1.0 / 3;
  const auto designs =
      designs_of(DesignGrid{{third, std::nextafter(third, 1), std::nextafter(third, 0)}, {0}, {0}});
  const auto names = names_of(designs);
  EXPECT_EQ(std::set<std::string>(names.begin(), names.end()).size(), 3u);
  EXPECT_EQ(names[0], "l0.3333333333333333_s0_c0");
}

TEST(DesignGrid, RefusesWhatIsNoGrid) {
  const double nan = std::nan("");
  EXPECT_INPUT_ERROR(designs_of(DesignGrid{{}, {0}, {0}}), "designs.grid.length", "empty");
  EXPECT_INPUT_ERROR(designs_of(DesignGrid{{0}, {0, 1.5}, {0}}), "designs.grid.sleeve = 1.5",
                     "0 .. 1");
  EXPECT_INPUT_ERROR(designs_of(DesignGrid{{0}, {0}, {nan}}), "designs.grid.cleavage = nan");
  EXPECT_INPUT_ERROR(designs_of(DesignGrid{{0.5, 0, 0.5}, {0}, {0}}), "designs.grid.length",
                     "0.5 is given twice");
  std::vector<double> many;
  for (int k = 0; k < 1000; ++k) many.push_back(k / 1000.0);
  EXPECT_INPUT_ERROR(designs_of(DesignGrid{many, many, {0}}), "designs.grid", "100000");
}

TEST(RandomDesigns, StayWithinTheirRanges) {
  RandomDesigns random;
  random.count = 2000;
  random.length = {0.25, 0.75};
  random.sleeve = 0.5;
  double lowest = 1, highest = 0, sum = 0;
  for (const garment::Design& design : designs_of(random, 1)) {
    lowest = std::min(lowest, design.length);
    highest = std::max(highest, design.length);
    sum += design.length;
    EXPECT_EQ(design.sleeve, 0.5);
    EXPECT_TRUE(design.cleavage >= 0 && design.cleavage <= 1);
  }
  EXPECT_TRUE(lowest >= 0.25 && lowest < 0.26) << lowest;
  EXPECT_TRUE(highest <= 0.75 && highest > 0.74) << highest;
  EXPECT_NEAR(sum / 2000, 0.5, 5 * 0.5 / std::sqrt(12.0 * 2000));  // five standard errors
}

TEST(RandomDesigns, DependOnSeedAndPlaceAlone) {
  RandomDesigns random;
  random.count = 3;
  random.held_out = 1;
  const auto few = designs_of(random, 7);
  random.count = 50;
  const auto many = designs_of(random, 7);
  ASSERT_EQ(many.size(), 50u);
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(many[k].name, few[k].name);
    EXPECT_EQ(numbers_of(many[k]), numbers_of(few[k]));
    EXPECT_EQ(many[k].is_held_out, few[k].is_held_out);
  }
  random.length = 0.1;  // no other axis is drawn differently
  EXPECT_EQ(designs_of(random, 7)[2].sleeve, few[2].sleeve);
  EXPECT_NE(designs_of(random, 8)[2].sleeve, few[2].sleeve);
  EXPECT_NE(few[0].sleeve, few[1].sleeve);
  EXPECT_NE(few[0].sleeve, few[0].cleavage);
}

TEST(RandomDesigns, HoldOutTheFirst) {
  RandomDesigns random;
  random.count = 3;
  random.held_out = 2;
  const auto designs = designs_of(random, 1);
  EXPECT_TRUE(designs[0].is_held_out);
  EXPECT_TRUE(designs[1].is_held_out);
  EXPECT_FALSE(designs[2].is_held_out);
  EXPECT_THAT(names_of(designs), ElementsAre("random_0", "random_1", "random_2"));
}

TEST(RandomDesigns, RefuseWrongNumbers) {
  const auto refuse = [](auto change, const std::string& key, const std::string& expected) {
    RandomDesigns random;
    random.count = 3;
    change(random);
    EXPECT_INPUT_ERROR(designs_of(random, 1), key, expected);
  };
  using R = RandomDesigns;
  refuse([](R& r) { r.count = 0; }, "designs.random.count = 0", "1 .. 100000");
  refuse([](R& r) { r.count = 100001; }, "designs.random.count = 100001", "1 .. 100000");
  refuse([](R& r) { r.length = {-0.1, 1}; }, "designs.random.length = [-0.1, 1]", "0 <= low");
  refuse([](R& r) { r.sleeve = {0.6, 0.4}; }, "designs.random.sleeve = [0.6, 0.4]", "low <= high");
  refuse([](R& r) { r.cleavage = {0, std::nan("")}; }, "designs.random.cleavage", "high <= 1");
  refuse([](R& r) { r.held_out = -1; }, "designs.random.held_out = -1", "0 or more");
  refuse([](R& r) { r.held_out = 3; }, "designs.random.held_out = 3", "less than count");
}

TEST(ShapeGrid, HoldsEveryCombinationTheLastBetaFastest) {
  EXPECT_THAT(shapes_of(ShapeGrid{{{-2, 0, 2}, {-1, 1}}}),
              ElementsAre(ElementsAre(-2, -1), ElementsAre(-2, 1), ElementsAre(0, -1),
                          ElementsAre(0, 1), ElementsAre(2, -1), ElementsAre(2, 1)));
  EXPECT_THAT(shapes_of(ShapeGrid{{{0.5}}}), ElementsAre(ElementsAre(0.5)));
}

TEST(ShapeGrid, RefusesWhatIsNoGrid) {
  EXPECT_INPUT_ERROR(shapes_of(ShapeGrid{}), "shapes.grid.betas", "empty");
  EXPECT_INPUT_ERROR(shapes_of(ShapeGrid{{{0}, {}}}), "shapes.grid.betas[1]", "empty");
  EXPECT_INPUT_ERROR(shapes_of(ShapeGrid{{{0, 7}}}), "shapes.grid.betas[0] = 7", "-5 .. 5");
  EXPECT_INPUT_ERROR(shapes_of(ShapeGrid{{{1, 1}}}), "shapes.grid.betas[0]", "1 is given twice");
  EXPECT_INPUT_ERROR(shapes_of(ShapeGrid{std::vector<std::vector<double>>(17, {0, 1})}),
                     "shapes.grid", "more than 100000 combinations");
  std::vector<std::vector<double>> wide(70000, {0.0});
  for (int b = 0; b < 4; ++b) wide[b] = {0, 1};
  EXPECT_INPUT_ERROR(shapes_of(ShapeGrid{wide}), "shapes.grid", "16 shapes of 70000 betas");
}

TEST(RandomShapes, AreOfATruncatedNormalDistribution) {
  RandomShapes random;
  random.count = 2000;
  random.betas = 5;
  double sum = 0, squares = 0;
  int beyond_one = 0;
  for (const std::vector<double>& shape : shapes_of(random, 1)) {
    ASSERT_EQ(shape.size(), 5u);
    for (double beta : shape) {
      ASSERT_LE(std::abs(beta), 2);
      sum += beta;
      squares += beta * beta;
      beyond_one += std::abs(beta) > 1;
    }
  }
  // Of a normal variable between -2 and 2: variance 1 - 4 phi(2) / (2 Phi(2) - 1) = 0.7737, share
  // beyond 1: 0.2719 / 0.9545 = 0.2848. Tolerances: five standard errors of 10,000 draws.
  EXPECT_NEAR(sum / 10000, 0, 0.044);
  EXPECT_NEAR(squares / 10000, 0.7737, 0.046);
  EXPECT_NEAR(beyond_one / 10000.0, 0.2848, 0.023);

  random.sigma = 0.5;
  random.limit = 0.05;  // nearly uniform
  for (const std::vector<double>& shape : shapes_of(random, 1))
    for (double beta : shape) ASSERT_LE(std::abs(beta), 0.05);
}

TEST(RandomShapes, DependOnSeedAndPlaceAlone) {
  const auto draw = [](int count, int betas, uint64_t seed) {
    RandomShapes random;
    random.count = count;
    random.betas = betas;
    return shapes_of(random, seed);
  };
  const auto few = draw(3, 2, 7), many = draw(50, 2, 7), wide = draw(3, 4, 7);
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(many[k], few[k]);
    EXPECT_EQ(std::vector<double>(wide[k].begin(), wide[k].begin() + 2), few[k]);
  }
  EXPECT_NE(few[0], few[1]);
  EXPECT_NE(few[0][0], few[0][1]);
  EXPECT_NE(draw(3, 2, 8)[0], few[0]);
}

TEST(RandomShapes, RefuseWrongNumbers) {
  const auto refuse = [](auto change, const std::string& key, const std::string& expected) {
    RandomShapes random{3, 2};
    change(random);
    EXPECT_INPUT_ERROR(shapes_of(random, 1), key, expected);
  };
  using R = RandomShapes;
  refuse([](R& r) { r.count = 0; }, "shapes.random.count = 0", "1 .. 100000");
  refuse([](R& r) { r.betas = 0; }, "shapes.random.betas = 0", "1 .. 1000000");
  refuse([](R& r) { r.count = 100000, r.betas = 11; }, "shapes.random", "at most 1000000 betas");
  refuse([](R& r) { r.sigma = 0; }, "shapes.random.sigma = 0", "> 0");
  refuse([](R& r) { r.sigma = std::nan(""); }, "shapes.random.sigma = nan", "> 0");
  refuse([](R& r) { r.limit = 0; }, "shapes.random.limit = 0", "sigma / 10 .. 5");
  refuse([](R& r) { r.limit = 6; }, "shapes.random.limit = 6", "sigma / 10 .. 5");
  refuse([](R& r) { r.sigma = 30; }, "shapes.random.limit = 2", "sigma / 10 .. 5");  // no end
}

// A folder of empty files.
struct Folder {
  Scratch scratch;
  std::string path = scratch.path("motions");
  explicit Folder(const std::vector<std::string>& files) {
    std::filesystem::create_directory(path);
    for (const std::string& file : files) add(file);
  }
  void add(const std::string& file) const {
    const std::filesystem::path whole = path + "/" + file;
    std::filesystem::create_directories(whole.parent_path());
    write_bytes(whole.string(), "");
  }
};

TEST(MotionFolder, ListsTheMotionsBelowSortedByName) {
  const Folder folder({"walk.npz", "CMU/02/02_01_poses.npz", "CMU/02/shape.npz",
                       "CMU/01/run.v2.bvh", "CMU/02/neutral_stagei.npz", "CMU/02/a_stageii.npz",
                       "b/jump.BVH", "CMU/LICENSE.txt", "my_shape.npz", "b/walk.npz", ".npz"});
  std::filesystem::create_directory(folder.path + "/folder.npz");
  folder.add("folder.npz/leap.bvh");
  const auto motions = motions_of({folder.path, {"b/walk"}});
  EXPECT_THAT(names_of(motions),
              ElementsAre("CMU/01/run.v2", "CMU/02/02_01_poses", "CMU/02/a_stageii", "b/jump",
                          "b/walk", "folder.npz/leap", "my_shape", "walk"));
  EXPECT_EQ(motions[3].file, folder.path + "/b/jump.BVH");
  for (const MotionEntry& motion : motions) {
    EXPECT_EQ(motion.held_out, motion.name == "b/walk");
    EXPECT_EQ(motion.start_s, 0);
    EXPECT_EQ(motion.duration_s, 0);
  }
  EXPECT_EQ(names_of(motions_of({folder.path + "/", {}})), names_of(motions));
}

TEST(MotionFolder, RefusesWhatGivesNoMotions) {
  const Folder folder({"shape.npz", "readme.txt"});
  EXPECT_INPUT_ERROR(motions_of({folder.path + "/absent", {}}), "motions.folder", "absent",
                     "No such file");
  EXPECT_INPUT_ERROR(motions_of({folder.path + "/readme.txt", {}}), "motions.folder", "readme.txt",
                     "Not a directory");
  EXPECT_INPUT_ERROR(motions_of({folder.path, {}}), "motions.folder", folder.path,
                     "holds no AMASS");
  folder.add("a/walk.npz");
  EXPECT_INPUT_ERROR(motions_of({folder.path, {"walk"}}), "motions.held_out", "no motion 'walk'",
                     "'a/walk'");
  folder.add("a/walk.bvh");
  EXPECT_INPUT_ERROR(motions_of({folder.path, {}}), "motions.folder", "'a/walk'", "ending");
}

}  // namespace
}  // namespace pleat::app
