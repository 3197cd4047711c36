#include "encode/error_summary.h"

#include <gtest/gtest.h>

namespace pleat::encode {
namespace {

TEST(ErrorSummary, KnowsMeanMaxAndPercentiles) {
  ErrorSummary low, high;
  for (int i = 1; i <= 500; ++i) low.add(0.01 * i);
  for (int i = 501; i <= 1000; ++i) high.add(0.01 * i);
  high.add(low);
  EXPECT_EQ(high.count(), 1000);
  EXPECT_NEAR(high.mean(), 5.005, 1e-9);
  EXPECT_EQ(high.max(), 10);
  EXPECT_NEAR(high.percentile(95), 9.5, 0.01 * 9.5);  // bins are 1 % wide
  EXPECT_NEAR(high.percentile(50), 5.0, 0.01 * 5.0);
  EXPECT_EQ(high.percentile(100), 10);
}

TEST(ErrorSummary, OfExactMatchesIsZero) {
  ErrorSummary summary;
  EXPECT_EQ(summary.mean(), 0);
  EXPECT_EQ(summary.percentile(99), 0);
  summary.add(0);
  EXPECT_EQ(summary.percentile(99), 0);
}

TEST(ErrorSummary, DistancesAreInMillimetres) {
  Points3 a = Points3::Zero(1, 3), b = a;
  b.row(0) << 0.003, 0.004, 0;
  EXPECT_DOUBLE_EQ(vertex_distances_mm(a, b)[0], 5);
}

}  // namespace
}  // namespace pleat::encode
