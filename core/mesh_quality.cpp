#include "core/mesh_quality.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/mesh.h"

namespace pleat {
namespace {

// The larger singular value of the 3 x 2 deformation gradient of a triangle. rest, deformed: edge
// vectors from the first corner, as columns.
double larger_stretch(const Mat<2>& rest, const Eigen::Matrix<double, 3, 2>& deformed) {
  const Eigen::Matrix<double, 3, 2> gradient = deformed * rest.inverse();
  const Mat<2> c = gradient.transpose() * gradient;  // right Cauchy-Green tensor
  const double mean = 0.5 * (c(0, 0) + c(1, 1));
  return std::sqrt(mean + std::hypot(0.5 * (c(0, 0) - c(1, 1)), c(0, 1)));
}

// Linear between order statistics.
double percentile(std::vector<double> values, double fraction) {
  if (values.empty()) return 0;
  const double position = fraction * static_cast<double>(values.size() - 1);
  const size_t below = static_cast<size_t>(position);
  std::nth_element(values.begin(), values.begin() + below, values.end());
  const double low = values[below];
  if (below + 1 == values.size()) return low;
  const double high = *std::min_element(values.begin() + below + 1, values.end());
  return low + (position - static_cast<double>(below)) * (high - low);
}

// Normals that tell inside from outside at any closest point, corners and edges included.
class Pseudonormals {
 public:
  Pseudonormals(const Points3& vertices, const Faces& faces)
      : vertices_(vertices), faces_(faces), face_normals_(face_normals(vertices, faces)) {
    first_.assign(vertices.rows() + 1, 0);
    for (int k = 0; k < faces.size(); ++k) ++first_[faces.data()[k] + 1];
    for (size_t v = 1; v < first_.size(); ++v) first_[v] += first_[v - 1];
    around_.resize(faces.size());
    std::vector<int> next(first_.begin(), first_.end() - 1);
    for (int k = 0; k < faces.size(); ++k) around_[next[faces.data()[k]]++] = k / 3;
  }

  // Not of unit length: only its direction counts.
  Vec<3> at(const ClosestPoint& closest) const {
    int corner_on = -1, corner_off = -1, zeros = 0;  // of those where the point has weight or none
    for (int k = 0; k < 3; ++k) {
      if (closest.barycentric[k] == 0) {
        ++zeros;
        corner_off = k;
      } else {
        corner_on = k;
      }
    }
    if (zeros == 0) return face_normals_.row(closest.face);
    if (zeros == 2) return vertex_normal(faces_(closest.face, corner_on));
    return edge_normal(faces_(closest.face, (corner_off + 1) % 3),
                       faces_(closest.face, (corner_off + 2) % 3));
  }

 private:
  Vec<3> vertex_normal(int v) const {
    Vec<3> sum = Vec<3>::Zero();
    for (int k = first_[v]; k < first_[v + 1]; ++k) {
      const int f = around_[k];
      const int corner = faces_(f, 0) == v ? 0 : faces_(f, 1) == v ? 1 : 2;
      const Vec<3> a = (vertices_.row(faces_(f, (corner + 1) % 3)) - vertices_.row(v)).transpose();
      const Vec<3> b = (vertices_.row(faces_(f, (corner + 2) % 3)) - vertices_.row(v)).transpose();
      sum += std::atan2(a.cross(b).norm(), a.dot(b)) * face_normals_.row(f).transpose();
    }
    return sum;
  }

  Vec<3> edge_normal(int v, int w) const {
    Vec<3> sum = Vec<3>::Zero();
    for (int k = first_[v]; k < first_[v + 1]; ++k) {
      const int f = around_[k];
      if ((faces_.row(f).array() == w).any()) sum += face_normals_.row(f).transpose();
    }
    return sum;
  }

  const Points3& vertices_;
  const Faces& faces_;
  Points3 face_normals_;
  std::vector<int> first_, around_;  // faces around vertex v: around_[first_[v] .. first_[v + 1])
};

}  // namespace

Strain strain(const Eigen::Ref<const Points3>& vertices, const Faces& faces,
              const Eigen::Ref<const Points2>& rest, const Faces& rest_faces) {
  assert(faces.rows() == rest_faces.rows());
  Strain result;
  std::vector<double> stretches;
  for (int f = 0; f < faces.rows(); ++f) {
    Mat<2> flat;
    Eigen::Matrix<double, 3, 2> deformed;
    for (int k = 0; k < 2; ++k) {
      flat.col(k) = (rest.row(rest_faces(f, k + 1)) - rest.row(rest_faces(f, 0))).transpose();
      deformed.col(k) = (vertices.row(faces(f, k + 1)) - vertices.row(faces(f, 0))).transpose();
    }
    if (flat.determinant() == 0) {
      throw InputError("rest face " + std::to_string(f) + " has no area; its strain is undefined");
    }
    stretches.push_back(std::max(larger_stretch(flat, deformed) - 1, 0.0));
    result.max = std::max(result.max, stretches.back());
  }
  result.percentile_95 = percentile(std::move(stretches), 0.95);
  return result;
}

Eigen::VectorXd signed_distances(const SurfaceTree& surface,
                                 const Eigen::Ref<const Points3>& points, double max_distance) {
  const Pseudonormals normals(surface.vertices(), surface.faces());
  Eigen::VectorXd result = Eigen::VectorXd::Constant(points.rows(), max_distance);
  if (surface.faces().rows() == 0) return result;
  const Vec<3> low = surface.vertices().colwise().minCoeff();
  const Vec<3> high = surface.vertices().colwise().maxCoeff();
#pragma omp parallel for schedule(dynamic, 64)
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const Vec<3> p = points.row(i);
    ClosestPoint closest = surface.closest(p, max_distance);
    const bool is_far = closest.face < 0;
    if (is_far) {
      if ((p.array() < low.array()).any() || (p.array() > high.array()).any()) continue;
      closest = surface.closest(p, std::numeric_limits<double>::infinity());
      if (closest.face < 0) continue;  // p is not finite
    }
    const bool is_inside = (p - closest.point).dot(normals.at(closest)) < 0;
    const double distance = std::sqrt(closest.squared_distance);
    if (is_inside) {
      result[i] = -distance;
    } else if (!is_far) {
      result[i] = distance;
    }
  }
  return result;
}

}  // namespace pleat
