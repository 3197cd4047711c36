// Colours, and the colour scale for errors.
#pragma once

#include <vector>

#include "core/types.h"

namespace pleat::show {

using Color = Vec<3>;  // sRGB as on screen, each channel in [0, 1]

Color linear_from_srgb(const Color& color);  // to linear light
Color srgb_from_linear(const Color& light);  // clamped to [0, 1] first

// What every picture and chart means by a colour.
extern const Color kBodyColor;
extern const Color kSimulatedColor;
extern const Color kReconstructedColor;
extern const Color kSampledColor;
extern const Color kNotFiniteColor;  // stands out where a number is NaN or infinite

// Scale for a quantity with a natural zero: cream at 0, through orange and red, to dark violet at
// 1; clamped. Equal steps of `t` are equal distances in OKLab, and lightness falls throughout, so
// that it also reads in grey.
Color heat_color(double t);

// heat_color(value / value_at_1) for each value.
std::vector<Color> heat_colors(const Eigen::Ref<const Eigen::VectorXd>& values, double value_at_1);

}  // namespace pleat::show
