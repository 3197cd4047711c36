#include "sim/forces/barrier.h"

#include <Eigen/LU>
#include <cmath>

namespace pleat::sim {
namespace {

// B, B', B'' at u in (0, 1).
Vec<3> shape(double u) {
  const double log = std::log(u), rest = 1 - u, ratio = rest / u;
  return {-rest * rest * log, 2 * rest * log - rest * ratio,
          -2 * log + 4 * ratio + ratio * ratio};
}

BarrierTerm full_term(const Barrier& barrier, const PairPoints& x, Order order) {
  BarrierTerm term;
  term.place = pair_distance(barrier.kind, x);
  const double d = std::sqrt(term.place.squared), d_hat = barrier.distance, k = barrier.stiffness;
  if (!(d < d_hat)) return term;
  const Vec<3> b = shape(d / d_hat);
  term.value = k * d_hat * b[0];
  if (order < Order::kGradient) return term;
  term.slope = k * b[1];
  term.unit = term.place.difference / d;
  if (order < Order::kProjectedHessian) return term;
  term.radial = k * b[2] / d_hat;
  term.rotational = 0;
  if (order < Order::kHessian) return term;
  term.rotational = term.slope / d;  // of half the Hessian of D
  for (int l = 0; l < term.place.free; ++l) term.across[l] = x * term.place.directions.col(l);
  if (term.place.free == 2) {
    Mat<2> products;
    products << term.across[0].squaredNorm(), term.across[0].dot(term.across[1]),
        term.across[0].dot(term.across[1]), term.across[1].squaredNorm();
    term.inverse = products.inverse();
  } else if (term.place.free == 1) {
    term.inverse << 1 / term.across[0].squaredNorm(), 0, 0, 0;
  }
  return term;
}

// E m and its derivatives; c = |a|^2 |b|^2 - (a . b)^2.
void fade_out(const BarrierTerm& full, double c_0, const PairPoints& x, Order order,
              BarrierTerm& term) {
  const Vec<3> a = x.col(1) - x.col(0), b = x.col(3) - x.col(2);
  const double aa = a.squaredNorm(), bb = b.squaredNorm(), ab = a.dot(b);
  const double t = (aa * bb - ab * ab) / c_0;
  const double m = t * (2 - t), m1 = 2 * (1 - t) / c_0, m2 = -2 / (c_0 * c_0);
  term.value = m * full.value;
  if (order < Order::kGradient) return;
  auto faded = std::make_shared<BarrierTerm::Faded>();
  PairPoints dc, de;
  dc.col(1) = 2 * (bb * a - ab * b);
  dc.col(3) = 2 * (aa * b - ab * a);
  dc.col(0) = -dc.col(1);
  dc.col(2) = -dc.col(3);
  for (int k = 0; k < 4; ++k) de.col(k) = force_gradient(full, k);
  faded->gradient = m * de + full.value * m1 * dc;
  if (order >= Order::kProjectedHessian) {
    for (int k = 0; k < 4; ++k)
      for (int l = 0; l < 4; ++l)
        faded->hessian.block<3, 3>(3 * k, 3 * l) = m * hessian_block(full, k, l);
  }
  if (order >= Order::kHessian) {
    const Eigen::Map<const Vec<12>> c1(dc.data()), e1(de.data());
    faded->hessian += m1 * (e1 * c1.transpose() + c1 * e1.transpose()) +
                      full.value * m2 * c1 * c1.transpose();
    const Mat<3> one = Mat<3>::Identity(),
                 d2aa = 2 * (bb * one - b * b.transpose()),
                 d2bb = 2 * (aa * one - a * a.transpose()),
                 d2ab = 4 * a * b.transpose() - 2 * b * a.transpose() - 2 * ab * one;
    const double sign[4] = {-1, 1, -1, 1};
    for (int k = 0; k < 4; ++k)
      for (int l = 0; l < 4; ++l) {
        const Mat<3>& d2 = k < 2 ? (l < 2 ? d2aa : d2ab) : d2bb;
        const double factor = full.value * m1 * sign[k] * sign[l];
        if (k >= 2 && l < 2)
          faded->hessian.block<3, 3>(3 * k, 3 * l) += factor * d2ab.transpose();
        else
          faded->hessian.block<3, 3>(3 * k, 3 * l) += factor * d2;
      }
  }
  term.faded = std::move(faded);
}

}  // namespace

BarrierTerm barrier_term(const Barrier& barrier, const PairPoints& x, Order order) {
  if (barrier.kind == PairKind::kPointFace) return full_term(barrier, x, order);
  const Vec<3> a = x.col(1) - x.col(0), b = x.col(3) - x.col(2);
  const double c = a.cross(b).squaredNorm();
  if (c >= barrier.parallel) return full_term(barrier, x, order);
  constexpr double kNone = 1e-6;
  BarrierTerm term;
  term.place = pair_distance(barrier.kind, x);
  if (c < kNone * barrier.parallel) return term;
  const BarrierTerm full = full_term(barrier, x, order);
  if (full.value > 0) fade_out(full, barrier.parallel, x, order, term);
  return term;
}

// With n = r/d:  d2E = E'' (w n)(w n)^T + E'/d (w w^T (I - n n^T) - sum_kl m_k G^-1_kl m_l^T),
// m_k = w g_k + w_k r; g_k . r = 0 where the parameter is free.
Mat<3> hessian_block(const BarrierTerm& term, int a, int b) {
  if (term.faded) return term.faded->hessian.block<3, 3>(3 * a, 3 * b);
  const Vec<4>& w = term.place.weights;
  const Vec<3>& n = term.unit;
  Mat<3> block = term.radial * w[a] * w[b] * n * n.transpose();
  if (term.rotational == 0) return block;
  Mat<3> rest = w[a] * w[b] * (Mat<3>::Identity() - n * n.transpose());
  for (int k = 0; k < term.place.free; ++k)
    for (int l = 0; l < term.place.free; ++l) {
      const Vec<3> left = w[a] * term.across[k] + term.place.directions(a, k) * term.place.difference;
      const Vec<3> right = w[b] * term.across[l] + term.place.directions(b, l) * term.place.difference;
      rest -= term.inverse(k, l) * left * right.transpose();
    }
  return block + term.rotational * rest;
}

PairPoints hessian_product(const BarrierTerm& term, const PairPoints& p) {
  if (term.faded) {
    PairPoints product;
    Eigen::Map<Vec<12>>(product.data()) =
        term.faded->hessian * Eigen::Map<const Vec<12>>(p.data());
    return product;
  }
  const Vec<4>& w = term.place.weights;
  const Vec<3> u = p * w;
  const double along = term.unit.dot(u);
  PairPoints result = (term.radial * along * term.unit) * w.transpose();
  if (term.rotational == 0) return result;
  Vec<3> common = u - along * term.unit;
  Vec<2> moved = Vec<2>::Zero();
  for (int k = 0; k < term.place.free; ++k)
    moved[k] = term.across[k].dot(u) + term.place.difference.dot(p * term.place.directions.col(k));
  if (term.place.free > 0) {
    const Vec<2> c = term.place.free == 2 ? Vec<2>(term.inverse * moved)
                                          : Vec<2>(term.inverse(0, 0) * moved[0], 0);
    for (int k = 0; k < term.place.free; ++k) {
      common -= c[k] * term.across[k];
      result -= term.rotational * c[k] * term.place.difference *
                term.place.directions.col(k).transpose();
    }
  }
  result += term.rotational * common * w.transpose();
  return result;
}

LocalEnergy<12> barrier_energy(const Barrier& barrier, const Vec<12>& x, Order order) {
  const Eigen::Map<const PairPoints> points(x.data());
  const BarrierTerm term = barrier_term(barrier, points, order);
  LocalEnergy<12> energy;
  energy.value = term.value;
  energy.gradient.setZero();
  energy.hessian.setZero();
  if (term.value == 0 || order < Order::kGradient) return energy;
  for (int a = 0; a < 4; ++a) energy.gradient.segment<3>(3 * a) = force_gradient(term, a);
  if (order < Order::kProjectedHessian) return energy;
  for (int a = 0; a < 4; ++a)
    for (int b = 0; b < 4; ++b)
      energy.hessian.block<3, 3>(3 * a, 3 * b) = hessian_block(term, a, b);
  return energy;
}

}  // namespace pleat::sim
