#include "sim/body_contact.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/mesh.h"

namespace pleat::sim {
namespace {

constexpr double kSupport = 2;     // in mean edge lengths
constexpr double kStretch = 1.15;  // of the skin between the pose of construction and any other
constexpr double kAbove = 0.01;    // m: how high over the surface the field is asked for
constexpr double kOff =
    0.0005;  // m: how far off the surface a vertex is asked whether it lies inside

// Vertices around each face that are near it along the surface.
void find_near(const Points3& x, const Faces& faces, const Eigen::VectorXd& support,
               std::vector<int>& start, std::vector<int>& near) {
  const std::vector<std::vector<int>> neighbours = vertex_neighbours(faces, x.rows());
  std::vector<int> seen(x.rows(), -1), front;
  start.assign(1, 0);
  near.clear();
  for (int f = 0; f < faces.rows(); ++f) {
    front.assign({faces(f, 0), faces(f, 1), faces(f, 2)});
    for (int v : front) seen[v] = f;
    for (size_t i = 0; i < front.size(); ++i)
      for (int v : neighbours[front[i]]) {
        if (seen[v] == f) continue;
        const Vec<3> p = x.row(v).transpose();
        double distance = 1e30;
        for (int k = 0; k < 3; ++k)
          distance = std::min(distance, (p - x.row(faces(f, k)).transpose()).norm());
        if (distance > kStretch * (support[v] + kAbove)) continue;
        seen[v] = f;
        front.push_back(v);
      }
    std::sort(front.begin(), front.end());
    near.insert(near.end(), front.begin(), front.end());
    start.push_back(static_cast<int>(near.size()));
  }
}

}  // namespace

BodyCollider::BodyCollider(const Eigen::Ref<const Points3>& vertices, const Faces& faces)
    : tree_(vertices, faces), faces_of_vertex_(vertices.rows()) {
  for (int f = 0; f < faces.rows(); ++f)
    for (int c = 0; c < 3; ++c) faces_of_vertex_[faces(f, c)].push_back(f);
  for (const Edge& edge : edges(faces)) edges_.push_back(edge.vertices);
  support_ = Eigen::VectorXd::Zero(vertices.rows());
  Eigen::VectorXd count = Eigen::VectorXd::Zero(vertices.rows());
  for (const auto& [i, j] : edges_)
    for (int v : {i, j}) {
      support_[v] += kSupport * (vertices.row(i) - vertices.row(j)).norm();
      ++count[v];
    }
  support_.array() /= count.array().max(1);
  find_near(vertices, faces, support_, start_, near_);
  is_always_folded_ = folded(tree_);
  move_to(vertices);
}

void BodyCollider::move_to(const Eigen::Ref<const Points3>& vertices) {
  tree_.refit(vertices);
  stand(overlaps(tree_));
}

void BodyCollider::move_to(const SurfaceTree& posed, const std::vector<char>& is_off) {
  tree_.refit(posed.vertices());
  stand(is_off);
}

void BodyCollider::stand(const std::vector<char>& is_off) {
  is_off_ = is_off;
  normals_ = vertex_normals(vertices(), faces());
  on_.setOnes(vertices().rows());
  for (Eigen::Index f = 0; f < faces().rows(); ++f)
    for (int c = 0; c < 3 && is_off_[f]; ++c) on_[faces()(f, c)] = 0;
  fit_quadrics();
}

// Spreads from the faces that cross one another over the vertices that lie inside the body.
std::vector<char> BodyCollider::folded(const SurfaceTree& posed) const {
  const Points3& x = posed.vertices();
  std::vector<char> is_off(faces().rows(), 0), is_asked(x.rows(), 0);
  std::vector<int> front;
  const auto switch_off = [&](int face) {
    is_off[face] = 1;
    for (int c = 0; c < 3; ++c) {
      const int v = faces()(face, c);
      if (!is_asked[v]) front.push_back(v);
      is_asked[v] = 1;
    }
  };
  for (const auto& [a, b] : self_intersecting_faces(posed)) {
    switch_off(a);
    switch_off(b);
  }
  const Points3 normals = vertex_normals(x, faces());
  while (!front.empty()) {
    Points3 queries(front.size(), 3);
    for (size_t i = 0; i < front.size(); ++i)
      queries.row(i) = x.row(front[i]) + kOff * normals.row(front[i]);
    const Eigen::VectorXd winding = winding_numbers(posed, queries);
    std::vector<int> inside;
    for (size_t i = 0; i < front.size(); ++i)
      if (winding[i] > 0.5) inside.push_back(front[i]);
    front.clear();
    for (int v : inside)
      for (int face : faces_of_vertex_[v]) switch_off(face);
  }
  return is_off;
}

std::vector<char> BodyCollider::overlaps(const SurfaceTree& posed) const {
  std::vector<char> is_off = folded(posed);
  for (size_t f = 0; f < is_off.size(); ++f) is_off[f] &= !is_always_folded_[f];
  return is_off;
}

// Curvature along each edge at a vertex is 2 h / l^2, h the height over the tangent plane at which
// the edge ends: the tensor is the least-squares fit to those, a little held to their mean.
void BodyCollider::fit_quadrics() {
  const Points3& x = vertices();
  struct Fit {
    Mat<3> matrix = Mat<3>::Zero();
    Vec<3> right = Vec<3>::Zero();
    double weight = 0, curvature = 0;
  };
  std::vector<Fit> fits(x.rows());
  for (const auto& [i, j] : edges_) {
    const Vec<3> edge = (x.row(j) - x.row(i)).transpose();
    const double squared = edge.squaredNorm(), length = std::sqrt(squared);
    if (!(squared > 0)) continue;
    for (const int v : {i, j}) {
      const Vec<3> n = normals_.row(v).transpose(), u = n.unitOrthogonal();
      const Vec<3> along = v == i ? edge : Vec<3>(-edge);
      const double kappa = -2 * n.dot(along) / squared;
      const Vec<3> tangent = (along - n * n.dot(along)).normalized();
      const double a = u.dot(tangent), b = n.cross(u).dot(tangent);
      const Vec<3> row(a * a, 2 * a * b, b * b);
      Fit& fit = fits[v];
      fit.matrix += length * row * row.transpose();
      fit.right += length * kappa * row;
      fit.curvature += length * kappa;
      fit.weight += length;
    }
  }
  quadrics_.resize(x.rows());
  for (Eigen::Index v = 0; v < x.rows(); ++v) {
    const Vec<3> n = normals_.row(v).transpose();
    quadrics_[v] = {x.row(v).transpose(), 1 / (support_[v] * support_[v]), n, Mat<3>::Zero()};
    Fit& fit = fits[v];
    if (!(fit.weight > 0)) continue;
    constexpr double kHeld = 1e-3;
    fit.matrix.diagonal() += kHeld * fit.weight * Vec<3>(1, 2, 1);
    fit.right += kHeld * fit.curvature * Vec<3>(1, 0, 1);
    const Vec<3> k = fit.matrix.ldlt().solve(fit.right);
    const Vec<3> u = n.unitOrthogonal(), w = n.cross(u);
    Mat<3> tensor = k[0] * u * u.transpose() + k[2] * w * w.transpose() +
                    k[1] * (u * w.transpose() + w * u.transpose());
    // Sharper than the mesh can tell is not believed.
    const double most = kSupport / support_[v], size = tensor.norm();
    if (size > most) tensor *= most / size;
    quadrics_[v].curvature = tensor;
  }
}

bool BodyCollider::is_clear(int face) const {
  return on_[faces()(face, 0)] != 0 && on_[faces()(face, 1)] != 0 && on_[faces()(face, 2)] != 0;
}

double BodyCollider::share_on(int face, const Vec<3>& barycentric) const {
  double share = 0;
  for (int c = 0; c < 3; ++c) share += barycentric[c] * on_[faces()(face, c)];
  return share;
}

Vec<3> BodyCollider::point(int face, const Vec<3>& barycentric) const {
  Vec<3> blend = Vec<3>::Zero();
  for (int c = 0; c < 3; ++c)
    blend += barycentric[c] * vertices().row(faces()(face, c)).transpose();
  return blend;
}

Vec<3> BodyCollider::normal(int face, const Vec<3>& barycentric) const {
  Vec<3> blend = Vec<3>::Zero();
  for (int c = 0; c < 3; ++c) blend += barycentric[c] * normals_.row(faces()(face, c)).transpose();
  return blend.normalized();
}

// phi = sum w d / sum w, d = n . r + 1/2 r^T S r, r = x - p, w = a (1 - |r|^2 / h^2)^3; a falls off
// for what faces elsewhere.
BodyField BodyCollider::field(int face, const Vec<3>& normal, const Vec<3>& x, double beyond,
                              int order) const {
  constexpr double kAway = -0.2, kSame = 0.4;  // cosine to `normal`
  constexpr double kFew = 0.05;                // sum of weights below which `beyond` has one too
  // Sums over the quadrics: of w and w d, and with w' and w'' (by |r|^2, twice and four times) of
  // what the derivatives are made of once phi is known.
  double w_1 = 0, w_d = 0, w1_1 = 0, w1_d = 0;
  Vec<3> w_g = Vec<3>::Zero(), w1_r = w_g, w1_dr = w_g;
  Mat<3> w_S = Mat<3>::Zero(), w1_rg = w_S, w2_rr = w_S, w2_drr = w_S;
  for (int i = start_[face]; i < start_[face + 1]; ++i) {
    const Quadric& q = quadrics_[near_[i]];
    const Vec<3> r = x - q.point;
    const double rest = 1 - r.squaredNorm() * q.inverse_support;
    if (!(rest > 0)) continue;
    const double t = (q.normal.dot(normal) - kAway) / (kSame - kAway);
    if (!(t > 0)) continue;
    const double share = t < 1 ? t * t * (3 - 2 * t) : 1;
    const Vec<3> bent = q.curvature * r;
    const double d = q.normal.dot(r) + 0.5 * r.dot(bent), w = share * rest * rest * rest;
    w_1 += w;
    w_d += w * d;
    if (order < 1) continue;
    const double w1 = -6 * share * rest * rest * q.inverse_support;
    const Vec<3> g = q.normal + bent;
    w_g += w * g;
    w1_r += w1 * r;
    w1_dr += w1 * d * r;
    if (order < 2) continue;
    const double w2 = 24 * share * rest * q.inverse_support * q.inverse_support;
    const Mat<3> rr = r * r.transpose();
    w1_1 += w1;
    w1_d += w1 * d;
    w_S += w * q.curvature;
    w1_rg += w1 * r * g.transpose();
    w2_rr += w2 * rr;
    w2_drr += w2 * d * rr;
  }
  // At the edge of what the quadrics reach phi fades to `beyond`.
  const double lack = std::max(0.0, 1 - w_1 / kFew), rest = kFew * lack * lack * lack;
  const double rest_slope = -3 * lack * lack, rest_bend = 6 / kFew * lack;  // by the sum of weights
  const double sum = w_1 + rest;
  BodyField field;
  field.phi = (w_d + rest * beyond) / sum;
  if (order < 1) return field;
  const double off = beyond - field.phi, level = off * rest_slope - field.phi;
  field.gradient = (w_g + w1_dr + level * w1_r) / sum;
  if (order < 2) return field;
  const Mat<3> crossed =
      w1_rg - (1 + rest_slope) * w1_r * field.gradient.transpose();  // and its transpose
  field.hessian = w_S + w2_drr + level * w2_rr + off * rest_bend * w1_r * w1_r.transpose() +
                  crossed + crossed.transpose();
  field.hessian.diagonal().array() += w1_d + level * w1_1;
  field.hessian /= sum;
  return field;
}

}  // namespace pleat::sim
