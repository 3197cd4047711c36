#include "sim/forces/membrane_law.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pleat::sim {
namespace {

MembraneResponse st_venant_kirchhoff(const MembraneLaw& law, const Vec<3>& g, Order order) {
  const double lambda = law.lambda, mu = law.mu, trace = g[0] + g[1];
  MembraneResponse response;
  response.energy =
      0.5 * lambda * trace * trace + mu * (g[0] * g[0] + g[1] * g[1] + 0.5 * g[2] * g[2]);
  if (order < Order::kGradient) return response;
  response.stress << lambda * trace + 2 * mu * g[0], lambda * trace + 2 * mu * g[1], mu * g[2];
  if (order < Order::kProjectedHessian) return response;
  response.tangent << lambda + 2 * mu, lambda, 0, lambda, lambda + 2 * mu, 0, 0, 0, mu;
  return response;
}

MembraneResponse neo_hookean(const MembraneLaw& law, const Vec<3>& g, Order order) {
  const double lambda = law.lambda, mu = law.mu;
  const double c00 = 1 + 2 * g[0], c11 = 1 + 2 * g[1], c01 = g[2];
  const double growth = 2 * (g[0] + g[1]) + 4 * g[0] * g[1] - c01 * c01;  // J^2 - 1
  const double squared_j = 1 + growth;
  MembraneResponse response;
  if (!(squared_j > 0)) {  // crushed to a line: no state at all
    response.energy = std::numeric_limits<double>::infinity();
    response.stress.setConstant(std::numeric_limits<double>::quiet_NaN());
    response.tangent.setConstant(std::numeric_limits<double>::quiet_NaN());
    return response;
  }
  const double log_j = 0.5 * std::log1p(growth);
  response.energy = mu * (g[0] + g[1] - log_j) + 0.5 * lambda * log_j * log_j;
  if (order < Order::kGradient) return response;
  const Vec<3> inverse(c11 / squared_j, c00 / squared_j, -c01 / squared_j);  // of C: 00, 11, 01
  response.stress = lambda * log_j * inverse;  // and mu (I - C^-1), exact for small strains too
  response.stress +=
      mu / squared_j * Vec<3>(2 * g[0] * c11 - c01 * c01, 2 * g[1] * c00 - c01 * c01, c01);
  if (order < Order::kProjectedHessian) return response;
  const double i = inverse[0], j = inverse[1], k = inverse[2];
  Mat<3> turned;  // -d(C^-1)/dg
  turned << 2 * i * i, 2 * k * k, 2 * i * k, 2 * k * k, 2 * j * j, 2 * j * k, 2 * i * k, 2 * j * k,
      i * j + k * k;
  response.tangent = lambda * inverse * inverse.transpose() + (mu - lambda * log_j) * turned;
  return response;
}

// A function of the strain with as many of its derivatives as Depth says.
template <int Depth>
struct Function {
  double value;
  Vec<3> gradient;
  Mat<3> hessian;
};

template <int Depth>
Function<Depth> operator*(const Function<Depth>& a, const Function<Depth>& b) {
  Function<Depth> product;
  product.value = a.value * b.value;
  if constexpr (Depth >= 1) product.gradient = a.value * b.gradient + b.value * a.gradient;
  if constexpr (Depth >= 2) {
    const Mat<3> mixed = a.gradient * b.gradient.transpose();
    product.hessian = a.value * b.hessian + b.value * a.hessian + mixed + mixed.transpose();
  }
  return product;
}

template <int Depth>
Function<Depth> operator+(const Function<Depth>& a, const Function<Depth>& b) {
  Function<Depth> sum;
  sum.value = a.value + b.value;
  if constexpr (Depth >= 1) sum.gradient = a.gradient + b.gradient;
  if constexpr (Depth >= 2) sum.hessian = a.hessian + b.hessian;
  return sum;
}

// outer: value, first and second derivative at x.
template <int Depth>
Function<Depth> compose(const Vec<3>& outer, const Function<Depth>& x) {
  Function<Depth> result;
  result.value = outer[0];
  if constexpr (Depth >= 1) result.gradient = outer[1] * x.gradient;
  if constexpr (Depth >= 2)
    result.hessian = outer[2] * x.gradient * x.gradient.transpose() + outer[1] * x.hessian;
  return result;
}

// Q_k, for stiffness k = (k_uu, k_uv, k_vv, k_s).
template <int Depth>
Function<Depth> quadratic(const Vec<4>& k, const Vec<3>& g) {
  Function<Depth> q;
  const double u = k[0] * g[0] + k[1] * g[1], v = k[1] * g[0] + k[2] * g[1], w = k[3] * g[2];
  q.value = u * g[0] + v * g[1] + 0.5 * w * g[2];
  if constexpr (Depth >= 1) q.gradient << 2 * u, 2 * v, w;
  if constexpr (Depth >= 2) q.hessian << 2 * k[0], 2 * k[1], 0, 2 * k[1], 2 * k[2], 0, 0, 0, k[3];
  return q;
}

constexpr double kTableStrain = 13.0 / 72;  // Green strain of a stretch of 7/6

// Direction of the larger stretch, cos(2 phi), phi from axis 0. d > 0: the principal strains'
// difference.
template <int Depth>
Function<Depth> direction(const Vec<3>& g, double d) {
  const double c = (g[0] - g[1]) / d, e = g[2] / d;
  Function<Depth> z;
  z.value = c;
  if constexpr (Depth >= 1) z.gradient << e * e / d, -e * e / d, -c * e / d;
  if constexpr (Depth >= 2) {
    const double q = 1 / (d * d), dd = -3 * q * c * e * e, dg = q * e * (2 * c * c - e * e);
    z.hessian << dd, -dd, dg, -dd, dd, -dg, dg, -dg, q * c * (2 * e * e - c * c);
  }
  return z;
}

// Size of the strain over the table's, where one principal strain is positive: that one.
template <int Depth>
Function<Depth> size_of_one(const Vec<3>& g, double d) {
  constexpr double kHalf = 0.5 / kTableStrain;
  const double c = (g[0] - g[1]) / d, e = g[2] / d;
  Function<Depth> t;
  t.value = kHalf * (g[0] + g[1] + d);
  if constexpr (Depth >= 1) t.gradient << kHalf * (1 + c), kHalf * (1 - c), kHalf * e;
  if constexpr (Depth >= 2) {
    const double q = kHalf / d, dd = q * e * e, dg = -q * c * e;
    t.hessian << dd, -dd, dg, -dd, dd, -dg, dg, -dg, q * c * c;
  }
  return t;
}

// Where both are positive: the fourth root of their fourth powers' sum r. And how much there is a
// direction, f = (difference of their squares)^2 / r: 1 where the smaller is zero, 0 where they are
// alike. Both are smooth where the principal strains cross.
template <int Depth>
struct TwoStrains {
  Function<Depth> t, f;
};
template <int Depth>
TwoStrains<Depth> two_strains(const Vec<3>& g, double d) {
  const double a = g[0], b = g[1], gamma = g[2];
  const double squares = a * a + b * b + 0.5 * gamma * gamma;  // of the principal strains, summed
  const double product = a * b - 0.25 * gamma * gamma;
  const double r = squares * squares - 2 * product * product;
  const double root = std::sqrt(std::sqrt(r)) / kTableStrain;
  const double difference = (a + b) * d;
  TwoStrains<Depth> both;
  both.t.value = root;
  both.f.value = difference * difference / r;  // = 2 - squares^2 / r
  if constexpr (Depth >= 1) {
    const Vec<3> d_squares(2 * a, 2 * b, gamma), d_product(b, a, -0.5 * gamma);
    const Vec<3> d_r = 2 * squares * d_squares - 4 * product * d_product;
    const double h = squares / r, hh = h * h;
    both.t.gradient = (0.25 * root / r) * d_r;
    both.f.gradient = hh * d_r - 2 * h * d_squares;
    if constexpr (Depth >= 2) {
      const Mat<3> outer = d_squares * d_squares.transpose(), r_r = d_r * d_r.transpose();
      Mat<3> d_d_r = 2 * outer - 4 * d_product * d_product.transpose();
      d_d_r(0, 0) += 4 * squares;
      d_d_r(1, 1) += 4 * squares;
      d_d_r(2, 2) += 2 * squares + 2 * product;
      d_d_r(0, 1) -= 4 * product;
      d_d_r(1, 0) -= 4 * product;
      both.t.hessian = (0.25 * root / r) * (d_d_r - (0.75 / r) * r_r);
      const Mat<3> mixed = (2 * h / r) * d_squares * d_r.transpose();
      both.f.hessian =
          hh * d_d_r - (2 * hh / r) * r_r + mixed + mixed.transpose() - (2 / r) * outer;
      both.f.hessian(0, 0) -= 4 * h;
      both.f.hessian(1, 1) -= 4 * h;
      both.f.hessian(2, 2) -= 2 * h;
    }
  }
  return both;
}

// s = 2/t^2 integral_0^t sigma(tau) tau dtau with its derivatives; sigma rises from 0 to 1 over the
// table's strain, straight but for a rounding of width w at either end.
Vec<3> averaged_rise(double t) {
  constexpr double w = 0.1, late = 1 - w;
  // ramp(u) = 0, u^2/(2 w), u - w/2; its slope, and the integrals of ramp and of u ramp.
  struct Ramp {
    double value, slope, integral, moment;
  };
  const auto ramp = [](double u) -> Ramp {
    if (u <= 0) return {0, 0, 0, 0};
    if (u < w) return {u * u / (2 * w), u / w, u * u * u / (6 * w), u * u * u * u / (8 * w)};
    return {u - w / 2, 1, u * u / 2 - w * u / 2 + w * w / 6,
            u * u * u / 3 - w * u * u / 4 + w * w * w / 24};
  };
  const Ramp up = ramp(t), down = ramp(t - late);
  const double sigma = (up.value - down.value) / late, slope = (up.slope - down.slope) / late;
  const double integral = (up.moment - down.moment - late * down.integral) / late;
  const double s = 2 * integral / (t * t), first = 2 / t * (sigma - s);
  return {s, first, (2 * (slope - first) - first) / t};
}

// The two rows beside direction z, and the weight of the second with its derivatives in z. It is
// level at inner rows, so that all is smooth, and nothing overshoots.
struct Between {
  int row, next;  // of law.rows
  Vec<3> weight;
};
Between rows_beside(double z) {
  constexpr double kMiddle =
      0.70710678118654752;  // cos 45 degrees; rows 1 .. 5: 1, .71, 0, -.71, -1
  const double a = std::abs(z), sign = z > 0 ? 1 : -1;
  const int step = z > 0 ? -1 : 1;
  if (a > kMiddle) {
    constexpr double length = 1 - kMiddle;
    const double u = std::min((a - kMiddle) / length, 1.0);
    return {3 + step, 3 + 2 * step, {u * u, sign * 2 * u / length, 2 / (length * length)}};
  }
  const double u = a / kMiddle;
  return {
      3,
      3 + step,
      {u * u * (3 - 2 * u), sign * 6 * u * (1 - u) / kMiddle, (6 - 12 * u) / (kMiddle * kMiddle)}};
}

// W = Q_0 + s (Q_mean - Q_0 + f (Q_z - Q_mean))
template <int Depth>
Function<Depth> measured(const MembraneLaw& law, const Vec<3>& g) {
  const Vec<4>&unstrained = law.rows[0], &mean = law.mean;
  const double delta = g[0] - g[1], d = std::sqrt(delta * delta + g[2] * g[2]);
  const double larger = 0.5 * (g[0] + g[1] + d), smaller = larger - d;
  const Function<Depth> at_rest = quadratic<Depth>(unstrained, g);
  if (!(larger > 1e-8)) return at_rest;  // s is below 1e-13

  const bool are_two = smaller > 0;
  if (are_two && !(d > 1e-7 * larger)) {  // f is below 1e-13
    const TwoStrains<Depth> two = two_strains<Depth>(g, d);
    return at_rest +
           compose(averaged_rise(two.t.value), two.t) * quadratic<Depth>(mean - unstrained, g);
  }
  const Function<Depth> z = direction<Depth>(g, d);
  const Between rows = rows_beside(z.value);
  const Vec<4>&row = law.rows[rows.row], &next = law.rows[rows.next];
  const Function<Depth> towards_next = compose(rows.weight, z) * quadratic<Depth>(next - row, g);
  if (!are_two) {
    const Function<Depth> t = size_of_one<Depth>(g, d);
    return at_rest + compose(averaged_rise(t.value), t) *
                         (quadratic<Depth>(row - unstrained, g) + towards_next);
  }
  const TwoStrains<Depth> two = two_strains<Depth>(g, d);
  return at_rest + compose(averaged_rise(two.t.value), two.t) *
                       (quadratic<Depth>(mean - unstrained, g) +
                        two.f * (quadratic<Depth>(row - mean, g) + towards_next));
}

MembraneResponse measured(const MembraneLaw& law, const Vec<3>& g, Order order) {
  MembraneResponse response;
  if (order == Order::kValue) {
    response.energy = measured<0>(law, g).value;
  } else if (order == Order::kGradient) {
    const Function<1> w = measured<1>(law, g);
    response.energy = w.value;
    response.stress = w.gradient;
  } else {
    const Function<2> w = measured<2>(law, g);
    response = {w.value, w.gradient, w.hessian};
  }
  return response;
}

}  // namespace

