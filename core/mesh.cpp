#include "core/mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include "core/error.h"

namespace pleat {
namespace {

struct HalfEdge {
  int low, high;  // vertices, ascending
  int face, opposite;
  bool is_ascending;  // the face runs from low to high
  bool operator<(const HalfEdge& other) const {
    if (low != other.low) return low < other.low;
    if (high != other.high) return high < other.high;
    return face < other.face;
  }
  bool has_same_vertices(const HalfEdge& other) const {
    return low == other.low && high == other.high;
  }
};

std::vector<HalfEdge> sorted_half_edges(const Faces& faces) {
  std::vector<HalfEdge> result;
  result.reserve(3 * faces.rows());
  for (int f = 0; f < faces.rows(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const int from = faces(f, k), to = faces(f, (k + 1) % 3);
      result.push_back(
          {std::min(from, to), std::max(from, to), f, faces(f, (k + 2) % 3), from < to});
    }
  }
  std::sort(result.begin(), result.end());
  return result;
}

// Calls action(first, last) for each run of half-edges that share their vertices.
template <typename Action>
void for_each_edge(const std::vector<HalfEdge>& half_edges, Action action) {
  for (size_t first = 0, last; first < half_edges.size(); first = last) {
    last = first + 1;
    while (last < half_edges.size() && half_edges[last].has_same_vertices(half_edges[first])) {
      ++last;
    }
    action(first, last);
  }
}

// Middles of the edges are appended to the points; four faces replace each.
template <typename Points>
void subdivide(const Points& points, const Faces& faces, Points& new_points, Faces& new_faces) {
  std::vector<std::pair<int, int>> middles;  // ends of the edge, ascending
  for (int f = 0; f < faces.rows(); ++f) {
    for (int k = 0; k < 3; ++k) {
      middles.push_back(std::minmax({faces(f, k), faces(f, (k + 1) % 3)}));
    }
  }
  std::sort(middles.begin(), middles.end());
  middles.erase(std::unique(middles.begin(), middles.end()), middles.end());

  const int old_count = static_cast<int>(points.rows());
  new_points.resize(old_count + middles.size(), points.cols());
  new_points.topRows(old_count) = points;
  for (size_t m = 0; m < middles.size(); ++m) {
    new_points.row(old_count + m) =
        0.5 * (points.row(middles[m].first) + points.row(middles[m].second));
  }
  const auto middle = [&](int a, int b) {
    const std::pair<int, int> ends = std::minmax({a, b});
    return old_count + static_cast<int>(std::lower_bound(middles.begin(), middles.end(), ends) -
                                        middles.begin());
  };
  new_faces.resize(4 * faces.rows(), 3);
  for (int f = 0; f < faces.rows(); ++f) {
    const int a = faces(f, 0), b = faces(f, 1), c = faces(f, 2);
    const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    new_faces.row(4 * f) << a, ab, ca;
    new_faces.row(4 * f + 1) << ab, b, bc;
    new_faces.row(4 * f + 2) << ca, bc, c;
    new_faces.row(4 * f + 3) << ab, bc, ca;
  }
}

Vec<3> area_vector(const Eigen::Ref<const Points3>& vertices, const Faces& faces, int f) {
  const Vec<3> a = vertices.row(faces(f, 0)), b = vertices.row(faces(f, 1)),
               c = vertices.row(faces(f, 2));
  return 0.5 * (b - a).cross(c - a);
}

}  // namespace

std::vector<Edge> edges(const Faces& faces) {
  const std::vector<HalfEdge> half_edges = sorted_half_edges(faces);
  std::vector<Edge> result;
  for_each_edge(half_edges, [&](size_t first, size_t last) {
    const HalfEdge& a = half_edges[first];
    if (last - first > 2) {
      throw InputError("edge of vertices " + std::to_string(a.low) + " and " +
                       std::to_string(a.high) + " has " + std::to_string(last - first) +
                       " faces; expected at most 2");
    }
    Edge edge{{a.low, a.high}, {a.face, -1}, {a.opposite, -1}};
    if (last - first == 2) {
      edge.faces[1] = half_edges[first + 1].face;
      edge.opposite[1] = half_edges[first + 1].opposite;
    }
    result.push_back(edge);
  });
  return result;
}

Points3 face_normals(const Eigen::Ref<const Points3>& vertices, const Faces& faces) {
  Points3 result(faces.rows(), 3);
  for (int f = 0; f < faces.rows(); ++f) {
    result.row(f) = area_vector(vertices, faces, f).stableNormalized().transpose();
  }
  return result;
}

Faces face_neighbours(const Faces& faces) {
  std::map<std::pair<int, int>, int> face_of;
  for (int f = 0; f < faces.rows(); ++f) {
    for (int c = 0; c < 3; ++c) face_of[{faces(f, c), faces(f, (c + 1) % 3)}] = f;
  }
  Faces neighbours(faces.rows(), 3);
  for (int f = 0; f < faces.rows(); ++f) {
    for (int c = 0; c < 3; ++c) {
      const auto it = face_of.find({faces(f, (c + 1) % 3), faces(f, c)});
      neighbours(f, c) = it == face_of.end() ? -1 : it->second;
    }
  }
  return neighbours;
}

std::vector<std::vector<int>> vertex_neighbours(const Faces& faces, Eigen::Index vertex_count) {
  std::vector<std::vector<int>> neighbours(vertex_count);
  for (const Edge& edge : edges(faces))
    for (int side : {0, 1}) neighbours[edge.vertices[side]].push_back(edge.vertices[1 - side]);
  return neighbours;
}

Points3 vertex_normals(const Eigen::Ref<const Points3>& vertices, const Faces& faces) {
  Points3 result(vertices.rows(), 3);
  update_vertex_normals(vertices, faces, std::vector<char>(vertices.rows(), 1), result);
  return result;
}

void update_vertex_normals(const Eigen::Ref<const Points3>& vertices, const Faces& faces,
                           const std::vector<char>& is_asked, Points3& normals) {
  for (int v = 0; v < normals.rows(); ++v)
    if (is_asked[v]) normals.row(v).setZero();
  for (int f = 0; f < faces.rows(); ++f) {
    if (!is_asked[faces(f, 0)] && !is_asked[faces(f, 1)] && !is_asked[faces(f, 2)]) continue;
    const Vec<3> normal = area_vector(vertices, faces, f).stableNormalized();
    for (int k = 0; k < 3; ++k) {
      if (!is_asked[faces(f, k)]) continue;
      const Vec<3> corner = vertices.row(faces(f, k));
      const Vec<3> u = vertices.row(faces(f, (k + 1) % 3)).transpose() - corner;
      const Vec<3> w = vertices.row(faces(f, (k + 2) % 3)).transpose() - corner;
      normals.row(faces(f, k)) += std::atan2(u.cross(w).norm(), u.dot(w)) * normal.transpose();
    }
  }
  for (int v = 0; v < normals.rows(); ++v)
    if (is_asked[v]) normals.row(v).stableNormalize();
}

Eigen::VectorXd face_areas(const Eigen::Ref<const Points3>& vertices, const Faces& faces) {
  Eigen::VectorXd result(faces.rows());
  for (int f = 0; f < faces.rows(); ++f) result[f] = area_vector(vertices, faces, f).norm();
  return result;
}

Topology topology(const Faces& faces, int vertex_count) {
  Topology result;
  int edge_count = 0;
  const std::vector<HalfEdge> half_edges = sorted_half_edges(faces);
  for_each_edge(half_edges, [&](size_t first, size_t last) {
    ++edge_count;
    if (last - first == 1) ++result.boundary_edges;
    if (last - first > 2) ++result.nonmanifold_edges;
    if (last - first == 2 && half_edges[first].is_ascending == half_edges[first + 1].is_ascending) {
      ++result.misoriented_edges;
    }
  });

  std::vector<int> parent(vertex_count);  // union-find
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  std::vector<char> is_used(vertex_count, 0);
  for (int f = 0; f < faces.rows(); ++f) {
    for (int k = 0; k < 3; ++k) {
      is_used[faces(f, k)] = 1;
      parent[root(faces(f, k))] = root(faces(f, 0));
    }
  }
  int used_count = 0;
  for (int v = 0; v < vertex_count; ++v) {
    if (!is_used[v]) continue;
    ++used_count;
    if (root(v) == v) ++result.components;
  }
  result.euler_characteristic = used_count - edge_count + static_cast<int>(faces.rows());
  return result;
}

TriangleMesh subdivide(const TriangleMesh& mesh) {
  TriangleMesh result;
  subdivide(mesh.vertices, mesh.faces, result.vertices, result.faces);
  if (mesh.uv_faces.rows() > 0) subdivide(mesh.uv, mesh.uv_faces, result.uv, result.uv_faces);
  return result;
}

}  // namespace pleat
