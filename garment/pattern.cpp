#include "garment/pattern.h"

#include <Eigen/Geometry>
#include <cmath>
#include <functional>

namespace pleat::garment {
namespace {

// Measures of the block, m. Sized for a chest of 0.96 m with 0.10 m of ease, on a body 1.66 m tall
// in the T-pose.
constexpr double kShortest = 0.42, kLongest = 0.98;  // shoulder-neck point to hem
constexpr double kChestHalfWidth = 0.265;            // of one panel
constexpr double kFlareStart = 0.25,
                 kFlareWidth = 0.085;  // depth where it begins; added by kLongest
constexpr double kUnderarmDepth = 0.235;
constexpr double kShoulderX = 0.165,
                 kShoulderDrop = 0.028;  // top of the armhole, inside the shoulder point
constexpr double kNeckHalfWidth = 0.080, kNeckWidening = 0.020;
constexpr double kHighestNeck = 0.070, kDeepestNeck = 0.200;  // front
constexpr double kBackNeck = 0.018, kBackNeckDeepening = 0.014;
constexpr double kSleeveHalfWidth = 0.205, kWristHalfWidth = 0.105;
constexpr double kShortestSleeve = 0.040, kLongestSleeve = 0.500;  // top of the armhole to the hem

using Point = Eigen::Vector2d;
using ParametricCurve = std::function<Point(double)>;  // over [0, 1]

ParametricCurve line(const Point& a, const Point& b) {
  return [=](double t) -> Point { return (1 - t) * a + t * b; };
}

ParametricCurve bezier(const Point& a, const Point& b, const Point& c, const Point& d) {
  return [=](double t) -> Point {
    const double s = 1 - t;
    return s * s * s * a + 3 * s * s * t * b + 3 * s * t * t * c + t * t * t * d;
  };
}

// kCurveSegments + 1 points at equal fractions of the curve's length.
Points2 resample(const ParametricCurve& curve) {
  constexpr int kFine = 32 * kCurveSegments;
  Points2 fine(kFine + 1, 2);
  Eigen::VectorXd length = Eigen::VectorXd::Zero(kFine + 1);
  for (int i = 0; i <= kFine; ++i) {
    fine.row(i) = curve(static_cast<double>(i) / kFine);
    if (i > 0) length[i] = length[i - 1] + (fine.row(i) - fine.row(i - 1)).norm();
  }
  Points2 points(kCurveSegments + 1, 2);
  points.row(0) = fine.row(0);
  points.row(kCurveSegments) = fine.row(kFine);
  for (int k = 1, i = 0; k < kCurveSegments; ++k) {
    const double target = length[kFine] * k / kCurveSegments;
    while (length[i + 1] < target) ++i;
    const double t = (target - length[i]) / (length[i + 1] - length[i]);
    points.row(k) = (1 - t) * fine.row(i) + t * fine.row(i + 1);
  }
  return points;
}

double polyline_length(const Points2& points) {
  const Eigen::Index n = points.rows() - 1;
  return (points.bottomRows(n) - points.topRows(n)).rowwise().norm().sum();
}

Points2 join(const std::vector<Points2>& curves) {
  Points2 points(static_cast<Eigen::Index>(curves.size()) * kCurveSegments + 1, 2);
  for (size_t k = 0; k < curves.size(); ++k)
    points.middleRows(static_cast<Eigen::Index>(k) * kCurveSegments, kCurveSegments + 1) =
        curves[k];
  points(0, 0) = points(points.rows() - 1, 0) = 0;  // on the axis, exactly
  return points;
}

// Half width of the torso and its growth with depth below the shoulder-neck point.
double half_width(double depth) {
  const double t = std::max(0.0, depth - kFlareStart) / (kLongest - kFlareStart);
  return kChestHalfWidth + kFlareWidth * t * t;
}
double flare(double depth) {
  const double t = std::max(0.0, depth - kFlareStart) / (kLongest - kFlareStart);
  return 2 * kFlareWidth * t / (kLongest - kFlareStart);
}

Points2 armhole() {
  const Point underarm(kChestHalfWidth, -kUnderarmDepth), top(kShoulderX, -kShoulderDrop);
  return resample(bezier(underarm, underarm + Point(-0.080, 0), top + Point(-0.012, -0.110), top));
}

Points2 half_torso(Panel panel, const Design& design) {
  const double length = kShortest + (kLongest - kShortest) * design.length;
  // The hem meets the side seam at a right angle, so that it hangs level: y = -length + rise (x /
  // width)^2.
  const double rise = 0.5 * half_width(length) * flare(length);
  const double side_depth = length - rise, width = half_width(side_depth);
  const ParametricCurve hem = [=](double t) { return Point(width * t, -length + rise * t * t); };
  const ParametricCurve side = [=](double t) {
    const double depth = side_depth + t * (kUnderarmDepth - side_depth);
    return Point(half_width(depth), -depth);
  };
  // The shoulder-neck point moves along the shoulder seam as the neckline widens.
  const double neck_x = kNeckHalfWidth + kNeckWidening * design.cleavage;
  const Point shoulder(kShoulderX, -kShoulderDrop);
  const Point neck(neck_x,
                   -kShoulderDrop * (neck_x - kNeckHalfWidth) / (kShoulderX - kNeckHalfWidth));
  const double depth = panel == Panel::kFront
                           ? kHighestNeck + (kDeepestNeck - kHighestNeck) * design.cleavage
                           : kBackNeck + kBackNeckDeepening * design.cleavage;
  const Point middle(0, -depth);
  const double drop = depth + neck.y();  // of the middle below the shoulder-neck point
  const ParametricCurve neckline = panel == Panel::kFront
                                       ? bezier(neck, neck - Point(0.05 * neck_x, 0.50 * drop),
                                                middle + Point(0.60 * neck_x, 0), middle)
                                       : bezier(neck, neck - Point(0.30 * neck_x, 0.80 * drop),
                                                middle + Point(0.60 * neck_x, 0), middle);
  return join({resample(hem), resample(side), armhole(), resample(line(shoulder, neck)),
               resample(neckline)});
}

Points2 cap(double height) {
  const double b = kSleeveHalfWidth;
  return resample(bezier(Point(b, 0), Point(b - 0.065, 0), Point(0.075, height), Point(0, height)));
}

// The height at which the cap is as long as the armhole.
double cap_height() {
  static const double height = [] {
    const double target = polyline_length(armhole());
    double low = 0, high = kUnderarmDepth;
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (low + high);
      (polyline_length(cap(middle)) < target ? low : high) = middle;
    }
    return 0.5 * (low + high);
  }();
  return height;
}

Points2 half_sleeve(const Design& design) {
  const double length = kShortestSleeve + (kLongestSleeve - kShortestSleeve) * design.sleeve;
  // A sleeveless design ends in a strip along the armhole: its hem copies the cap. Longer sleeves
  // end straight.
  const double bow = cap_height() * std::pow(1 - design.sleeve, 4);
  const double underarm = length - cap_height() + bow;  // length of the underarm seam
  const double longest_underarm = kLongestSleeve - cap_height();
  const double taper = (kSleeveHalfWidth - kWristHalfWidth) / longest_underarm;
  const double hem_half_width = kSleeveHalfWidth - taper * underarm;
  Points2 hem = cap(cap_height()).colwise().reverse();  // from the middle outwards
  hem.col(0) *= hem_half_width / kSleeveHalfWidth;
  hem.col(1) = (hem.col(1).array() * bow / cap_height() - underarm).matrix();
  // Equal segments again: the copy is not to scale.
  const ParametricCurve hem_curve = [hem](double t) -> Point {
    const int i = std::min(static_cast<int>(t * kCurveSegments), kCurveSegments - 1);
    const double s = t * kCurveSegments - i;
    return (1 - s) * hem.row(i).transpose() + s * hem.row(i + 1).transpose();
  };
  return join({resample(hem_curve),
               resample(line(Point(hem_half_width, -underarm), Point(kSleeveHalfWidth, 0))),
               cap(cap_height())});
}

}  // namespace

std::vector<Curve> curves_of(Panel panel) {
  if (is_sleeve(panel)) return {Curve::kHem, Curve::kSide, Curve::kArmhole};
  return {Curve::kHem, Curve::kSide, Curve::kArmhole, Curve::kShoulder, Curve::kNeckline};
}

Points2 half_outline(Panel panel, const Design& design) {
  return is_sleeve(panel) ? half_sleeve(design) : half_torso(panel, design);
}

Points2 outline(Panel panel, const Design& design) {
  const Points2 half = half_outline(panel, design);
  const Eigen::Index n = half.rows();
  Points2 whole(2 * n - 2, 2);
  whole.topRows(n) = half;
  for (Eigen::Index i = 1; i + 1 < n; ++i)
    whole.row(2 * n - 2 - i) = Eigen::RowVector2d(-half(i, 0), half(i, 1));
  return whole;
}

Design reference_design() { return {"reference", 0.28, 0.42, 0.50, false}; }

}  // namespace pleat::garment
