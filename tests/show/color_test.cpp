#include "show/color.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace pleat::show {
namespace {

// CIELAB, D65: another measure of distance than the one that the scale is built on.
Vec<3> cielab(const Color& color) {
  Mat<3> xyz_from_rgb;
  xyz_from_rgb << 0.4124, 0.3576, 0.1805, 0.2126, 0.7152, 0.0722, 0.0193, 0.1192, 0.9505;
  const Vec<3> xyz =
      (xyz_from_rgb * linear_from_srgb(color)).cwiseQuotient(Vec<3>(0.9505, 1, 1.089));
  const Vec<3> f =
      xyz.unaryExpr([](double t) { return t > 0.008856 ? std::cbrt(t) : 7.787 * t + 16.0 / 116; });
  return {116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])};
}

TEST(Srgb, GoesToLinearLightAndBack) {
  EXPECT_NEAR(linear_from_srgb(Color::Constant(0.5))[0], 0.2140, 1e-4);  // IEC 61966-2-1
  for (double c = 0; c <= 1; c += 0.01) {
    EXPECT_NEAR(srgb_from_linear(linear_from_srgb(Color::Constant(c)))[1], c, 1e-6);
  }
}

TEST(HeatColor, GrowsDarkerThroughoutInEvenSteps) {
  constexpr int kSteps = 32;
  double shortest = 1e9, longest = 0;
  for (int i = 0; i < kSteps; ++i) {
    const Vec<3> here = cielab(heat_color(double(i) / kSteps));
    const Vec<3> next = cielab(heat_color(double(i + 1) / kSteps));
    EXPECT_LT(next[0], here[0]) << i;
    shortest = std::min(shortest, (next - here).norm());
    longest = std::max(longest, (next - here).norm());
  }
  // CIELAB and OKLab disagree by about 2 over this range of hues; a channel clipped by sRGB would
  // show as far more.
  EXPECT_LT(longest / shortest, 3);
}

TEST(HeatColor, StaysInsideSrgb) {
  for (int i = 0; i <= 256; ++i) {
    const Color color = heat_color(i / 256.0);
    EXPECT_GT(color.minCoeff(), 0) << i;  // 0 or 1 exactly would be a clipped channel
    EXPECT_LT(color.maxCoeff(), 1) << i;
  }
}

TEST(HeatColors, ClampsAndMarksWhatIsNotFinite) {
  Eigen::VectorXd values(4);
  values << -1, 0.002, 7, std::numeric_limits<double>::quiet_NaN();
  const std::vector<Color> colors = heat_colors(values, 0.004);
  EXPECT_EQ(colors[0], heat_color(0));
  EXPECT_EQ(colors[1], heat_color(0.5));
  EXPECT_EQ(colors[2], heat_color(1));
  EXPECT_EQ(colors[3], kNotFiniteColor);
}

}  // namespace
}  // namespace pleat::show
