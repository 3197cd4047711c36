#include "core/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace pleat {
namespace {

// Computed apart from this code, by the Python lines in the comment:
//   s = [int.from_bytes(hashlib.sha256((42).to_bytes(8, "little") +
//   b"shape/3").digest()[8*k:8*k+8], "big")
//        for k in range(4)]
//   then xoshiro256** on s by its published definition.
TEST(RandomStream, GivesItsReferenceValues) {
  RandomStream random(42, "shape/3");
  EXPECT_EQ(random.next(), UINT64_C(3504306002135134807));
  EXPECT_EQ(random.next(), UINT64_C(16810630981151670641));
  EXPECT_EQ(random.next(), UINT64_C(7736144356236043490));
  EXPECT_EQ(random.next(), UINT64_C(15988152174009359728));
}

// From the same numbers by the polar method with Python's math.log: the portable logarithm agrees.
TEST(RandomStream, GivesItsReferenceNormals) {
  RandomStream random(42, "shape/3");
  EXPECT_NEAR(random.normal(), -0.2298255011892562, 1e-14);
  EXPECT_NEAR(random.normal(), 1.0453806136864432, 1e-14);
  EXPECT_NEAR(random.normal(), 1.89482755388583, 1e-14);
  EXPECT_NEAR(random.normal(), -0.33373051619210964, 1e-14);
  EXPECT_NEAR(random.normal(), -1.5787904061226978, 1e-14);
  EXPECT_NEAR(random.normal(), 0.3950783452159935, 1e-14);
}

TEST(RandomStream, IsRepeatable) {
  RandomStream a(1, "clip/walk/7"), b(1, "clip/walk/7");
  for (int k = 0; k < 100; ++k) ASSERT_EQ(a.next(), b.next());
}

double correlation(RandomStream a, RandomStream b) {
  constexpr int kCount = 20000;
  double sum = 0;
  for (int k = 0; k < kCount; ++k) sum += (a.uniform() - 0.5) * (b.uniform() - 0.5) * 12;
  return sum / kCount;
}

// The standard deviation of the estimate is 1 / sqrt(20000) = 0.007; five of them.
TEST(RandomStream, IsIndependentOfStreamsWithOtherSeedsOrNames) {
  const RandomStream base(1, "clip/1");
  EXPECT_NEAR(correlation(base, base), 1, 0.036);
  EXPECT_NEAR(correlation(base, RandomStream(2, "clip/1")), 0, 0.036);
  EXPECT_NEAR(correlation(base, RandomStream(1, "clip/2")), 0, 0.036);
  EXPECT_NEAR(correlation(base, RandomStream(1, "clip/11")), 0, 0.036);
}

TEST(RandomStream, UniformsFillTheUnitInterval) {
  RandomStream random(3, "uniform");
  std::vector<int> counts(10, 0);
  for (int k = 0; k < 100000; ++k) {
    const double x = random.uniform();
    ASSERT_GE(x, 0);
    ASSERT_LT(x, 1);
    ++counts[static_cast<int>(10 * x)];
  }
  for (const int count : counts) EXPECT_NEAR(count, 10000, 500);  // five standard deviations: 475
}

TEST(RandomStream, NormalsHaveTheMomentsOfANormal) {
  RandomStream random(3, "normal");
  constexpr int kCount = 200000;
  double sum = 0, square = 0, fourth = 0;
  for (int k = 0; k < kCount; ++k) {
    const double x = random.normal();
    sum += x;
    square += x * x;
    fourth += x * x * x * x;
  }
  // Five standard deviations: 1, sqrt 2 and sqrt 96 over sqrt(200000).
  EXPECT_NEAR(sum / kCount, 0, 0.0112);
  EXPECT_NEAR(square / kCount, 1, 0.0159);
  EXPECT_NEAR(fourth / kCount, 3, 0.11);
}

TEST(RandomStream, BelowGivesEveryValueAlikeOften) {
  RandomStream random(3, "below");
  std::vector<int> counts(7, 0);
  for (int k = 0; k < 70000; ++k) {
    const int64_t value = random.below(7);
    ASSERT_GE(value, 0);
    ASSERT_LT(value, 7);
    ++counts[value];
  }
  for (const int count : counts) EXPECT_NEAR(count, 10000, 500);
  // Three quarters of the range of 64 bits: without rejection, a third of the results would double.
  const int64_t bound = INT64_C(3) << 61;
  int low = 0;
  for (int k = 0; k < 30000; ++k) low += random.below(bound) < bound / 3;
  EXPECT_NEAR(low, 10000, 410);
}

TEST(RandomStream, PermutesEveryElementToEveryPlace) {
  RandomStream random(3, "permutation");
  std::vector<std::vector<int>> counts(4, std::vector<int>(4, 0));
  for (int k = 0; k < 24000; ++k) {
    std::vector<int64_t> order = random.permutation(4);
    for (int place = 0; place < 4; ++place) ++counts[place][order[place]];
    std::sort(order.begin(), order.end());
    ASSERT_EQ(order, (std::vector<int64_t>{0, 1, 2, 3}));
  }
  for (const auto& row : counts) {
    for (const int count : row) EXPECT_NEAR(count, 6000, 340);
  }
}

}  // namespace
}  // namespace pleat
