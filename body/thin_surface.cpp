#include "body/thin_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <queue>
#include <tuple>

namespace pleat::body {
namespace {

constexpr double kLeastTurn = 0.3;  // cosine between a face's normals before and after a collapse
constexpr double kLeastQuality = 0.12;  // of a face, 1: equilateral
constexpr double kEdgeWeight =
    1e-3;  // of the squared edge length beside the quadric: spreads collapses where it is flat

using Quadric = Mat<4>;

struct Collapse {
  double cost;
  int from, onto;
  int version;                                   // sum of both ends' versions when it was proposed
  bool operator<(const Collapse& other) const {  // std::priority_queue takes the largest
    return std::tie(cost, from, onto) > std::tie(other.cost, other.from, other.onto);
  }
};

// 4 sqrt(3) area / sum of squared edges, with the face's normal direction.
double quality(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c) {
  const double edges = (b - a).squaredNorm() + (c - b).squaredNorm() + (a - c).squaredNorm();
  return edges > 0 ? 2 * std::sqrt(3.0) * (b - a).cross(c - a).norm() / edges : 0;
}

class Thinning {
 public:
  Thinning(const Eigen::Ref<const Points3>& vertices, const Faces& faces,
           const std::vector<char>& may_go)
      : vertices_(vertices),
        faces_(faces),
        may_go_(may_go),
        face_alive_(faces.rows(), 1),
        vertex_faces_(vertices.rows()),
        quadrics_(vertices.rows(), Quadric::Zero()),
        versions_(vertices.rows(), 0),
        face_count_(static_cast<int>(faces.rows())) {
    for (int f = 0; f < faces_.rows(); ++f) {
      const Vec<3> cross =
          (at(faces_(f, 1)) - at(faces_(f, 0))).cross(at(faces_(f, 2)) - at(faces_(f, 0)));
      const double area = cross.norm() / 2;
      Vec<4> plane = Vec<4>::Zero();
      if (area > 0) plane << cross.normalized(), -cross.normalized().dot(at(faces_(f, 0)));
      for (int c = 0; c < 3; ++c) {
        vertex_faces_[faces_(f, c)].push_back(f);
        quadrics_[faces_(f, c)] += area * plane * plane.transpose();
      }
    }
    for (int v = 0; v < vertices_.rows(); ++v) propose_from(v);
  }

  void run(int target_face_count) {
    while (face_count_ > target_face_count && !queue_.empty()) {
      const Collapse next = queue_.top();
      queue_.pop();
      if (next.version != versions_[next.from] + versions_[next.onto]) continue;
      if (!is_allowed(next.from, next.onto)) continue;
      collapse(next.from, next.onto);
    }
  }

  Faces faces() const {
    Faces kept(face_count_, 3);
    int count = 0;
    for (int f = 0; f < faces_.rows(); ++f) {
      if (face_alive_[f]) kept.row(count++) = faces_.row(f);
    }
    return kept;
  }

 private:
  Vec<3> at(int v) const { return vertices_.row(v); }

  std::vector<int> neighbours(int v) const {
    std::vector<int> result;
    for (int f : vertex_faces_[v]) {
      for (int c = 0; c < 3; ++c) {
        if (faces_(f, c) != v) result.push_back(faces_(f, c));
      }
    }
    std::sort(result.begin(), result.end());
    result.erase(std::unique(result.begin(), result.end()), result.end());
    return result;
  }

  void propose(int from, int onto) {
    if (!may_go_[from]) return;
    const Vec<4> target = at(onto).homogeneous();
    const double error = std::max(0.0, target.dot((quadrics_[from] + quadrics_[onto]) * target));
    const double squared_length = (at(from) - at(onto)).squaredNorm();
    queue_.push({error + kEdgeWeight * squared_length * squared_length, from, onto,
                 versions_[from] + versions_[onto]});
  }

  void propose_from(int v) {
    for (int n : neighbours(v)) propose(v, n);
  }

  bool is_allowed(int from, int onto) const {
    const std::vector<int> near_from = neighbours(from), near_onto = neighbours(onto);
    std::vector<int> both;
    std::set_intersection(near_from.begin(), near_from.end(), near_onto.begin(), near_onto.end(),
                          std::back_inserter(both));
    if (both.size() != 2) return false;  // link condition of an inner edge
    for (int v : both) {
      if (vertex_faces_[v].size() <= 3) return false;  // would leave two faces back to back
    }
    for (int f : vertex_faces_[from]) {
      std::array<Vec<3>, 3> before, after;
      bool vanishes = false;
      for (int c = 0; c < 3; ++c) {
        vanishes = vanishes || faces_(f, c) == onto;
        before[c] = at(faces_(f, c));
        after[c] = faces_(f, c) == from ? at(onto) : before[c];
      }
      if (vanishes) continue;
      const Vec<3> normal_before = (before[1] - before[0]).cross(before[2] - before[0]);
      const Vec<3> normal_after = (after[1] - after[0]).cross(after[2] - after[0]);
      if (normal_before.dot(normal_after) < kLeastTurn * normal_before.norm() * normal_after.norm())
        return false;
      const double quality_after = quality(after[0], after[1], after[2]);
      if (quality_after < kLeastQuality && quality_after < quality(before[0], before[1], before[2]))
        return false;
    }
    return true;
  }

  void collapse(int from, int onto) {
    quadrics_[onto] += quadrics_[from];
    for (int f : vertex_faces_[from]) {
      const bool vanishes = (faces_.row(f).array() == onto).any();
      if (vanishes) {
        face_alive_[f] = 0;
        --face_count_;
        for (int c = 0; c < 3; ++c) {
          if (faces_(f, c) == from) continue;
          std::vector<int>& list = vertex_faces_[faces_(f, c)];
          list.erase(std::find(list.begin(), list.end(), f));
        }
      } else {
        for (int c = 0; c < 3; ++c) {
          if (faces_(f, c) == from) faces_(f, c) = onto;
        }
        vertex_faces_[onto].push_back(f);
      }
    }
    vertex_faces_[from].clear();
    ++versions_[from];
    ++versions_[onto];
    // What is allowed depends on the ring around both ends: propose all of it again.
    for (int n : neighbours(onto)) {
      ++versions_[n];
    }
    for (int n : neighbours(onto)) {
      propose_from(n);
    }
    propose_from(onto);
    for (int n : neighbours(onto)) {
      for (int m : neighbours(n)) {
        if (m != onto) propose(m, n);
      }
    }
  }

  const Points3 vertices_;
  Faces faces_;
  const std::vector<char>& may_go_;
  std::vector<char> face_alive_;
  std::vector<std::vector<int>> vertex_faces_;
  std::vector<Quadric> quadrics_;
  std::vector<int> versions_;
  int face_count_;
  std::priority_queue<Collapse> queue_;
};

}  // namespace

Faces thin_surface(const Eigen::Ref<const Points3>& vertices, const Faces& faces,
                   const std::vector<char>& may_go, int target_face_count) {
  Thinning thinning(vertices, faces, may_go);
  thinning.run(target_face_count);
  return thinning.faces();
}

}  // namespace pleat::body