MembraneLaw make_membrane_law(const garment::Fabric& fabric) {
  MembraneLaw law;
  if (fabric.tables) {
    law.kind = MembraneLaw::Kind::kMeasured;
    for (size_t r = 0; r < law.rows.size(); ++r) {
      const std::array<double, 4>& k = fabric.tables->stretching[r];
      // Negative coupling and shear are noise of the fit and count as none, as in ARCSim; coupling
      // beyond the geometric mean would give energy away.
      law.rows[r] << k[0], std::clamp(k[1], 0.0, std::sqrt(k[0] * k[2])), k[2], std::max(k[3], 0.0);
    }
    law.mean = (law.rows[1] + law.rows[5]) / 8 + (law.rows[2] + law.rows[3] + law.rows[4]) / 4;
    return law;
  }
  const double y = fabric.youngs_modulus_N_per_m, nu = fabric.poisson_ratio;
  law.kind = fabric.membrane == garment::MembraneModel::kNeoHookean
                 ? MembraneLaw::Kind::kNeoHookean
                 : MembraneLaw::Kind::kStVenantKirchhoff;
  law.lambda = y * nu / (1 - nu * nu);
  law.mu = y / (2 * (1 + nu));
  return law;
}

MembraneResponse membrane_response(const MembraneLaw& law, const Vec<3>& g, Order order) {
  switch (law.kind) {
    case MembraneLaw::Kind::kNeoHookean:
      return neo_hookean(law, g, order);
    case MembraneLaw::Kind::kMeasured:
      return measured(law, g, order);
    default:
      return st_venant_kirchhoff(law, g, order);
  }
}

}  // namespace pleat::sim
