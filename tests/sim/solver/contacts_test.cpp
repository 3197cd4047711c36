#include "sim/solver/contacts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numeric>

#include "core/proximity.h"
#include "tests/sim/all_pairs.h"
#include "tests/sim/dressed_ball.h"

namespace pleat::sim {
namespace {

std::vector<int> all_of(Eigen::Index count) {
  std::vector<int> all(count);
  std::iota(all.begin(), all.end(), 0);
  return all;
}
Eigen::VectorXd no_step(const Eigen::VectorXd& x) { return Eigen::VectorXd::Zero(x.size()); }
Eigen::VectorXd same_step(const Eigen::VectorXd& x, const Vec<3>& way) {
  return way.replicate(x.size() / 3, 1);
}
Points3 as_points(const Eigen::VectorXd& x) {
  return Eigen::Map<const Points3>(x.data(), x.size() / 3, 3);
}
bool crosses(const Eigen::VectorXd& x, const Faces& faces, const Points3& body,
             const Faces& body_faces) {
  const SurfaceTree cloth(as_points(x), faces);
  return !intersecting_faces(cloth, {body, body_faces}).empty() ||
         !self_intersecting_faces(cloth).empty();
}

// A level cloth of 20 cm over level ground of 40 cm. Cells of 25 mm on such of 20 mm.
struct OverGround {
  static constexpr double kFriction = 0.4;
  Sheet ground = make_sheet(0.4, 20, 0), sheet;
  BodyCollider body{as_points(ground.x), ground.faces};
  ContactConfig config;
  Eigen::VectorXd x, areas;
  std::vector<Anchor> anchors;
  ContactSearch contacts;

