#include "sim/solver/near_pairs.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>

#include "core/mesh.h"

namespace pleat::sim {

// A face at the start, and how far its corners may stray from there and from one another.
struct Plate {
  Vec<3> corner[3], normal;
  double height;  // the least of the three
  double reach;
  Vec<3> motion_low, motion_high;
};

namespace {

// Each vertex and each edge of a mesh belongs to one face, so that pairs of faces give each pair of
// features once: Curtis et al. 2008, "Fast Collision Detection for Deformable Models using
// Representative-Triangles".
std::vector<char> owned_features(const Faces& faces, Eigen::Index vertex_count) {
  std::vector<char> owned(faces.rows(), 0), has_owner(vertex_count, 0);
  std::set<std::pair<int, int>> edges;
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int a = faces(f, k), b = faces(f, (k + 1) % 3);
      if (!has_owner[a]) owned[f] |= 1 << k;
      has_owner[a] = 1;
      if (edges.insert(std::minmax(a, b)).second) owned[f] |= 8 << k;
    }
  return owned;
}

std::vector<Plate> make_plates(const Scene& scene, const Faces& faces, int first) {
  std::vector<Plate> plates(faces.rows());
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    Plate& plate = plates[f];
    plate.reach = 0;
    for (int k = 0; k < 3; ++k) {
      const int v = first + faces(f, k);
      plate.corner[k] = scene.positions.row(v).transpose();
      plate.reach = std::max(plate.reach, scene.reach[v]);
      if (scene.motion.rows() == 0) continue;
      const Vec<3> u = scene.motion.row(v).transpose();
      plate.motion_low = k == 0 ? u : Vec<3>(plate.motion_low.cwiseMin(u));
      plate.motion_high = k == 0 ? u : Vec<3>(plate.motion_high.cwiseMax(u));
    }
    const Vec<3> e0 = plate.corner[1] - plate.corner[0], e1 = plate.corner[2] - plate.corner[0],
                 e2 = plate.corner[2] - plate.corner[1];
    plate.normal = e0.cross(e1);
    const double twice_area = plate.normal.norm();
    plate.normal /= twice_area;
    plate.height =
        twice_area / std::sqrt(std::max({e0.squaredNorm(), e1.squaredNorm(), e2.squaredNorm()}));
  }
  return plates;
}

// For each vertex a distance that features of its fan of faces which do not share it (or one
// another) keep at least. Where all faces of the fan lean less than 50 degrees from a common
// direction, they cover the plane across it without overlap, and in it no corner is nearer to a
// face of the fan than a face is high; else 0.
std::vector<double> distances_in_fans(const std::vector<Plate>& plates, const Faces& faces,
                                      int vertex_count) {
  constexpr double kLeast = 0.64;  // cosine of 50 degrees
  std::vector<Vec<3>> mean(vertex_count, Vec<3>::Zero());
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) mean[faces(f, k)] += plates[f].normal;
  for (Vec<3>& direction : mean) direction.normalize();
  std::vector<double> result(vertex_count, 1e30);
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int v = faces(f, k);
      const bool is_flat = plates[f].normal.dot(mean[v]) > kLeast;
      result[v] = is_flat ? std::min(result[v], kLeast * plates[f].height) : 0;
    }
  return result;
}

// How far b stays off the plane of a, on either side; 0 where it crosses it.
double off_plane(const Plate& a, const Plate& b) {
  const double base = a.normal.dot(a.corner[0]);
  const double d0 = a.normal.dot(b.corner[0]) - base, d1 = a.normal.dot(b.corner[1]) - base,
               d2 = a.normal.dot(b.corner[2]) - base;
  return std::max({std::min({d0, d1, d2}), -std::max({d0, d1, d2}), 0.0});
}

bool is_off_box(const Vec<3>& point, const Plate& plate, double range) {
  for (int k = 0; k < 3; ++k) {
    const double a = plate.corner[0][k], b = plate.corner[1][k], c = plate.corner[2][k];
    if (point[k] < std::min({a, b, c}) - range || point[k] > std::max({a, b, c}) + range)
      return true;
  }
  return false;
}

bool are_apart(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c, const Vec<3>& d, double range) {
  for (int k = 0; k < 3; ++k)
    if (std::min(c[k], d[k]) - std::max(a[k], b[k]) > range ||
        std::min(a[k], b[k]) - std::max(c[k], d[k]) > range)
      return true;
  return false;
}

}  // namespace

