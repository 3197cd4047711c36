#include "encode/uv_layout.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "core/error.h"
#include "core/mesh.h"

namespace pleat::encode {
namespace {

// A triangle in texels: x to the right, y down, centres of texels at integers.
struct FlatTriangle {
  Vec<2> a, b, c;
  double doubled_area = 0;  // signed

  Vec<3> barycentric(const Vec<2>& p) const {
    const double wb = cross(p - a, c - a) / doubled_area;
    const double wc = cross(b - a, p - a) / doubled_area;
    return {1 - wb - wc, wb, wc};
  }
  static double cross(const Vec<2>& u, const Vec<2>& v) { return u.x() * v.y() - u.y() * v.x(); }
};

Vec<2> to_texels(const Points2& uv, int vertex, int size) {
  return {uv(vertex, 0) * size - 0.5, (1 - uv(vertex, 1)) * size - 0.5};
}

FlatTriangle flat_triangle(const garment::GarmentTopology& topology, int face, int size) {
  FlatTriangle triangle;
  triangle.a = to_texels(topology.uv, topology.panel_faces(face, 0), size);
  triangle.b = to_texels(topology.uv, topology.panel_faces(face, 1), size);
  triangle.c = to_texels(topology.uv, topology.panel_faces(face, 2), size);
  triangle.doubled_area = FlatTriangle::cross(triangle.b - triangle.a, triangle.c - triangle.a);
  return triangle;
}

struct Box {
  int first_column, last_column, first_row, last_row;
};

// Texels whose centre is within `margin` of the box around the points.
Box texels_around(std::initializer_list<Vec<2>> points, double margin, int size) {
  Vec<2> low = *points.begin(), high = low;
  for (const Vec<2>& point : points) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  return {std::max(0, static_cast<int>(std::ceil(low.x() - margin))),
          std::min(size - 1, static_cast<int>(std::floor(high.x() + margin))),
          std::max(0, static_cast<int>(std::ceil(low.y() - margin))),
          std::min(size - 1, static_cast<int>(std::floor(high.y() + margin)))};
}

// Where a gutter texel at p takes its value: the affine map of the face at the nearest boundary
// point, continued towards p as far as a bilinear read can look, and by no more than one triangle,
// so that slivers do not blow noise up.
Vec<3> continued(const FlatTriangle& triangle, const Vec<2>& nearest, const Vec<2>& p) {
  const double distance = (p - nearest).norm();
  const Vec<2> target =
      distance > std::sqrt(2.0) ? Vec<2>(nearest + (p - nearest) * (std::sqrt(2.0) / distance)) : p;
  const Vec<3> at_border = triangle.barycentric(nearest);
  const Vec<3> step = triangle.barycentric(target) - at_border;
  double share = 1;
  for (int i = 0; i < 3; ++i) {
    if (step[i] < -1) share = std::min(share, -1 / step[i]);
  }
  return at_border + share * step;
}

void fill_inside(const garment::GarmentTopology& topology, UvLayout& layout) {
  constexpr double kTolerance =
      1e-9;  // so that a centre on a shared edge belongs to one of the two faces
  for (int face = 0; face < topology.panel_faces.rows(); ++face) {
    const FlatTriangle triangle = flat_triangle(topology, face, layout.size);
    if (triangle.doubled_area == 0) continue;
    const Box box = texels_around({triangle.a, triangle.b, triangle.c}, 0, layout.size);
    for (int row = box.first_row; row <= box.last_row; ++row) {
      for (int column = box.first_column; column <= box.last_column; ++column) {
        const int texel = row * layout.size + column;
        if (layout.face[texel] >= 0) continue;
        const Vec<3> barycentric = triangle.barycentric(Vec<2>(column, row));
        if (barycentric.minCoeff() < -kTolerance) continue;
        layout.mask[static_cast<size_t>(texel)] = kInside;
        layout.face[texel] = face;
        layout.barycentric.row(texel) = barycentric.transpose();
      }
    }
  }
}

void fill_gutters(const garment::GarmentTopology& topology, UvLayout& layout) {
  std::vector<double> nearest(layout.mask.size(),
                              kGutterTexels * kGutterTexels);  // squared, texels
  for (const Edge& edge : edges(topology.panel_faces)) {
    if (edge.faces[1] >= 0) continue;
    const FlatTriangle triangle = flat_triangle(topology, edge.faces[0], layout.size);
    if (triangle.doubled_area == 0) continue;
    const Vec<2> a = to_texels(topology.uv, edge.vertices[0], layout.size);
    const Vec<2> b = to_texels(topology.uv, edge.vertices[1], layout.size);
    const double squared_length = (b - a).squaredNorm();
    if (squared_length == 0) continue;
    const Box box = texels_around({a, b}, kGutterTexels, layout.size);
    for (int row = box.first_row; row <= box.last_row; ++row) {
      for (int column = box.first_column; column <= box.last_column; ++column) {
        const int texel = row * layout.size + column;
        if (layout.mask[static_cast<size_t>(texel)] == kInside) continue;
        const Vec<2> p(column, row);
        const double t = std::clamp((p - a).dot(b - a) / squared_length, 0.0, 1.0);
        const Vec<2> on_edge = a + t * (b - a);
        const double squared_distance = (p - on_edge).squaredNorm();
        if (squared_distance >= nearest[static_cast<size_t>(texel)]) continue;
        nearest[static_cast<size_t>(texel)] = squared_distance;
        layout.mask[static_cast<size_t>(texel)] = kGutter;
        layout.face[texel] = edge.faces[0];
        layout.barycentric.row(texel) = continued(triangle, on_edge, p).transpose();
      }
    }
  }
}

}  // namespace

UvLayout make_uv_layout(const garment::GarmentTopology& topology, int size) {
  if (size < 16 || size > 4096) {
    throw InputError("texture size " + std::to_string(size) + "; expected 16 .. 4096 texels");
  }
  UvLayout layout;
  layout.size = size;
  layout.mask.assign(static_cast<size_t>(size) * static_cast<size_t>(size), kEmpty);
  layout.face = Eigen::VectorXi::Constant(size * size, -1);
  layout.barycentric = Points3::Zero(size * size, 3);
  fill_inside(topology, layout);
  fill_gutters(topology, layout);
  return layout;
}

}  // namespace pleat::encode
