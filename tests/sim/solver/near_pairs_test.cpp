#include "sim/solver/near_pairs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "tests/sim/all_pairs.h"
#include "tests/sim/shapes.h"

namespace pleat::sim {
namespace {

constexpr int kInstants = 20;  // at which a motion is looked at

// Cloth and body as the finder sees them, and all pairs of their features, one by one.
struct Everything {
  Faces cloth, body;
  int count;  // vertices of the cloth
  Scene scene;
  PairRanges ranges{0.08, 0.06, 0.1};

  PairPoints at(const std::array<int, 4>& vertices, double t) const {
    PairPoints x;
    for (int k = 0; k < 4; ++k) {
      x.col(k) = scene.positions.row(vertices[k]).transpose();
      if (scene.motion.rows() > 0) x.col(k) += t * scene.motion.row(vertices[k]).transpose();
    }
    return x;
  }
  // The least distance on the way, less what all of both features may stray.
  double gap(PairKind kind, const std::array<int, 4>& vertices) const {
    const auto reach = [&](int k) { return scene.reach[vertices[k]]; };
    const double stray = kind == PairKind::kPointFace
                             ? reach(0) + std::min({reach(1), reach(2), reach(3)})
                             : std::min(reach(0), reach(1)) + std::min(reach(2), reach(3));
    double least = std::numeric_limits<double>::infinity();
    const int instants = scene.motion.rows() > 0 ? kInstants : 0;
    for (int i = 0; i <= instants; ++i)
      least = std::min(least, squared_pair_distance(kind, at(vertices, i / double(kInstants))));
    return std::sqrt(least) - stray;
  }
  // All pairs that the finder is to know of, with their gaps.
  std::map<Feature, double> all() const {
    std::map<Feature, double> pairs;
    for_each_pair(cloth, body, count, [&](PairKind kind, const std::array<int, 4>& vertices) {
      pairs[named(kind, vertices)] = gap(kind, vertices);
    });
    return pairs;
  }
  double range_of(const Feature& pair) const {
    const bool is_with_body =
        *std::max_element(pair.vertices.begin(), pair.vertices.end()) >= count;
    return is_with_body ? ranges.body_m : ranges.cloth_m;
  }
};

// A crumpled sheet over a bumpy ball that it partly crosses, edges of 0.1 to 0.3 m.
Everything make_everything() {
  const TriangleMesh ball = make_bumpy_ball(2, 0.5, 0.1);
  Sheet sheet = make_sheet(1, 7, 0.45);
  shake(sheet.x, 0.04, "crumple");
  for (int v = 0; v < sheet.rest.rows(); ++v)  // and folded over itself
    if (sheet.x[3 * v] > 0.2) {
      sheet.x[3 * v] = 0.4 - sheet.x[3 * v];
      sheet.x[3 * v + 1] += 0.1;
    }
  Everything e;
  e.cloth = sheet.faces;
  e.body = ball.faces;
  e.count = static_cast<int>(sheet.rest.rows());
  e.scene.positions.resize(e.count + ball.vertices.rows(), 3);
  e.scene.positions << Eigen::Map<const Points3>(sheet.x.data(), e.count, 3), ball.vertices;
  e.scene.reach = Eigen::VectorXd::Zero(e.scene.positions.rows());
  return e;
}

PairFinder::Found find(const Everything& e) {
  PairFinder finder(e.cloth, e.scene.positions.topRows(e.count), e.body,
                    e.scene.positions.bottomRows(e.scene.positions.rows() - e.count));
  return finder.find(e.scene, e.ranges);
}

// Each found once and at its distance; all that come into range; none that lies `beyond` farther
// away.
void expect_pairs(const Everything& e, const PairFinder::Found& found, double beyond) {
  std::set<Feature> names;
  for (const NearPair& pair : found.pairs) {
    EXPECT_TRUE(names.insert(named(pair.kind, pair.vertices)).second);
    EXPECT_DOUBLE_EQ(pair.distance,
                     std::sqrt(squared_pair_distance(pair.kind, e.at(pair.vertices, 0))));
  }
  const std::map<Feature, double> all = e.all();
  int near_cloth = 0, near_body = 0;
  for (const auto& [pair, gap] : all) {
    const double range = e.range_of(pair);
    const bool is_found = names.count(pair) > 0;
    if (gap <= range) {
      EXPECT_TRUE(is_found) << static_cast<int>(pair.kind) << " " << gap;
      ++(range == e.ranges.cloth_m ? near_cloth : near_body);
    }
    if (gap > range + beyond) {
      EXPECT_FALSE(is_found) << static_cast<int>(pair.kind) << " " << gap;
    }
    names.erase(pair);
  }
  EXPECT_TRUE(names.empty());  // nothing that is no pair
  EXPECT_GT(near_cloth, 100);
  EXPECT_GT(near_body, 100);
  EXPECT_LT(near_cloth + near_body, static_cast<int>(all.size()) / 4);
}

void expect_rest_faces(const Everything& e, const PairFinder::Found& found) {
  ASSERT_EQ(found.rest_start.size(), static_cast<size_t>(e.count + 1));
  ASSERT_EQ(found.rest_start.back(), static_cast<int>(found.rest_faces.size()));
  for (int v = 0; v < e.count; ++v) {
    std::vector<int> expected;
    for (int f = 0; f < e.body.rows(); ++f) {
      const std::array<int, 4> four = {v, e.count + e.body(f, 0), e.count + e.body(f, 1),
                                       e.count + e.body(f, 2)};
      if (e.gap(PairKind::kPointFace, four) <= e.ranges.rest_m) expected.push_back(f);
    }
    EXPECT_EQ(std::vector<int>(found.rest_faces.begin() + found.rest_start[v],
                               found.rest_faces.begin() + found.rest_start[v + 1]),
              expected)
        << v;
  }
  EXPECT_GT(found.rest_faces.size(), 100u);
}

TEST(PairFinder, FindsJustThePairsInRange) {
  const Everything e = make_everything();
  const PairFinder::Found found = find(e);
  expect_pairs(e, found, 1e-12);
  expect_rest_faces(e, found);
}

TEST(PairFinder, AddsTheReachOfBoth) {
  Everything e = make_everything();
  e.scene.reach.head(e.count).setConstant(0.03);
  e.scene.reach.tail(e.scene.reach.size() - e.count).setConstant(0.01);
  const PairFinder::Found found = find(e);
  expect_pairs(e, found, 1e-12);
  expect_rest_faces(e, found);
}

// A face is looked at as a whole, with the largest reach of its corners.
TEST(PairFinder, FindsAllWhereReachesDiffer) {
  Everything e = make_everything();
  RandomStream random(1, "reach");
  for (double& reach : e.scene.reach) reach = 0.03 * random.uniform();
  expect_pairs(e, find(e), 0.06);
}

TEST(PairFinder, FindsWhatComesNearOnTheWay) {
  Everything e = make_everything();
  RandomStream random(2, "motion");
  e.scene.reach.setConstant(1e-3);
  e.scene.motion = Points3::Zero(e.scene.positions.rows(), 3);
  e.scene.motion.topRows(e.count).rowwise() = Vec<3>(0.2, -0.3, 0.1).transpose();
  for (double& u : e.scene.motion.reshaped()) u += 0.05 * (2 * random.uniform() - 1);
  const Everything still = [&] {
    Everything copy = e;
    copy.scene.motion.resize(0, 3);
    return copy;
  }();
  expect_pairs(e, find(e), 0.6);
  // Most of it was far away at the start.
  int on_the_way = 0;
  const std::map<Feature, double> gaps = e.all(), at_start = still.all();
  for (const auto& [pair, gap] : gaps)
    on_the_way += gap <= e.range_of(pair) && at_start.at(pair) > e.range_of(pair);
  EXPECT_GT(on_the_way, 300);
}

// What moves together comes no nearer.
TEST(PairFinder, CommonMotionFindsWhatRestFinds) {
  Everything e = make_everything();
  const PairFinder::Found still = find(e);
  e.scene.motion = Points3::Constant(e.scene.positions.rows(), 3, 0.4);
  const PairFinder::Found moving = find(e);
  ASSERT_EQ(moving.pairs.size(), still.pairs.size());
  expect_pairs(e, moving, 1e-12);
}

// The finder is made once; poses come and go.
TEST(PairFinder, KnowsNothingOfFormerPoses) {
  const Everything e = make_everything();
  Everything elsewhere = e;
  RandomStream random(3, "elsewhere");
  for (double& x : elsewhere.scene.positions.reshaped()) x += 0.2 * random.normal();
  PairFinder finder(e.cloth, e.scene.positions.topRows(e.count), e.body,
                    e.scene.positions.bottomRows(e.scene.positions.rows() - e.count));
  expect_pairs(elsewhere, finder.find(elsewhere.scene, e.ranges), 1e-12);
  const PairFinder::Found back = finder.find(e.scene, e.ranges);
  expect_pairs(e, back, 1e-12);
  expect_rest_faces(e, back);
}

// Asked for some vertices, it finds of all pairs those with one of them.
TEST(PairFinder, FindsThePairsAskedFor) {
  Everything e = make_everything();
  const PairFinder::Found all = find(e);
  e.scene.is_asked.assign(e.count, 0);
  for (int v = 0; v < e.count; v += 5) e.scene.is_asked[v] = 1;
  const PairFinder::Found some = find(e);
  const auto names = [](const std::vector<NearPair>& pairs) {
    std::set<Feature> result;
    for (const NearPair& pair : pairs) result.insert(named(pair.kind, pair.vertices));
    return result;
  };
  std::vector<NearPair> wanted = all.pairs;
  wanted.erase(std::remove_if(wanted.begin(), wanted.end(),
                              [&](const NearPair& pair) {
                                return std::none_of(
                                    pair.vertices.begin(), pair.vertices.end(),
                                    [&](int v) { return v < e.count && v % 5 == 0; });
                              }),
               wanted.end());
  const std::set<Feature> found = names(some.pairs), expected = names(wanted);
  EXPECT_TRUE(std::includes(found.begin(), found.end(), expected.begin(), expected.end()));
  EXPECT_EQ(found.size(), expected.size());
  EXPECT_EQ(some.pairs.size(), wanted.size());
  EXPECT_LT(wanted.size(), all.pairs.size());
  EXPECT_GT(wanted.size(), 100u);
  const auto rest = [](const PairFinder::Found& found, int v) {
    return std::vector<int>(found.rest_faces.begin() + found.rest_start[v],
                            found.rest_faces.begin() + found.rest_start[v + 1]);
  };
  for (int v = 0; v < e.count; ++v)
    EXPECT_EQ(rest(some, v), v % 5 == 0 ? rest(all, v) : std::vector<int>{});
}

// Flat cloth: around a vertex corners are as near as a face is high, and then they are pairs.
TEST(PairFinder, FindsNeighboursOfFlatCloth) {
  Everything e = make_everything();
  const Sheet sheet = make_sheet(1, 7, 3);
  e.scene.positions.topRows(e.count) = Eigen::Map<const Points3>(sheet.x.data(), e.count, 3);
  EXPECT_TRUE(find(e).pairs.empty());
  e.ranges.cloth_m = 1.5 / 7;  // edges are 1 / 7 long
  std::set<Feature> names;
  for (const NearPair& pair : find(e).pairs) names.insert(named(pair.kind, pair.vertices));
  for (const auto& [pair, gap] : e.all()) {
    const double range = e.range_of(pair);
    if (std::abs(gap - range) > 1e-12) {
      EXPECT_EQ(names.count(pair) > 0, gap < range);
    }
  }
  EXPECT_GT(names.size(), 200u);
}

}  // namespace
}  // namespace pleat::sim