  explicit OverGround(double height)
      : sheet(make_sheet(0.2, 8, height)),
        x(sheet.x),
        areas(Eigen::VectorXd::LinSpaced(81, 4e-4, 8e-4)),
        anchors(81),
        contacts(sheet.faces, areas, x, body, config, kFriction) {
    contacts.prepare(x, no_step(x));
  }
  Touching touching() { return contacts.touching(all_of(81), x, anchors); }
  // Of the spring at a height within it, per unit of area, N/m^2.
  double pressure(double height) const {
    const double u = config.distance_m - height;
    return config.stiffness_N_per_m3 * u * u / (2 * config.distance_m);
  }
};

// ---- Touching

TEST(Touching, GroundPushesByAreaAndHoldsByFriction) {
  constexpr double kHeight = 0.002;
  OverGround scene(kHeight);
  const Touching touching = scene.touching();
  ASSERT_EQ(touching.body, &scene.body);
  ASSERT_EQ(touching.contacts.size(), 81u);
  ASSERT_EQ(touching.frictions.size(), 81u);
  for (int v = 0; v < 81; ++v) {
    const Vec<3> at = scene.x.segment<3>(3 * v);
    const double force = scene.pressure(kHeight) * scene.areas[v];
    EXPECT_EQ(touching.contacts[v].vertex, v);
    const Vec<3> push =
        -contact_energy(touching.contacts[v], scene.body, at, Order::kGradient).gradient;
    EXPECT_LE((push - Vec<3>(0, force, 0)).norm(), 1e-9 * force);
    const Friction& friction = touching.frictions[v];
    EXPECT_EQ(friction.vertex, v);
    EXPECT_NEAR(friction.limit, OverGround::kFriction * force, 1e-9 * force);
    EXPECT_DOUBLE_EQ(friction.stiffness, scene.config.stick_N_per_m3 * scene.areas[v]);
    EXPECT_LE((friction.normal - Vec<3>::UnitY()).norm(), 1e-12);
    // It sticks to where it first touches.
    EXPECT_LE((friction.anchor - Vec<3>(at.x(), 0, at.z())).norm(), 1e-12);
    ASSERT_GE(scene.anchors[v].face, 0);
    EXPECT_EQ(scene.body.point(scene.anchors[v].face, scene.anchors[v].barycentric),
              friction.anchor);
  }
}

TEST(Touching, WhatIsOutOfReachFeelsNothing) {
  for (const double height : {0.0036, 0.006, 0.05}) {
    OverGround scene(height);
    const Touching touching = scene.touching();
    EXPECT_TRUE(touching.frictions.empty());
    for (const Contact& contact : touching.contacts)
      EXPECT_EQ(
          contact_energy(contact, scene.body, scene.x.segment<3>(3 * contact.vertex), Order::kValue)
              .value,
          0);
    for (const Anchor& anchor : scene.anchors) EXPECT_EQ(anchor.face, -1);
  }
}

// What the iteration froze still sees a vertex that comes down meanwhile.
TEST(Touching, RoomEndsBeforeTheGroundPushes) {
  OverGround scene(0.0065);
  const Touching touching = scene.touching();
  ASSERT_EQ(touching.contacts.size(), 81u);
  for (const Contact& contact : touching.contacts) {
    const Vec<3> at = scene.x.segment<3>(3 * contact.vertex);
    EXPECT_GT(contact.room, 0);
    for (const double height : {0.0034, 0.002, 0.0})
      EXPECT_GT(contact_energy(contact, scene.body, {at.x(), height, at.z()}, Order::kValue).value,
                0);
  }
}

TEST(Touching, KeepsAnchors) {
  OverGround scene(0.002);
  const Anchor anchor{17, {0.2, 0.3, 0.5}};
  for (const int v : {4, 40}) scene.anchors[v] = anchor;
  const Touching touching = scene.touching();
  for (const int v : {4, 40}) {
    EXPECT_EQ(scene.anchors[v].face, 17);
    EXPECT_EQ(touching.frictions[v].anchor, scene.body.point(17, anchor.barycentric));
  }
}

TEST(Touching, IsOfTheVerticesAskedFor) {
  OverGround scene(0.002);
  const Touching touching = scene.contacts.touching({3, 50}, scene.x, scene.anchors);
  ASSERT_EQ(touching.contacts.size(), 2u);
  EXPECT_EQ(touching.contacts[0].vertex, 3);
  EXPECT_EQ(touching.contacts[1].vertex, 50);
  EXPECT_EQ(scene.anchors[4].face, -1);
}

// To and fro over an edge of the ground by 2.5 mm: the first face is not taken a third time.
TEST(Touching, SupportsDoNotChangeForEver) {
  OverGround scene(0.002);
  const int v = 40;
  const auto face_at = [&](double aside) {
    scene.x = scene.sheet.x + same_step(scene.x, Vec<3>(aside, 0, 0));
    scene.contacts.prepare(scene.x, no_step(scene.x));
    return scene.contacts.touching({v}, scene.x, scene.anchors).contacts.at(0).body_face;
  };
  const int first = face_at(0);
  double edge = 0;  // where the ground's face changes
  do {
    scene.contacts.forget();
    ASSERT_LT(edge += 5e-4, 0.02);
  } while (face_at(edge) == first);
  scene.contacts.forget();
  const double left = edge - 0.0015, right = edge + 0.001;
  const int a = face_at(left), b = face_at(right);
  ASSERT_NE(a, b);
  EXPECT_EQ(face_at(left), a);
  EXPECT_EQ(face_at(right), a);
  EXPECT_EQ(face_at(left), a);
  EXPECT_EQ(face_at(left + 0.0045), b);  // it did move on
  scene.contacts.forget();
  EXPECT_EQ(face_at(left), a);
  EXPECT_EQ(face_at(right), b);
}

// As in an armpit: two parts of the body face one another, 4 mm apart.
BodyCollider facing_grounds() {
  const Sheet ground = make_sheet(0.4, 20, 0), above = make_sheet(0.4, 16, 0.004);
  TriangleMesh lower, upper;
  lower.vertices = as_points(ground.x);
  lower.faces = ground.faces;
  upper.vertices = as_points(above.x);
  upper.faces = above.faces.rowwise().reverse();
  const TriangleMesh both = join(lower, upper);
  return {both.vertices, both.faces};
}

// Friction acts on the side that pushes more, but does not change sides for ever.
TEST(Touching, SidesOfAGapDoNotTakeTurnsForEver) {
  const BodyCollider body = facing_grounds();
  const Eigen::VectorXd areas = Eigen::VectorXd::Constant(81, 6e-4);
  Eigen::VectorXd x = make_sheet(0.2, 8, 0.0016).x;
  ContactSearch contacts(make_sheet(0.2, 8, 0).faces, areas, x, body, {}, 0.4);
  std::vector<Anchor> anchors(81);
  const auto normal_at = [&](double height) {
    for (Eigen::Index i = 1; i < x.size(); i += 3) x[i] = height;
    contacts.prepare(x, no_step(x));
    return contacts.touching({40}, x, anchors).frictions.at(0).normal.y();
  };
  EXPECT_GT(normal_at(0.0016), 0.9);
  EXPECT_LT(normal_at(0.0024), -0.9);  // the upper side pushes three times as hard
  EXPECT_LT(normal_at(0.0016), -0.9);
  EXPECT_LT(normal_at(0.0024), -0.9);
  EXPECT_GT(normal_at(0.0012), 0.9);  // more than four times
}

TEST(Touching, BothSidesOfAGapPush) {
  const BodyCollider body = facing_grounds();
  for (const double height : {0.002, 0.0017}) {
    const Sheet sheet = make_sheet(0.2, 8, height);
    const Eigen::VectorXd areas = Eigen::VectorXd::Constant(81, 6e-4);
    ContactSearch contacts(sheet.faces, areas, sheet.x, body, {}, 0.4);
    contacts.prepare(sheet.x, no_step(sheet.x));
    std::vector<Anchor> anchors(81);
    const Touching touching = contacts.touching(all_of(81), sheet.x, anchors);
    EXPECT_EQ(touching.contacts.size(), 162u);
    EXPECT_EQ(touching.frictions.size(), 81u);
    std::vector<Vec<3>> sum(81, Vec<3>::Zero());
    std::vector<double> sizes(81, 0.0);
    for (const Contact& contact : touching.contacts) {
      const Vec<3> push =
          -contact_energy(contact, body, sheet.x.segment<3>(3 * contact.vertex), Order::kGradient)
               .gradient;
      sum[contact.vertex] += push;
      sizes[contact.vertex] += push.norm();
    }
    for (int v = 0; v < 81; ++v) {
      EXPECT_GT(sizes[v], 0.1);
      if (height == 0.002) {
        EXPECT_LE(sum[v].norm(), 1e-9 * sizes[v]);
      } else {
        EXPECT_GT(sum[v].y(), 0.1 * sizes[v]);  // off the nearer side
      }
    }
  }
}

// ---- What lies in the body

// A level cloth in a ball: what is inside, and what crosses, is loose, and pulled to planes.
struct InBall {
  TriangleMesh ball = make_sphere(3, 0.03);
  BodyCollider body{ball.vertices, ball.faces};
  Sheet sheet;
  Eigen::VectorXd x, areas = Eigen::VectorXd::Constant(9, 1e-4);
  std::vector<Anchor> anchors = std::vector<Anchor>(9);
  ContactSearch contacts;

