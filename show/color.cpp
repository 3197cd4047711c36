#include "show/color.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace pleat::show {

const Color kBodyColor(0.88, 0.84, 0.80);
const Color kSimulatedColor(0.45, 0.58, 0.72);
const Color kReconstructedColor(0.45, 0.66, 0.61);
const Color kSampledColor(0.85, 0.58, 0.46);
const Color kNotFiniteColor(1.0, 0.0, 1.0);

namespace {

// OKLab: B. Ottosson 2020, "A perceptual color space for image processing".
Color linear_from_oklab(const Vec<3>& lab) {
  const double l = lab[0] + 0.3963377774 * lab[1] + 0.2158037573 * lab[2];
  const double m = lab[0] - 0.1055613458 * lab[1] - 0.0638541728 * lab[2];
  const double s = lab[0] - 0.0894841775 * lab[1] - 1.2914855480 * lab[2];
  const double l3 = l * l * l, m3 = m * m * m, s3 = s * s * s;
  return {4.0767416621 * l3 - 3.3077115913 * m3 + 0.2309699292 * s3,
          -1.2684380046 * l3 + 2.6097574011 * m3 - 0.3413193965 * s3,
          -0.0041960863 * l3 - 0.7034186147 * m3 + 1.7076147010 * s3};
}

// The scale's path before its steps are made equal. Chroma peaks in the middle, where sRGB has room
// for it.
Vec<3> heat_path(double s) {
  const double lightness = 0.94 - 0.66 * s;
  const double chroma = 0.03 + 0.08 * s + 0.36 * s * (1 - s);
  const double hue = (95 - 130 * s) * M_PI / 180;
  return {lightness, chroma * std::cos(hue), chroma * std::sin(hue)};
}

constexpr int kSteps = 256;
using HeatTable = std::array<Color, kSteps + 1>;  // sRGB

HeatTable make_heat_table() {
  constexpr int kFine = 8192;
  std::vector<double> length(kFine + 1, 0.0);
  for (int i = 1; i <= kFine; ++i) {
    const Vec<3> step = heat_path(double(i) / kFine) - heat_path(double(i - 1) / kFine);
    length[i] = length[i - 1] + step.norm();
  }
  HeatTable table;
  int fine = 0;
  for (int i = 0; i <= kSteps; ++i) {
    while (fine < kFine && length[fine] < length[kFine] * i / kSteps) ++fine;
    table[i] = srgb_from_linear(linear_from_oklab(heat_path(double(fine) / kFine)));
  }
  return table;
}

}  // namespace

// IEC 61966-2-1.
Color linear_from_srgb(const Color& color) {
  return color.unaryExpr(
      [](double c) { return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4); });
}

Color srgb_from_linear(const Color& light) {
  return light.unaryExpr([](double value) {
    const double c = std::clamp(value, 0.0, 1.0);
    return c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1 / 2.4) - 0.055;
  });
}

Color heat_color(double t) {
  if (!std::isfinite(t)) return kNotFiniteColor;
  static const HeatTable table = make_heat_table();
  const double position = std::clamp(t, 0.0, 1.0) * kSteps;
  const int i = std::min(int(position), kSteps - 1);
  return table[i] + (position - i) * (table[i + 1] - table[i]);
}

std::vector<Color> heat_colors(const Eigen::Ref<const Eigen::VectorXd>& values, double value_at_1) {
  std::vector<Color> colors(values.size());
  for (int i = 0; i < values.size(); ++i) colors[i] = heat_color(values[i] / value_at_1);
  return colors;
}

}  // namespace pleat::show
