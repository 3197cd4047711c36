#include "body/cavities.h"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <utility>

#include "body/fill_holes.h"
#include "core/mesh.h"

namespace pleat::body {
namespace {

constexpr double kPi = 3.14159265358979323846;

// Evenly spread over the sphere (Fibonacci lattice).
Vec<3> view_direction(int view, int views) {
  const double z = 1 - 2 * (view + 0.5) / views, angle = view * kPi * (3 - std::sqrt(5.0));
  const double r = std::sqrt(1 - z * z);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

// Marks the faces (rows below seen.size()) that win a pixel of a parallel projection seen from
// `direction`.
void mark_seen(const Eigen::Ref<const Points3>& vertices, const Faces& faces, const Vec<3>& centre,
               double radius, const Vec<3>& direction, int pixels, std::vector<char>& seen) {
  Mat<3> axes;  // rows: right, up, towards the viewer
  axes.row(2) = direction;
  axes.row(0) = direction.unitOrthogonal();
  axes.row(1) = direction.cross(axes.row(0).transpose());
  const Points3 local = (vertices.rowwise() - centre.transpose()) * axes.transpose();
  const double scale = pixels / (2 * radius);
  const auto count = static_cast<size_t>(pixels) * static_cast<size_t>(pixels);
  std::vector<float> depth(count, -std::numeric_limits<float>::infinity());
  std::vector<int> owner(count, -1);
  for (int f = 0; f < faces.rows(); ++f) {
    Mat<3> p;  // columns: corners in pixels, depth in the units of the vertices
    for (int c = 0; c < 3; ++c) {
      p.col(c) = local.row(faces(f, c));
      p.col(c).head<2>() = (p.col(c).head<2>().array() + radius) * scale;
    }
    const double area =
        (p(0, 1) - p(0, 0)) * (p(1, 2) - p(1, 0)) - (p(0, 2) - p(0, 0)) * (p(1, 1) - p(1, 0));
    if (area == 0) continue;
    const double last = pixels - 1;
    const int x0 = static_cast<int>(std::ceil(std::max(0.0, p.row(0).minCoeff() - 0.5)));
    const int x1 = static_cast<int>(std::floor(std::min(last, p.row(0).maxCoeff() - 0.5)));
    const int y0 = static_cast<int>(std::ceil(std::max(0.0, p.row(1).minCoeff() - 0.5)));
    const int y1 = static_cast<int>(std::floor(std::min(last, p.row(1).maxCoeff() - 0.5)));
    for (int y = y0; y <= y1; ++y) {
      for (int x = x0; x <= x1; ++x) {
        const double px = x + 0.5, py = y + 0.5;
        const double b =
            ((px - p(0, 0)) * (p(1, 2) - p(1, 0)) - (p(0, 2) - p(0, 0)) * (py - p(1, 0))) / area;
        const double c =
            ((p(0, 1) - p(0, 0)) * (py - p(1, 0)) - (px - p(0, 0)) * (p(1, 1) - p(1, 0))) / area;
        if (b < 0 || c < 0 || b + c > 1) continue;
        const auto z =
            static_cast<float>(p(2, 0) + b * (p(2, 1) - p(2, 0)) + c * (p(2, 2) - p(2, 0)));
        const size_t pixel = static_cast<size_t>(y) * pixels + x;
        if (z > depth[pixel]) depth[pixel] = z, owner[pixel] = f;
      }
    }
  }
  for (int f : owner) {
    if (f >= 0 && f < static_cast<int>(seen.size())) seen[f] = 1;
  }
}

// Connected patches of faces that share `mark`'s value.
std::vector<std::vector<int>> patches(const Faces& neighbours, const std::vector<char>& mark,
                                      char value) {
  std::vector<char> visited(mark.size(), 0);
  std::vector<std::vector<int>> result;
  for (int seed = 0; seed < static_cast<int>(mark.size()); ++seed) {
    if (mark[seed] != value || visited[seed]) continue;
    std::vector<int> patch = {seed};
    visited[seed] = 1;
    for (size_t k = 0; k < patch.size(); ++k) {
      for (int c = 0; c < 3; ++c) {
        const int n = neighbours(patch[k], c);
        if (n < 0 || visited[n] || mark[n] != value) continue;
        visited[n] = 1;
        patch.push_back(n);
      }
    }
    result.push_back(std::move(patch));
  }
  return result;
}

// Takes out visible islands within hidden patches, teeth of their outline and vertices where they
// touch themselves.
void make_outlines_simple(const Faces& faces, const Faces& neighbours, int vertex_count,
                          std::vector<char>& goes) {
  for (bool changed = true; changed;) {
    changed = false;
    const std::vector<std::vector<int>> kept = patches(neighbours, goes, 0);
    size_t largest = 0;
    for (size_t k = 1; k < kept.size(); ++k) {
      if (kept[k].size() > kept[largest].size()) largest = k;
    }
    for (size_t k = 0; k < kept.size(); ++k) {
      if (k == largest) continue;
      for (int f : kept[k]) goes[f] = 1, changed = true;
    }
    for (int f = 0; f < faces.rows(); ++f) {
      int gone = 0;
      for (int c = 0; c < 3; ++c) gone += neighbours(f, c) >= 0 && goes[neighbours(f, c)];
      if (!goes[f] && gone >= 2) goes[f] = 1, changed = true;
    }
    // An outline passes through each of its vertices once.
    std::vector<int> passes(static_cast<size_t>(vertex_count), 0);
    for (int f = 0; f < faces.rows(); ++f) {
      for (int c = 0; c < 3; ++c) {
        if (goes[f] && neighbours(f, c) >= 0 && !goes[neighbours(f, c)]) ++passes[faces(f, c)];
      }
    }
    for (int f = 0; f < faces.rows(); ++f) {
      for (int c = 0; c < 3; ++c) {
        if (!goes[f] && passes[faces(f, c)] > 1) goes[f] = 1, changed = true;
      }
    }
  }
}

}  // namespace

Faces close_cavities(const Eigen::Ref<const Points3>& vertices, const Faces& faces,
                     const std::vector<char>& is_candidate, const Faces& blockers,
                     const CavityConfig& config) {
  Eigen::AlignedBox3d extent;
  for (int f = 0; f < faces.rows(); ++f) {
    for (int c = 0; c < 3 && is_candidate[f]; ++c)
      extent.extend(vertices.row(faces(f, c)).transpose());
  }
  if (extent.isEmpty()) return faces;
  std::vector<char> seen(static_cast<size_t>(faces.rows()), 0);
  const Faces all = joined(faces, blockers);
  for (int view = 0; view < config.views; ++view) {
    mark_seen(vertices, all, extent.center(), extent.diagonal().norm() / 2,
              view_direction(view, config.views), config.pixels, seen);
  }

  const Faces neighbours = face_neighbours(faces);
  std::vector<char> goes(seen.size(), 0);
  for (size_t f = 0; f < goes.size(); ++f) goes[f] = is_candidate[f] && !seen[f];
  for (const std::vector<int>& patch : patches(neighbours, goes, 1)) {
    if (static_cast<int>(patch.size()) >= config.least_faces) continue;
    for (int f : patch) goes[f] = 0;
  }
  make_outlines_simple(faces, neighbours, static_cast<int>(vertices.rows()), goes);

  Faces skin(faces.rows(), 3);
  int count = 0;
  for (int f = 0; f < faces.rows(); ++f) {
    if (!goes[f]) skin.row(count++) = faces.row(f);
  }
  skin.conservativeResize(count, 3);
  for (const std::vector<int>& loop : boundary_loops(skin)) {
    skin = joined(skin, fill_hole(vertices, skin, loop));
  }
  return skin;
}

}  // namespace pleat::body