  explicit InBall(double height)
      : sheet(make_sheet(0.1, 2, height)),
        x(sheet.x),
        contacts(sheet.faces, areas, x, body, {}, 0.4) {}
  std::vector<Contact> pulls() {
    std::vector<Contact> flat;
    for (const Contact& contact : contacts.touching(all_of(9), x, anchors).contacts)
      if (contact.is_flat) flat.push_back(contact);
    return flat;
  }
};

TEST(Loose, WhatCameFreeStaysFreeUntilItIsLookedForAnew) {
  InBall scene(0.01);
  Eigen::VectorXd inside = scene.x;
  for (int v = 0; v < 3; ++v) inside[3 * v + 2] -= 0.05;  // a row of three through the middle
  Eigen::VectorXd partly = inside;                        // that row alone, and what hangs on it
  for (int v = 3; v < 9; ++v) partly[3 * v + 1] += 0.05;
  const auto pulls_at = [&](const Eigen::VectorXd& x) {
    scene.x = x;
    scene.contacts.look_around(x);
    return scene.pulls().size();
  };
  const size_t at_first = pulls_at(inside), left = pulls_at(partly);
  EXPECT_GT(left, 0u);
  EXPECT_LT(left, at_first);
  EXPECT_LT(pulls_at(inside), at_first);  // what was free stays so
  Eigen::VectorXd step = no_step(inside);
  scene.contacts.free_share_without_body(inside, step);
  EXPECT_EQ(pulls_at(inside), at_first);  // the body may have moved on
  EXPECT_EQ(pulls_at(partly), left);
  scene.contacts.free_again();
  EXPECT_EQ(pulls_at(inside), at_first);
}

// The way out of the middle of a ball changes with every step; the pull does not.
TEST(Loose, PullsDoNotChangeWithEveryStep) {
  constexpr int kMiddle = 4;
  InBall scene(0);
  scene.contacts.look_around(scene.x);
  const auto pull_at = [&](double height) {
    scene.x[3 * kMiddle + 1] = height;
    for (const Contact& pull : scene.pulls())
      if (pull.vertex == kMiddle) return pull.normal.y();
    ADD_FAILURE() << "no pull";
    return 0.0;
  };
  const double upwards = pull_at(0.0004);
  EXPECT_GT(upwards, 0.5);
  EXPECT_EQ(pull_at(-0.0004), upwards);
  EXPECT_LT(pull_at(-0.003), -0.5);
}

// ---- What is known

TEST(ContactSearch, KnowsAsMuchAsItLookedFor) {
  OverGround scene(0.01);
  const Eigen::VectorXd& x = scene.x;
  const std::vector<int> all = all_of(81);
  ContactSearch fresh(scene.sheet.faces, scene.areas, x, scene.body, scene.config, 0.4);
  EXPECT_EQ(fresh.known_share(all, x, no_step(x)), 0);
  fresh.prepare(x, no_step(x));
  EXPECT_EQ(fresh.search_count(), 1);
  EXPECT_EQ(fresh.known_share(all, x, no_step(x)), 1);
  EXPECT_EQ(fresh.known_share(all, x, same_step(x, {0, -0.001, 0})), 1);
  // Twice as far, half as much.
  const double share = fresh.known_share(all, x, same_step(x, {0, -0.1, 0}));
  EXPECT_GT(share, 0);
  EXPECT_NEAR(fresh.known_share(all, x, same_step(x, {0, -0.2, 0})), share / 2, 1e-12);
  fresh.prepare(x, same_step(x, {0, -0.001, 0}));
  EXPECT_EQ(fresh.search_count(), 1);
  fresh.prepare(x, same_step(x, {0, -0.1, 0}));
  EXPECT_EQ(fresh.search_count(), 2);
  EXPECT_EQ(fresh.known_share(all, x, same_step(x, {0, -0.1, 0})), 1);
  fresh.forget();
  EXPECT_EQ(fresh.known_share(all, x, no_step(x)), 0);
}

TEST(ContactSearch, KnownShareIsThatOfTheVerticesAskedFor) {
  OverGround scene(0.01);
  Eigen::VectorXd step = no_step(scene.x);
  step.segment<3>(30) = Vec<3>(0, 0.1, 0);
  EXPECT_LT(scene.contacts.known_share({9, 10}, scene.x, step), 1);
  EXPECT_EQ(scene.contacts.known_share({9, 11}, scene.x, step), 1);
}

// ---- Barriers

// By all pairs of features there are.
void expect_all_barriers(const DressedBall& scene, const std::vector<ActiveBarrier>& found,
                         const Eigen::VectorXd& x) {
  const int count = scene.cloth.vertex_count;
  std::set<Feature> names;
  for (const ActiveBarrier& barrier : found)
    EXPECT_TRUE(names.insert(named(barrier.element.kind, barrier.element.vertices)).second);
  size_t expected = 0;
  for_each_pair(
      scene.faces, scene.ball.faces, count, [&](PairKind kind, const std::array<int, 4>& vertices) {
        PairPoints points;
        for (int k = 0; k < 4; ++k)
          points.col(k) = vertices[k] < count
                              ? Vec<3>(x.segment<3>(3 * vertices[k]))
                              : Vec<3>(scene.ball.vertices.row(vertices[k] - count).transpose());
        const double range = *std::max_element(vertices.begin(), vertices.end()) < count
                                 ? scene.config.layer_distance_m
                                 : scene.config.barrier_distance_m;
        if (squared_pair_distance(kind, points) >= range * range) return;
        ++expected;
        EXPECT_EQ(names.count(named(kind, vertices)), 1u);
      });
  EXPECT_EQ(found.size(), expected);
  EXPECT_GT(expected, 100u);
}

TEST(ContactSearch, BarriersAreThoseOfAllPairsInRange) {
  DressedBall scene;
  ContactSearch contacts = scene.search();
  contacts.prepare(scene.x, no_step(scene.x));
  const std::vector<int> pairs = contacts.pairs_at(whole(scene.cloth).place);
  expect_all_barriers(scene, contacts.barriers(pairs, scene.x, Order::kValue), scene.x);
  // Also after as many moves as it holds for.
  Eigen::VectorXd moved = scene.x;
  shake(moved, 4e-4, "moved");
  ASSERT_EQ(contacts.known_share(all_of(scene.cloth.vertex_count), moved, no_step(moved)), 1);
  expect_all_barriers(scene, contacts.barriers(pairs, moved, Order::kValue), moved);
}

// Some vertices moved farther than was looked for: of these it looks again, of the others it knows.
TEST(ContactSearch, LooksAgainForWhatMovedFar) {
  DressedBall scene;
  ContactSearch contacts = scene.search();
  contacts.prepare(scene.x, no_step(scene.x));
  Eigen::VectorXd moved = scene.x;
  shake(moved, 3e-4, "moved");
  for (int v = 0; v < scene.cloth.vertex_count; v += 3)
    moved.segment<3>(3 * v) += Vec<3>(0.002, 0.002, 0);
  contacts.prepare(moved, no_step(moved));
  EXPECT_EQ(contacts.search_count(), 2);
  EXPECT_EQ(contacts.known_share(all_of(scene.cloth.vertex_count), moved, no_step(moved)), 1);
  const std::vector<int> pairs = contacts.pairs_at(whole(scene.cloth).place);
  expect_all_barriers(scene, contacts.barriers(pairs, moved, Order::kValue), moved);
  ContactSearch fresh = scene.search();
  fresh.prepare(moved, no_step(moved));
  const auto supports = [&](ContactSearch& search) {
    std::vector<Anchor> anchors(scene.cloth.vertex_count);
    std::vector<std::pair<int, int>> found;
    for (const Contact& contact :
         search.touching(all_of(scene.cloth.vertex_count), moved, anchors).contacts)
      found.emplace_back(contact.vertex, contact.body_face);
    return found;
  };
  EXPECT_EQ(supports(contacts), supports(fresh));
  EXPECT_GT(supports(fresh).size(), 50u);
}

TEST(ContactSearch, BarrierEnergyIsTheirSum) {
  DressedBall scene;
  ContactSearch contacts = scene.search();
  contacts.prepare(scene.x, no_step(scene.x));
  const std::vector<int> pairs = contacts.pairs_at(whole(scene.cloth).place);
  double sum = 0;
  for (const ActiveBarrier& barrier : contacts.barriers(pairs, scene.x, Order::kHessian))
    sum += barrier.term.value;
  EXPECT_GT(sum, 0);
  EXPECT_EQ(contacts.barrier_energy(pairs, scene.x), sum);
}

// Full between edges that cross, none between parallel ones, whose closest points are anywhere.
TEST(ContactSearch, BarriersFadeWhereEdgesAreParallel) {
  DressedBall scene;
  ContactSearch contacts = scene.search();
  contacts.prepare(scene.x, no_step(scene.x));
  const double full = scene.config.barrier_Pa * scene.cloth.area.mean();
  const int count = scene.cloth.vertex_count;
  int blunt = 0;
  for (const ActiveBarrier& barrier :
       contacts.barriers(contacts.pairs_at(whole(scene.cloth).place), scene.x, Order::kValue)) {
    PairPoints points;
    for (int k = 0; k < 4; ++k) {
      const int v = barrier.element.vertices[k];
      points.col(k) = v < count ? Vec<3>(scene.x.segment<3>(3 * v))
                                : Vec<3>(scene.ball.vertices.row(v - count).transpose());
    }
    if (barrier.element.kind == PairKind::kPointFace || squared_sine_of_edges(points) > 0.002) {
      EXPECT_FALSE(barrier_term(barrier.element, points, Order::kGradient).faded);
    } else if (squared_sine_of_edges(points) < 0.0001) {
      EXPECT_TRUE(barrier_term(barrier.element, points, Order::kGradient).faded);
      ++blunt;
    }
    EXPECT_DOUBLE_EQ(barrier.element.stiffness, full);
  }
  EXPECT_GT(blunt, 0);
  // One sheet 1 mm straight above another.
  const Sheet lower = make_sheet(0.1, 4, 1), upper = make_sheet(0.1, 4, 1.001);
  Eigen::VectorXd x(2 * lower.x.size());
  x << lower.x, upper.x;
  Faces faces(2 * lower.faces.rows(), 3);
  faces << lower.faces, lower.faces.array() + 25;
  ContactSearch layers(faces, Eigen::VectorXd::Constant(50, 6e-4), x, scene.body, {}, 0.4);
  layers.prepare(x, no_step(x));
  int parallel = 0;
  for (const ActiveBarrier& barrier :
       layers.barriers(layers.pairs_at(std::vector<int>(50, 0)), x, Order::kValue)) {
    PairPoints points;
    for (int k = 0; k < 4; ++k) points.col(k) = x.segment<3>(3 * barrier.element.vertices[k]);
    if (barrier.element.kind != PairKind::kEdgeEdge || squared_sine_of_edges(points) > 1e-12)
      continue;
    EXPECT_EQ(barrier.term.value, 0);
    ++parallel;
  }
  EXPECT_GT(parallel, 20);
}

TEST(ContactSearch, PairsOfARegionAreThoseWithItsVertices) {
  DressedBall scene;
  ContactSearch contacts = scene.search();
  contacts.prepare(scene.x, no_step(scene.x));
  const Region region = around(scene.cloth, {20}, 1);
  std::set<Feature> expected, found;
  for (const ActiveBarrier& barrier :
       contacts.barriers(contacts.pairs_at(whole(scene.cloth).place), scene.x, Order::kValue))
    for (const int v : barrier.element.vertices)
      if (v < scene.cloth.vertex_count && region.place[v] >= 0)
        expected.insert(named(barrier.element.kind, barrier.element.vertices));
  for (const ActiveBarrier& barrier :
       contacts.barriers(contacts.pairs_at(region.place), scene.x, Order::kValue))
    found.insert(named(barrier.element.kind, barrier.element.vertices));
  EXPECT_GT(expected.size(), 10u);
  const auto less = [](const Feature& a, const Feature& b) { return a < b; };
  EXPECT_TRUE(std::includes(found.begin(), found.end(), expected.begin(), expected.end(), less));
  EXPECT_EQ(found.size(), expected.size());
}

// ---- Free motion

double free_share(OverGround& scene, const Eigen::VectorXd& step) {
  scene.contacts.prepare(scene.x, step);
  return scene.contacts.free_share(scene.contacts.pairs_at(std::vector<int>(81, 0)), scene.x, step);
}

TEST(FreeShare, StopsAtTheGround) {
  for (const double height : {0.01, 0.06})
    for (const double way : {1.01 * height, 5 * height, 3.0}) {
      OverGround scene(height);
      const Eigen::VectorXd step = same_step(scene.x, {0.001, -way, 0});
      const double left = height - free_share(scene, step) * way;
      EXPECT_GT(left, 0.099 * height);  // a tenth of the way to the ground, or a little more
      EXPECT_LT(left, 0.11 * height);
    }
}

TEST(FreeShare, LetsGoWhatMeetsNothing) {
  OverGround scene(0.01);
  for (const Vec<3>& way :
       {Vec<3>(0, 0, 0), Vec<3>(0, 0.5, 0), Vec<3>(0.05, 0, 0.03), Vec<3>(0.04, -0.005, 0)})
    EXPECT_EQ(free_share(scene, same_step(scene.x, way)), 1);
}

// One vertex is enough.
TEST(FreeShare, StopsForASingleVertex) {
  OverGround scene(0.01);
  Eigen::VectorXd step = no_step(scene.x);
  step[3 * 40 + 1] = -0.02;
  const double share = free_share(scene, step);
  EXPECT_GT(share, 0.4);
  EXPECT_LT(share, 0.5);
}

TEST(FreeShare, KeepsACrumpledClothFreeOfIntersections) {
  int stopped = 0;
  for (int i = 0; i < 10; ++i) {
    DressedBall scene;
    ASSERT_FALSE(crosses(scene.x, scene.faces, scene.ball.vertices, scene.ball.faces));
    const Eigen::VectorXd step = 1e-3 * random_vector(scene.x.size(), "step " + std::to_string(i));
    ContactSearch contacts = scene.search();
    contacts.prepare(scene.x, step);
    const double share =
        contacts.free_share(contacts.pairs_at(whole(scene.cloth).place), scene.x, step);
    EXPECT_GT(share, 0);
    EXPECT_FALSE(
        crosses(scene.x + share * step, scene.faces, scene.ball.vertices, scene.ball.faces));
    stopped += crosses(scene.x + step, scene.faces, scene.ball.vertices, scene.ball.faces);
  }
  EXPECT_EQ(stopped, 10);
}

// Beyond it at the end of the step, too.
TEST(FreeShare, LayersDoNotPassThroughOneAnother) {
  DressedBall scene;
  Eigen::VectorXd step = no_step(scene.x);
  for (int v = 0; v < DressedBall::kLayer; ++v)  // the lower one through the upper one
    step.segment<3>(3 * v) = Vec<3>(0, 0.1, 0);
  ContactSearch contacts = scene.search();
  contacts.prepare(scene.x, step);
  const double share =
      contacts.free_share(contacts.pairs_at(whole(scene.cloth).place), scene.x, step);
  EXPECT_LT(share, 0.012);
  EXPECT_FALSE(crosses(scene.x + share * step, scene.faces, scene.ball.vertices, scene.ball.faces));
  EXPECT_EQ(contacts.free_share({}, scene.x, step), 1);
}

// The cloth is made to move with the body that comes at it.
TEST(FreeShareWithBody, TakesTheClothAlong) {
  for (const double way : {0.0101, 0.05, 0.3, 1.0}) {
    OverGround scene(0.01);
    Points3 next = scene.body.vertices();
    next.col(1).array() += way;
    Eigen::VectorXd step = no_step(scene.x);
    EXPECT_EQ(scene.contacts.free_share_with_body(scene.x, next, {}, step), 1);
    EXPECT_FALSE(crosses(scene.x + step, scene.sheet.faces, next, scene.body.faces()));
    for (int v = 0; v < scene.x.size() / 3; ++v)
      EXPECT_GT(scene.x[3 * v + 1] + step[3 * v + 1], next.col(1).maxCoeff());
  }
}

TEST(FreeShareWithBody, LeavesAStepThatIsInNobodysWay) {
  OverGround scene(0.001);
  Points3 next = scene.body.vertices();
  next.rowwise() += Vec<3>(0.1, 0.3, -0.2).transpose();
  for (const Vec<3>& way : {Vec<3>(0.1, 0.3, -0.2), Vec<3>(0.1, 0.35, -0.2)}) {
    Eigen::VectorXd step = same_step(scene.x, way);
    EXPECT_EQ(scene.contacts.free_share_with_body(scene.x, next, {}, step), 1);
    EXPECT_EQ(step, same_step(scene.x, way));
  }
}

struct TwoBalls {
  TwoBalls() {
    const TriangleMesh ball = make_sphere(3, 0.1);
    const int count = static_cast<int>(ball.vertices.rows());
    vertices.resize(2 * count, 3);
    vertices << ball.vertices, ball.vertices;
    vertices.col(1).tail(count).array() += 0.4;
    faces.resize(2 * ball.faces.rows(), 3);
    faces << ball.faces, ball.faces.array() + count;
    sheet = make_sheet(0.6, 12, 0.2);
    shake(sheet.x, 0.005, "sheet");
  }
  Points3 vertices;
  Faces faces;
  Sheet sheet;
};

// What is caught between two parts that close in on it stops them.
TEST(FreeShareWithBody, StopsABodyThatPinchesTheCloth) {
  const TwoBalls scene;
  const BodyCollider body(scene.vertices, scene.faces);
  const Eigen::VectorXd areas = Eigen::VectorXd::Constant(169, 2e-3);
  ContactSearch contacts(scene.sheet.faces, areas, scene.sheet.x, body, {}, 0.4);
  Points3 next = scene.vertices;
  next.col(1).head(next.rows() / 2).array() += 0.15;
  next.col(1).tail(next.rows() / 2).array() -= 0.15;
  Eigen::VectorXd step = no_step(scene.sheet.x);
  const double share = contacts.free_share_with_body(scene.sheet.x, next, {}, step);
  EXPECT_GT(share, 0.3);
  EXPECT_LT(share, 0.7);  // 10 cm of 15 from either side
  const Points3 there = scene.vertices + share * (next - scene.vertices);
  EXPECT_FALSE(crosses(scene.sheet.x + share * step, scene.sheet.faces, there, scene.faces));
  // Told to go on, the body does, through the cloth, which does not cross itself.
  EXPECT_EQ(contacts.free_share_without_body(scene.sheet.x, step), 1);
}

// A body face that is switched off lets cloth through.
TEST(FreeShareWithBody, PassesThroughFacesThatAreOff) {
  OverGround scene(0.01);
  Points3 next = scene.body.vertices();
  next.col(1).array() += 0.05;
  Eigen::VectorXd step = no_step(scene.x);
  const std::vector<char> off(scene.body.faces().rows(), 1);
  EXPECT_EQ(scene.contacts.free_share_with_body(scene.x, next, off, step), 1);
  EXPECT_EQ(step, no_step(scene.x));
}

// ---- Anchors

TEST(SettleAnchors, StayWhileTheClothSticks) {
  OverGround scene(0.002);
  scene.touching();
  const std::vector<Anchor> before = scene.anchors;
  const double slip =
      OverGround::kFriction * scene.pressure(0.002) / scene.config.stick_N_per_m3;  // 9.6 mm
  scene.x += same_step(scene.x, {0.9 * slip, 0, 0});
  scene.contacts.prepare(scene.x, no_step(scene.x));
  scene.contacts.settle_anchors(scene.x, scene.anchors);
  for (int v = 0; v < 81; ++v) {
    EXPECT_EQ(scene.anchors[v].face, before[v].face);
    EXPECT_EQ(scene.anchors[v].barycentric, before[v].barycentric);
  }
}

// So that friction pulls at its limit, and no more, from then on.
TEST(SettleAnchors, FollowWhatSlidToTheSlipLimit) {
  OverGround scene(0.002);
  scene.touching();
  const double slip = OverGround::kFriction * scene.pressure(0.002) / scene.config.stick_N_per_m3;
  const Vec<3> way = 3 * slip * Vec<3>(0.6, 0, 0.8);
  scene.x += same_step(scene.x, way);
  scene.contacts.prepare(scene.x, no_step(scene.x));
  scene.contacts.settle_anchors(scene.x, scene.anchors);
  for (int v = 0; v < 81; ++v) {
    ASSERT_GE(scene.anchors[v].face, 0);
    const Vec<3> anchor = scene.body.point(scene.anchors[v].face, scene.anchors[v].barycentric);
    const Vec<3> foot(scene.x[3 * v], 0, scene.x[3 * v + 2]);
    EXPECT_LE((foot - slip * Vec<3>(0.6, 0, 0.8) - anchor).norm(), 1e-9);
  }
  const std::vector<Anchor> once = scene.anchors;
  scene.contacts.settle_anchors(scene.x, scene.anchors);
  for (int v = 0; v < 81; ++v)
    EXPECT_LE((scene.body.point(once[v].face, once[v].barycentric) -
               scene.body.point(scene.anchors[v].face, scene.anchors[v].barycentric))
                  .norm(),
              1e-9);
}

// On a ball the facets lean away from the smooth surface by more than a vertex slips: what a vertex
// slid against still pulls the same way, at the limit.
TEST(SettleAnchors, LeaveTheForceOnACurvedBody) {
  DressedBall scene;
  ContactSearch contacts(scene.faces, scene.cloth.area, scene.x, scene.body, scene.config, 0.02);
  const std::vector<int> lower = all_of(DressedBall::kLayer);
  contacts.prepare(scene.x, no_step(scene.x));
  contacts.touching(lower, scene.x, scene.anchors);
  Eigen::VectorXd x = scene.x;
  for (const int v : lower) {  // turned about the axis y, up to 7 mm: it sticks for about 2
    const Vec<3> at = x.segment<3>(3 * v);
    x.segment<3>(3 * v) = Eigen::AngleAxisd(0.08, Vec<3>::UnitY()) * at;
  }
  contacts.prepare(x, no_step(x));
  std::vector<Anchor> before = scene.anchors, after = before;
  contacts.settle_anchors(x, after);
  const Touching first = contacts.touching(lower, x, before);
  const Touching second = contacts.touching(lower, x, after);
  ASSERT_EQ(first.frictions.size(), second.frictions.size());
  int slid = 0;
  for (size_t i = 0; i < first.frictions.size(); ++i) {
    const Vec<3> at = x.segment<3>(3 * first.frictions[i].vertex);
    const Vec<3> pull = friction_energy(first.frictions[i], at, Order::kGradient).gradient;
    const Vec<3> still = friction_energy(second.frictions[i], at, Order::kGradient).gradient;
    EXPECT_LE((still - pull).norm(), 0.01 * first.frictions[i].limit);
    slid += before[first.frictions[i].vertex].face != after[first.frictions[i].vertex].face ||
            before[first.frictions[i].vertex].barycentric !=
                after[first.frictions[i].vertex].barycentric;
  }
  EXPECT_GT(slid, 10);
}

// Nothing has slid yet where a vertex first touches.
TEST(Touching, FirstTouchIsFreeOfFriction) {
  DressedBall scene;
  ContactSearch contacts = scene.search();
  contacts.prepare(scene.x, no_step(scene.x));
  const Touching touching = contacts.touching(all_of(DressedBall::kLayer), scene.x, scene.anchors);
  EXPECT_GT(touching.frictions.size(), 50u);
  for (const Friction& friction : touching.frictions) {
    const Vec<3> at = scene.x.segment<3>(3 * friction.vertex);
    EXPECT_LE(friction_energy(friction, at, Order::kGradient).gradient.norm(),
              0.01 * friction.limit + 1e-9);
  }
}

// Told to follow by a share, friction comes closer by it at each look.
TEST(Touching, FrictionFollowsAsFarAsItIsTold) {
  DressedBall scene;
  ContactSearch contacts = scene.search();
  const std::vector<int> lower = all_of(DressedBall::kLayer);
  Eigen::VectorXd x = scene.x;
  const auto look = [&](double share) {
    std::map<int, Friction> result;
    contacts.follow_friction(share);
    contacts.prepare(x, no_step(x));
    for (const Friction& friction : contacts.touching(lower, x, scene.anchors).frictions)
      result.emplace(friction.vertex, friction);
    return result;
  };
  const auto before = look(1);
  for (const int v : lower)  // up to 1 mm, around and into the ball
    x.segment<3>(3 * v) =
        0.9995 * (Eigen::AngleAxisd(0.01, Vec<3>::UnitY()) * scene.x.segment<3>(3 * v));
  const auto once = look(0.3), twice = look(0.3), there = look(1);
  int seen = 0;
  for (const auto& [v, from] : before) {
    const Friction &to = there.at(v), &a = once.at(v), &b = twice.at(v);
    const double way = (to.normal - from.normal).norm();
    if (way < 1e-3) continue;
    EXPECT_NEAR((a.normal - from.normal).norm(), 0.3 * way, 1e-3 * way);
    EXPECT_NEAR((b.normal - from.normal).norm(), 0.51 * way, 1e-3 * way);
    EXPECT_NEAR(a.limit, from.limit + 0.3 * (to.limit - from.limit), 1e-12);
    EXPECT_NEAR(b.limit, from.limit + 0.51 * (to.limit - from.limit), 1e-12);
    ++seen;
  }
  EXPECT_GT(seen, 50);
}

TEST(SettleAnchors, AreDroppedWhereTheClothLeaves) {
  OverGround scene(0.002);
  scene.touching();
  scene.x[3 * 7 + 1] = 0.004;
  scene.contacts.prepare(scene.x, no_step(scene.x));
  scene.contacts.settle_anchors(scene.x, scene.anchors);
  for (int v = 0; v < 81; ++v) EXPECT_EQ(scene.anchors[v].face >= 0, v != 7) << v;
}

}  // namespace
}  // namespace pleat::sim