PairFinder::PairFinder(const Faces& cloth, const Eigen::Ref<const Points3>& cloth_positions,
                       const Faces& body, const Eigen::Ref<const Points3>& body_positions)
    : cloth_{cloth, 0, owned_features(cloth, cloth_positions.rows()), face_neighbours(cloth),
             SweptTree(SurfaceTree(cloth_positions, cloth))},
      body_{body, static_cast<int>(cloth_positions.rows()),
            owned_features(body, body_positions.rows()), face_neighbours(body),
            SweptTree(SurfaceTree(body_positions, body))} {
  body_.tree.mark(std::vector<char>(body.rows(), 0));  // the cloth asks
}

PairFinder::~PairFinder() = default;

void PairFinder::refit_body(const Scene& scene, double range) {
  const Eigen::Index count = scene.positions.rows() - body_.first;
  const Points3 motion =
      scene.motion.rows() > 0 ? Points3(scene.motion.bottomRows(count)) : Points3(0, 3);
  const Eigen::VectorXd reach = scene.reach.tail(count).array() + range;
  const auto is_same = [](const auto& a, const auto& b) { return a.rows() == b.rows() && a == b; };
  if (is_same(body_positions_, scene.positions.bottomRows(count)) && is_same(body_reach_, reach) &&
      is_same(body_motion_, motion))
    return;
  body_positions_ = scene.positions.bottomRows(count);
  body_reach_ = reach;
  body_motion_ = motion;
  body_.tree.refit(body_positions_, reach, motion);
  body_plates_ = make_plates(scene, body_.faces, body_.first);
}

