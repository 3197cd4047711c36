#include "garment/design_map.h"

#include <cmath>
#include <vector>

namespace pleat::garment {
namespace {

constexpr int kSteps = 10;
constexpr double kOnOutline = 2e-6;  // m; UVs may have been stored as float

using Point = Eigen::Vector2d;

double cross(const Point& a, const Point& b) { return a.x() * b.y() - a.y() * b.x(); }

Design blend(const Design& a, const Design& b, double t) {
  Design c;
  c.length = (1 - t) * a.length + t * b.length;
  c.sleeve = (1 - t) * a.sleeve + t * b.sleeve;
  c.cleavage = (1 - t) * a.cleavage + t * b.cleavage;
  return c;
}

// Where on the polygon p lies, as segment + fraction; -1 where it lies off the outline.
double outline_parameter(const Points2& polygon, const Point& p) {
  const Eigen::Index n = polygon.rows();
  double nearest = kOnOutline * kOnOutline, parameter = -1;
  for (Eigen::Index i = 0; i < n; ++i) {
    const Point a = polygon.row(i), d = Point(polygon.row((i + 1) % n)) - a;
    const double t = std::min(1.0, std::max(0.0, (p - a).dot(d) / d.squaredNorm()));
    const double squared = (p - a - t * d).squaredNorm();
    if (squared < nearest) {
      nearest = squared;
      parameter = static_cast<double>(i) + t;
    }
  }
  return parameter;
}

// Mean value mapping of p, inside `from`, to `to` (Hormann and Floater 2006, eq. 11 and 13).
Point mean_value_map(const Points2& from, const Points2& to, const Point& p) {
  const Eigen::Index n = from.rows();
  Point sum = Point::Zero();
  double total = 0;
  Point a = Point(from.row(n - 1)) - p;
  double length_a = a.norm();
  Eigen::Index previous = n - 1;
  for (Eigen::Index i = 0; i < n; ++i) {
    const Point b = Point(from.row(i)) - p;
    const double length_b = b.norm();
    // tan(alpha / 2) of the angle under which the segment is seen.
    const double half_tangent = cross(a, b) / (length_a * length_b + a.dot(b));
    sum += half_tangent * (Point(to.row(previous)) / length_a + Point(to.row(i)) / length_b);
    total += half_tangent * (1 / length_a + 1 / length_b);
    a = b;
    length_a = length_b;
    previous = i;
  }
  return sum / total;
}

Points2 map_torso(Panel panel, const Eigen::Ref<const Points2>& points, const Design& design) {
  std::vector<Points2> polygons;
  for (int k = 0; k <= kSteps; ++k)
    polygons.push_back(
        outline(panel, blend(reference_design(), design, static_cast<double>(k) / kSteps)));
  const Points2& last = polygons.back();
  Points2 mapped(points.rows(), 2);
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    Point p = points.row(i);
    const double parameter = outline_parameter(polygons.front(), p);
    if (parameter >= 0) {
      const Eigen::Index segment = static_cast<Eigen::Index>(parameter) % last.rows();
      const double t = parameter - std::floor(parameter);
      p = (1 - t) * last.row(segment) + t * last.row((segment + 1) % last.rows());
    } else {
      for (int k = 0; k < kSteps; ++k) p = mean_value_map(polygons[k], polygons[k + 1], p);
    }
    mapped.row(i) = p;
  }
  return mapped;
}

// A sleeve is ruled by lines from its cap to its hem, between places at the same fraction of each
// curve's length.
struct RuledSleeve {
  Points2 cap, hem;  // kCurveSegments + 1 each, from the middle outwards
  explicit RuledSleeve(const Design& design) {
    const Points2 half = half_outline(Panel::kLeftSleeve, design);
    hem = half.topRows(kCurveSegments + 1);
    cap = half.bottomRows(kCurveSegments + 1).colwise().reverse();
  }
  Point at(int segment, double s, double depth) const {  // s, depth in [0, 1]
    const Point on_cap = (1 - s) * cap.row(segment) + s * cap.row(segment + 1);
    const Point on_hem = (1 - s) * hem.row(segment) + s * hem.row(segment + 1);
    return (1 - depth) * on_cap + depth * on_hem;
  }
};

Points2 map_sleeve(const Eigen::Ref<const Points2>& points, const Design& design) {
  const RuledSleeve from(reference_design()), to(design);
  Points2 mapped(points.rows(), 2);
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const Point p(std::abs(points(i, 0)), points(i, 1));
    int segment = 0;  // the ruling at its inner end passes p on the inside
    while (segment + 1 < kCurveSegments &&
           cross(Point(from.hem.row(segment + 1)) - Point(from.cap.row(segment + 1)),
                 p - Point(from.cap.row(segment + 1))) > 0)
      ++segment;
    // The ruling through p: cross(cap(s) - p, hem(s) - p) = 0, quadratic in s.
    const Point a = Point(from.cap.row(segment)) - p, d = Point(from.hem.row(segment)) - p;
    const Point b = from.cap.row(segment + 1) - from.cap.row(segment);
    const Point e = from.hem.row(segment + 1) - from.hem.row(segment);
    const double q0 = cross(a, d), q1 = cross(a, e) + cross(b, d), q2 = cross(b, e);
    const double root = std::sqrt(std::max(0.0, q1 * q1 - 4 * q2 * q0));
    const double s = -2 * q0 / (q1 + std::copysign(root, q1));
    const Point on_cap = from.at(segment, s, 0), ruling = from.at(segment, s, 1) - on_cap;
    mapped.row(i) = to.at(segment, s, (p - on_cap).dot(ruling) / ruling.squaredNorm());
    if (points(i, 0) < 0) mapped(i, 0) *= -1;
  }
  return mapped;
}

}  // namespace

Points2 map_to_design(Panel panel, const Eigen::Ref<const Points2>& points, const Design& design) {
  return is_sleeve(panel) ? map_sleeve(points, design) : map_torso(panel, points, design);
}

}  // namespace pleat::garment
