#include "core/exact_predicates.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace pleat {
namespace {

// An exact sum of doubles that do not overlap, ascending in magnitude, without zeros: Shewchuk
// 1997, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates". Exact
// while nothing over- or underflows, which for metres it does not.
using Expansion = std::vector<double>;

void add(Expansion& e, double b) {
  size_t kept = 0;
  for (const double component : e) {
    const double sum = b + component;
    const double virtual_part = sum - b;
    const double error = (b - (sum - virtual_part)) + (component - virtual_part);
    if (error != 0) e[kept++] = error;
    b = sum;
  }
  e.resize(kept);
  if (b != 0) e.push_back(b);
}

Expansion operator+(Expansion e, const Expansion& f) {
  for (const double component : f) add(e, component);
  return e;
}

Expansion operator-(Expansion e, const Expansion& f) {
  for (const double component : f) add(e, -component);
  return e;
}

Expansion operator*(const Expansion& e, const Expansion& f) {
  Expansion result;
  for (const double a : e) {
    for (const double b : f) {
      const double product = a * b;
      add(result, std::fma(a, b, -product));
      add(result, product);
    }
  }
  return result;
}

Expansion difference(double a, double b) {
  Expansion result;
  add(result, a);
  add(result, -b);
  return result;
}

int sign(double x) { return (x > 0) - (x < 0); }
int sign(const Expansion& e) { return e.empty() ? 0 : sign(e.back()); }

constexpr double kHalfUlp = 0x1p-53;

bool intervals_meet(double a, double b, double c, double d) {
  return std::max(a, b) >= std::min(c, d) && std::max(c, d) >= std::min(a, b);
}

bool segments_meet(const Vec<2>& a, const Vec<2>& b, const Vec<2>& p, const Vec<2>& q) {
  return intervals_meet(a[0], b[0], p[0], q[0]) && intervals_meet(a[1], b[1], p[1], q[1]) &&
         orientation(a, b, p) * orientation(a, b, q) <= 0 &&
         orientation(p, q, a) * orientation(p, q, b) <= 0;
}

bool segment_meets_triangle(const Vec<2>& p, const Vec<2>& q, const std::array<Vec<2>, 3>& t) {
  for (int k = 0; k < 3; ++k) {
    if (segments_meet(p, q, t[k], t[(k + 1) % 3])) return true;
  }
  const int side = orientation(t[0], t[1], p);  // no edge is touched: wholly inside or outside
  return side != 0 && side == orientation(t[1], t[2], p) && side == orientation(t[2], t[0], p);
}

// p_side, q_side: of the triangle's plane.
bool segment_meets_triangle(const Vec<3>& p, const Vec<3>& q, int p_side, int q_side,
                            const std::array<Vec<3>, 3>& t) {
  if (p_side * q_side > 0) return false;
  std::array<int, 3> turns;  // of the line pq around each edge
  for (int k = 0; k < 3; ++k) turns[k] = orientation(p, q, t[k], t[(k + 1) % 3]);
  if (p_side != 0 || q_side != 0) {
    const auto [low, high] = std::minmax_element(turns.begin(), turns.end());
    return *low >= 0 || *high <= 0;
  }
  // All in one plane (the turns tell, where the triangle is a segment and has no plane). Then the
  // shapes meet where their shadows along all three axes do: at least one shadow is faithful.
  if (turns[0] != 0 || turns[1] != 0 || turns[2] != 0) return false;
  for (int axis = 0; axis < 3; ++axis) {
    const auto shadow = [axis](const Vec<3>& x) {
      return Vec<2>(x[(axis + 1) % 3], x[(axis + 2) % 3]);
    };
    if (!segment_meets_triangle(shadow(p), shadow(q), {shadow(t[0]), shadow(t[1]), shadow(t[2])})) {
      return false;
    }
  }
  return true;
}

bool edges_meet_triangle(const std::array<Vec<3>, 3>& s, const std::array<int, 3>& sides,
                         const std::array<Vec<3>, 3>& t) {
  for (int k = 0; k < 3; ++k) {
    const int next = (k + 1) % 3;
    if (segment_meets_triangle(s[k], s[next], sides[k], sides[next], t)) return true;
  }
  return false;
}

std::array<int, 3> sides_of(const std::array<Vec<3>, 3>& s, const std::array<Vec<3>, 3>& t) {
  return {orientation(t[0], t[1], t[2], s[0]), orientation(t[0], t[1], t[2], s[1]),
          orientation(t[0], t[1], t[2], s[2])};
}

bool is_one_sided(const std::array<int, 3>& sides) {
  return sides[0] != 0 && sides[0] == sides[1] && sides[1] == sides[2];
}

}  // namespace

int orientation(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c, const Vec<3>& d) {
  const Vec<3> u = a - d, v = b - d, w = c - d;
  const double vw1 = v[0] * w[1], vw2 = w[0] * v[1], wu1 = w[0] * u[1], wu2 = u[0] * w[1],
               uv1 = u[0] * v[1], uv2 = v[0] * u[1];
  const double determinant = u[2] * (vw1 - vw2) + v[2] * (wu1 - wu2) + w[2] * (uv1 - uv2);
  const double permanent = std::abs(u[2]) * (std::abs(vw1) + std::abs(vw2)) +
                           std::abs(v[2]) * (std::abs(wu1) + std::abs(wu2)) +
                           std::abs(w[2]) * (std::abs(uv1) + std::abs(uv2));
  // Shewchuk's bound on the rounding error of the line above.
  if (std::abs(determinant) > (7 + 56 * kHalfUlp) * kHalfUlp * permanent) return sign(determinant);
  const Expansion ux = difference(a[0], d[0]), uy = difference(a[1], d[1]),
                  uz = difference(a[2], d[2]), vx = difference(b[0], d[0]),
                  vy = difference(b[1], d[1]), vz = difference(b[2], d[2]),
                  wx = difference(c[0], d[0]), wy = difference(c[1], d[1]),
                  wz = difference(c[2], d[2]);
  return sign(uz * (vx * wy - wx * vy) + vz * (wx * uy - ux * wy) + wz * (ux * vy - vx * uy));
}

int orientation(const Vec<2>& a, const Vec<2>& b, const Vec<2>& c) {
  const double left = (a[0] - c[0]) * (b[1] - c[1]), right = (a[1] - c[1]) * (b[0] - c[0]);
  const double bound = (3 + 16 * kHalfUlp) * kHalfUlp * (std::abs(left) + std::abs(right));
  if (std::abs(left - right) > bound) return sign(left - right);
  return sign(difference(a[0], c[0]) * difference(b[1], c[1]) -
              difference(a[1], c[1]) * difference(b[0], c[0]));
}

// Two triangles meet where an edge of one meets the other.
bool triangles_meet(const std::array<Vec<3>, 3>& s, const std::array<Vec<3>, 3>& t) {
  const std::array<int, 3> s_sides = sides_of(s, t);
  if (is_one_sided(s_sides)) return false;
  const std::array<int, 3> t_sides = sides_of(t, s);
  if (is_one_sided(t_sides)) return false;
  return edges_meet_triangle(s, s_sides, t) || edges_meet_triangle(t, t_sides, s);
}

}  // namespace pleat