// Of a pair of features the distance can fall by the reaches of both, and by what they move against
// one another: `near` adds that to the range.
PairFinder::Found PairFinder::find(const Scene& scene, const PairRanges& ranges) {
  const int count = body_.first;
  const Eigen::Index body_count = scene.positions.rows() - count;
  const bool moves = scene.motion.rows() > 0;
  const Points3 none(0, 3);
  cloth_.tree.refit(scene.positions.topRows(count),
                    scene.reach.head(count).array() + ranges.cloth_m / 2,
                    moves ? Points3(scene.motion.topRows(count)) : none);
  refit_body(scene, std::max(0.0, std::max(ranges.body_m, ranges.rest_m) - ranges.cloth_m / 2));
  const std::vector<Plate> cloth_plates = make_plates(scene, cloth_.faces, 0);
  const std::vector<double> in_fan = distances_in_fans(cloth_plates, cloth_.faces, count);
  Found found;
  std::vector<std::array<int, 2>> rest;  // cloth vertex, body face
  std::vector<char> is_corner_off(scene.is_face_off.empty() ? 0 : body_count, 1);
  for (size_t g = 0; g < scene.is_face_off.size(); ++g)
    for (int k = 0; k < 3 && !scene.is_face_off[g]; ++k) is_corner_off[body_.faces(g, k)] = 0;
  const auto is_asked = [&](int v) {
    return scene.is_asked.empty() || (v < count && scene.is_asked[v]);
  };
  std::vector<char> is_face_asked(scene.is_asked.empty() ? 0 : cloth_.faces.rows(), 0);
  for (size_t f = 0; f < is_face_asked.size(); ++f)
    for (int k = 0; k < 3; ++k) is_face_asked[f] |= scene.is_asked[cloth_.faces(f, k)];
  cloth_.tree.mark(is_face_asked);
  const auto is_loose = [&](int v) { return !scene.is_loose.empty() && scene.is_loose[v]; };
  const auto is_face_off = [&](int g) {
    return !scene.is_face_off.empty() && (g < 0 || scene.is_face_off[g]);
  };

  const auto look = [&](const Part& p, const Plate& a, int f, const Part& q, const Plate& b, int g,
                        double range, double rest_range) {
    char own_a = p.owned[f], own_b = q.owned[g];
    if (&p != &q) {
      for (int k = 0; k < 3; ++k) {
        if (is_loose(p.faces(f, k))) own_a &= ~(1 << k);
        if (is_loose(p.faces(f, k))) own_a &= ~(8 << k), own_a &= ~(8 << (k + 2) % 3), own_b &= ~7;
        if (!is_corner_off.empty() && is_corner_off[q.faces(g, k)]) own_b &= ~(1 << k);
        if (is_face_off(g) && is_face_off(q.across(g, k))) own_b &= ~(8 << k);
      }
      if (!(own_a & 7) && !(own_b & 7) && (!(own_a >> 3) || !(own_b >> 3))) return;
    }
    double play = a.reach + b.reach;
    if (moves)
      play += (a.motion_high - b.motion_low)
                  .cwiseAbs()
                  .cwiseMax((a.motion_low - b.motion_high).cwiseAbs())
                  .norm();
    std::array<int, 3> va, vb;
    for (int k = 0; k < 3; ++k) va[k] = p.first + p.faces(f, k), vb[k] = q.first + q.faces(g, k);
    if (&p == &q)
      for (int k = 0; k < 3; ++k)
        if ((va[k] == vb[0] || va[k] == vb[1] || va[k] == vb[2]) && in_fan[va[k]] > range + play)
          return;
    const double apart = std::max(off_plane(a, b), off_plane(b, a));
    if (apart > std::max(range, rest_range) + play) return;
    const auto is_in = [](int v, const std::array<int, 3>& face) {
      return v == face[0] || v == face[1] || v == face[2];
    };
    const auto keep = [&](const std::array<int, 4>& vertices, PairKind kind, const PairPoints& x,
                          double at_most) {
      if (std::none_of(vertices.begin(), vertices.end(), is_asked)) return false;
      const double distance = std::sqrt(squared_pair_distance(kind, x));
      if (distance <= range + play) found.pairs.push_back({vertices, kind, distance});
      return distance <= at_most;
    };
    PairPoints x;
    for (int k = 0; k < 3; ++k) {
      const double most = std::max(range, rest_range) + play;
      if ((own_a >> k & 1) && !is_off_box(a.corner[k], b, most) && !is_in(va[k], vb)) {
        x << a.corner[k], b.corner[0], b.corner[1], b.corner[2];
        if (&p != &q && is_face_off(g)) {  // it tells that the vertex rests on nothing
          if (is_asked(va[k]) && squared_pair_distance(PairKind::kPointFace, x) <=
                                     (rest_range + play) * (rest_range + play))
            rest.push_back({va[k], g});
        } else if (keep({va[k], vb[0], vb[1], vb[2]}, PairKind::kPointFace, x, rest_range + play) &&
                   rest_range > 0)
          rest.push_back({va[k], g});
      }
      if ((own_b >> k & 1) && !is_off_box(b.corner[k], a, range + play) && !is_in(vb[k], va)) {
        x << b.corner[k], a.corner[0], a.corner[1], a.corner[2];
        keep({vb[k], va[0], va[1], va[2]}, PairKind::kPointFace, x, 0);
      }
    }
    if (apart > range + play) return;
    for (int k = 0; k < 3; ++k) {
      if (!(own_a >> (3 + k) & 1)) continue;
      const int m = (k + 1) % 3;
      for (int l = 0; l < 3; ++l) {
        if (!(own_b >> (3 + l) & 1)) continue;
        const int n = (l + 1) % 3;
        if (are_apart(a.corner[k], a.corner[m], b.corner[l], b.corner[n], range + play)) continue;
        if (va[k] == vb[l] || va[k] == vb[n] || va[m] == vb[l] || va[m] == vb[n]) continue;
        x << a.corner[k], a.corner[m], b.corner[l], b.corner[n];
        keep({va[k], va[m], vb[l], vb[n]}, PairKind::kEdgeEdge, x, 0);
      }
    }
  };
  for (const auto& [f, g] : meeting_faces(cloth_.tree))
    look(cloth_, cloth_plates[f], f, cloth_, cloth_plates[g], g, ranges.cloth_m, 0);
  for (const auto& [f, g] : meeting_faces(cloth_.tree, body_.tree))
    look(cloth_, cloth_plates[f], f, body_, body_plates_[g], g, ranges.body_m, ranges.rest_m);

  std::sort(rest.begin(), rest.end());
  found.rest_start.assign(count + 1, 0);
  for (const auto& [v, face] : rest) {
    ++found.rest_start[v + 1];
    found.rest_faces.push_back(face);
  }
  for (int v = 0; v < count; ++v) found.rest_start[v + 1] += found.rest_start[v];
  return found;
}

}  // namespace pleat::sim
