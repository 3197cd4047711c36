#include "sim/solver/pair_distance.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace pleat::sim {
namespace {

// Where on the two features the distance is measured, and which parameters are not at a bound.
struct Place {
  Vec<4> weights;
  Eigen::Matrix<double, 4, 2> directions;
  int free = 0;
};

// Of point p on the segment from a to b: 0 .. 1, clamped.
double along_segment(const Vec<3>& p, const Vec<3>& a, const Vec<3>& b) {
  const Vec<3> edge = b - a;
  const double length = edge.squaredNorm();
  return length > 0 ? std::clamp(edge.dot(p - a) / length, 0.0, 1.0) : 0.0;
}

Place point_face(const PairPoints& x) {
  const Vec<3> e1 = x.col(2) - x.col(1), e2 = x.col(3) - x.col(1), p = x.col(0) - x.col(1);
  const double a = e1.squaredNorm(), b = e1.dot(e2), c = e2.squaredNorm();
  const double u = p.dot(e1), v = p.dot(e2);
  const double determinant = a * c - b * b;
  Place place;
  place.directions.setZero();
  const double s = c * u - b * v, t = a * v - b * u;  // times the determinant
  if (determinant > 1e-12 * a * c && s > 0 && t > 0 && s + t < determinant) {
    const double s1 = s / determinant, t1 = t / determinant;
    place.weights << 1, -(1 - s1 - t1), -s1, -t1;
    place.directions.col(0) << 0, 1, -1, 0;
    place.directions.col(1) << 0, 1, 0, -1;
    place.free = 2;
    return place;
  }
  double best = -1;
  for (int k = 0; k < 3; ++k) {
    const int from = 1 + k, to = 1 + (k + 1) % 3;
    const double at = along_segment(x.col(0), x.col(from), x.col(to));
    const double distance =
        (x.col(0) - (1 - at) * x.col(from) - at * x.col(to)).squaredNorm();
    if (best >= 0 && distance >= best) continue;
    best = distance;
    place.weights << 1, 0, 0, 0;
    place.weights[from] = -(1 - at);
    place.weights[to] = -at;
    place.directions.setZero();
    place.free = at > 0 && at < 1 ? 1 : 0;
    place.directions(from, 0) = place.free;
    place.directions(to, 0) = -place.free;
  }
  return place;
}

Place edge_edge(const PairPoints& x) {
  const Vec<3> d1 = x.col(1) - x.col(0), d2 = x.col(3) - x.col(2), r = x.col(0) - x.col(2);
  const double a = d1.squaredNorm(), b = d1.dot(d2), c = d2.squaredNorm();
  const double determinant = a * c - b * b;
  Place place;
  place.directions.setZero();
  if (determinant > 1e-10 * a * c) {
    const double s = (b * d2.dot(r) - c * d1.dot(r)) / determinant;
    const double t = (a * d2.dot(r) - b * d1.dot(r)) / determinant;
    if (s > 0 && s < 1 && t > 0 && t < 1) {
      place.weights << 1 - s, s, -(1 - t), -t;
      place.directions.col(0) << -1, 1, 0, 0;
      place.directions.col(1) << 0, 0, 1, -1;
      place.free = 2;
      return place;
    }
  }
  // Not inside both: at an end of one of them.
  double best = -1;
  for (int k = 0; k < 4; ++k) {
    const int from = k < 2 ? 2 : 0, to = from + 1;
    const double at = along_segment(x.col(k), x.col(from), x.col(to));
    const double distance =
        (x.col(k) - (1 - at) * x.col(from) - at * x.col(to)).squaredNorm();
    if (best >= 0 && distance >= best) continue;
    best = distance;
    const double sign = k < 2 ? 1 : -1;  // the first edge counts positive
    place.weights.setZero();
    place.weights[k] = sign;
    place.weights[from] = -sign * (1 - at);
    place.weights[to] = -sign * at;
    place.directions.setZero();
    place.free = at > 0 && at < 1 ? 1 : 0;
    place.directions(from, 0) = place.free;
    place.directions(to, 0) = -place.free;
  }
  return place;
}

Place measure(PairKind kind, const PairPoints& x) {
  return kind == PairKind::kPointFace ? point_face(x) : edge_edge(x);
}

}  // namespace

PairDistance pair_distance(PairKind kind, const PairPoints& x) {
  const Place place = measure(kind, x);
  PairDistance result;
  result.difference = x * place.weights;
  result.squared = result.difference.squaredNorm();
  result.weights = place.weights;
  result.directions = place.directions;
  result.free = place.free;
  return result;
}

double squared_pair_distance(PairKind kind, const PairPoints& x) {
  return (x * measure(kind, x).weights).squaredNorm();
}

double squared_sine_of_edges(const PairPoints& x) {
  const Vec<3> a = x.col(1) - x.col(0), b = x.col(3) - x.col(2);
  return a.cross(b).squaredNorm() / (a.squaredNorm() * b.squaredNorm());
}

}  // namespace pleat::sim
