#include "garment/panel_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "garment/pattern.h"

extern "C" {
#include <libqhull_r/libqhull_r.h>
}

namespace pleat::garment {
namespace {

constexpr double kBoundaryClearance = 0.6;  // of lattice points from the outline, in spacings
constexpr int kRelaxations = 8;

using Point = Eigen::Vector2d;

double cross(const Point& a, const Point& b) { return a.x() * b.y() - a.y() * b.x(); }

// Closed counter-clockwise polygon of half a panel: the half outline, then down the axis.
bool is_inside(const Points2& polygon, const Point& p) {
  bool inside = false;
  for (Eigen::Index i = 0, j = polygon.rows() - 1; i < polygon.rows(); j = i++) {
    if ((polygon(i, 1) > p.y()) == (polygon(j, 1) > p.y())) continue;
    const double t = (p.y() - polygon(i, 1)) / (polygon(j, 1) - polygon(i, 1));
    if (p.x() < polygon(i, 0) + t * (polygon(j, 0) - polygon(i, 0))) inside = !inside;
  }
  return inside;
}

double distance(const Points2& polyline, const Point& p) {
  double squared = std::numeric_limits<double>::max();
  for (Eigen::Index i = 0; i + 1 < polyline.rows(); ++i) {
    const Point a = polyline.row(i), d = Point(polyline.row(i + 1)) - a;
    const double t = std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0);
    squared = std::min(squared, (p - a - t * d).squaredNorm());
  }
  return std::sqrt(squared);
}

int segment_count(double length, double spacing) {
  return std::max(2, static_cast<int>(std::lround(length / spacing)));
}

// Points of the half panel in this order: its curves, the axis from top to bottom without its ends,
// the interior.
struct HalfPoints {
  std::vector<Point> points;
  std::vector<int> segments;  // of each curve
  int outline_count = 0;      // points on the curves
  int axis_count = 0;         // points inside the axis
};

HalfPoints half_points(const Points2& half_outline, double spacing) {
  HalfPoints half;
  const Eigen::Index curve_count = (half_outline.rows() - 1) / kCurveSegments;
  for (Eigen::Index c = 0; c < curve_count; ++c) {
    const Points2 curve = half_outline.middleRows(c * kCurveSegments, kCurveSegments + 1);
    double length = 0;
    for (int i = 0; i < kCurveSegments; ++i) length += (curve.row(i + 1) - curve.row(i)).norm();
    // Rounded first, so that sewn curves, equal in length but for the last bits, are cut alike.
    const int n = segment_count(std::round(length * 1e6) * 1e-6, spacing);
    half.segments.push_back(n);
    for (int k = 0; k < n; ++k) {
      const double t = static_cast<double>(k) * kCurveSegments / n;
      const int i = static_cast<int>(t);
      half.points.push_back((1 - (t - i)) * curve.row(i) + (t - i) * curve.row(i + 1));
    }
  }
  half.points.push_back(half_outline.bottomRows(1).transpose());
  half.outline_count = static_cast<int>(half.points.size());
  const double bottom = half_outline(0, 1), top = half_outline(half_outline.rows() - 1, 1);
  const int n = segment_count(top - bottom, spacing);
  half.axis_count = n - 1;
  for (int k = 1; k < n; ++k) half.points.emplace_back(0, top + (bottom - top) * k / n);

  // Lattice columns run along the axis, so that the two halves make one lattice.
  const double column = spacing * std::sqrt(3.0) / 2, row = (top - bottom) / n;
  const double width = half_outline.col(0).maxCoeff();
  const double lowest = half_outline.col(1).minCoeff(), highest = half_outline.col(1).maxCoeff();
  for (int i = 1; i * column < width; ++i) {
    const double shift = bottom + (i % 2 ? 0.5 : 0.0) * row;
    for (int j = static_cast<int>(std::floor((lowest - shift) / row)); shift + j * row < highest;
         ++j) {
      const Point p(i * column, shift + j * row);
      if (is_inside(half_outline, p) && distance(half_outline, p) > kBoundaryClearance * spacing)
        half.points.push_back(p);
    }
  }
  return half;
}

// Delaunay triangulation of all points, counter-clockwise, by Qhull.
std::vector<std::array<int, 3>> delaunay(const std::vector<Point>& points) {
  qhT context;
  qhT* qh = &context;
  qh_zero(qh, stderr);
  std::vector<coordT> coordinates;
  coordinates.reserve(2 * points.size());
  for (const Point& p : points) coordinates.insert(coordinates.end(), {p.x(), p.y()});
  char command[] = "qhull d Qt Qbb Qc";
  const int failed = qh_new_qhull(qh, 2, static_cast<int>(points.size()), coordinates.data(), False,
                                  command, nullptr, nullptr);
  std::vector<std::array<int, 3>> triangles;
  if (!failed) {
    facetT* facet;
    FORALLfacets {
      if (facet->upperdelaunay || !facet->simplicial) continue;
      std::array<int, 3> triangle{};
      int k = 0;
      vertexT *vertex, **vertexp;
      FOREACHvertex_(facet->vertices) triangle[k++] = qh_pointid(qh, vertex->point);
      triangles.push_back(triangle);
    }
  }
  qh_freeqhull(qh, !qh_ALL);
  int current_long = 0, total_long = 0;
  qh_memfreeshort(qh, &current_long, &total_long);
  if (failed) throw std::logic_error("Qhull could not triangulate a panel");
  for (std::array<int, 3>& t : triangles) {
    if (cross(points[t[1]] - points[t[0]], points[t[2]] - points[t[0]]) < 0) std::swap(t[1], t[2]);
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

std::vector<std::array<int, 3>> triangulate(const HalfPoints& half, const Points2& polygon) {
  std::vector<std::array<int, 3>> triangles = delaunay(half.points);
  const auto outside = [&](const std::array<int, 3>& t) {
    const Point& a = half.points[t[0]];
    const Point& b = half.points[t[1]];
    const Point& c = half.points[t[2]];
    // A sliver that leans on a straight part of the outline is as good as outside.
    const double longest =
        std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
    return cross(b - a, c - a) < 1e-6 * longest || !is_inside(polygon, (a + b + c) / 3);
  };
  triangles.erase(std::remove_if(triangles.begin(), triangles.end(), outside), triangles.end());
  return triangles;
}

// Each interior point to the mean of its neighbours.
void relax(HalfPoints& half, const std::vector<std::array<int, 3>>& triangles) {
  std::vector<Point> sum(half.points.size(), Point::Zero());
  std::vector<int> count(half.points.size(), 0);
  for (const std::array<int, 3>& t : triangles) {
    for (int k = 0; k < 3; ++k) {
      sum[t[k]] += half.points[t[(k + 1) % 3]];
      ++count[t[k]];
    }
  }
  for (size_t i = half.outline_count + half.axis_count; i < half.points.size(); ++i)
    half.points[i] = sum[i] / count[i];
}

// The corner across the edge from b to a, as (face, vertex); face -1 on the outline.
std::array<int, 2> across_edge(const std::vector<std::array<int, 3>>& triangles, int b, int a) {
  for (size_t f = 0; f < triangles.size(); ++f)
    for (int k = 0; k < 3; ++k)
      if (triangles[f][k] == b && triangles[f][(k + 1) % 3] == a)
        return {static_cast<int>(f), triangles[f][(k + 2) % 3]};
  return {-1, -1};
}

// A triangle with its three corners on the outline has no vertex that may give way: flip its inner
// edge.
void unlock_corners(const HalfPoints& half, std::vector<std::array<int, 3>>& triangles) {
  const auto on_outline = [&](int v) { return v < half.outline_count; };
  for (size_t f = 0; f < triangles.size(); ++f) {
    const std::array<int, 3> t = triangles[f];
    if (!on_outline(t[0]) || !on_outline(t[1]) || !on_outline(t[2])) continue;
    for (int k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3];
      const auto [face, d] = across_edge(triangles, b, a);
      if (face < 0 || on_outline(d)) continue;
      triangles[f] = {c, a, d};
      triangles[face] = {c, d, b};
      break;
    }
  }
}

}  // namespace

PanelCount count_panel(const Points2& half_outline, double spacing) {
  const HalfPoints half = half_points(half_outline, spacing);
  const int on_axis = half.axis_count + 2;
  return {2 * static_cast<int>(half.points.size()) - on_axis, half.segments};
}

PanelMesh mesh_panel(const Points2& half_outline, double spacing) {
  HalfPoints half = half_points(half_outline, spacing);
  Points2 polygon(half.outline_count, 2);  // closed along the axis by its ends
  for (int i = 0; i < half.outline_count; ++i) polygon.row(i) = half.points[i];
  std::vector<std::array<int, 3>> triangles = triangulate(half, polygon);
  for (int i = 0; i < kRelaxations; ++i) {
    relax(half, triangles);
    triangles = triangulate(half, polygon);
  }
  unlock_corners(half, triangles);

  const int count = static_cast<int>(half.points.size());
  std::vector<int> mirror(count);
  std::vector<Point> points = half.points;
  for (int i = 0; i < count; ++i) {
    const bool on_axis =
        i == 0 || (i >= half.outline_count - 1 && i < half.outline_count + half.axis_count);
    mirror[i] = on_axis ? i : static_cast<int>(points.size());
    if (!on_axis) points.emplace_back(-half.points[i].x(), half.points[i].y());
  }

  PanelMesh mesh;
  mesh.points.resize(static_cast<Eigen::Index>(points.size()), 2);
  for (size_t i = 0; i < points.size(); ++i)
    mesh.points.row(static_cast<Eigen::Index>(i)) = points[i];
  const Eigen::Index face_count = static_cast<Eigen::Index>(triangles.size());
  mesh.faces.resize(2 * face_count, 3);
  for (Eigen::Index f = 0; f < face_count; ++f) {
    const std::array<int, 3>& t = triangles[f];
    mesh.faces.row(f) << t[0], t[1], t[2];
    mesh.faces.row(face_count + f) << mirror[t[0]], mirror[t[2]], mirror[t[1]];
  }
  int first = 0;
  for (const int n : half.segments) {
    std::array<std::vector<int>, 2> curve;
    for (int k = 0; k <= n; ++k) {
      curve[0].push_back(first + k);
      curve[1].push_back(mirror[first + k]);
    }
    mesh.curves.push_back(curve);
    first += n;
  }
  return mesh;
}

}  // namespace pleat::garment
