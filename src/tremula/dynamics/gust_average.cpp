#include "tremula/dynamics/gust_average.hpp"

#include "tremula/base/simd.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>

#include <Eigen/Eigenvalues>

namespace tremula {
namespace {

// exp(-x) for x >= 0, to 1e-15: 2^n times a polynomial for 2^f, f in [-1/2, 1/2].
TREMULA_INLINE double exp_minus(double x) {
  constexpr double to_integer = 6755399441055744.0;  // 1.5 * 2^52: what is added to it has no fraction left
  const double y = x < 700 ? -x : -700, shifted = y * std::numbers::log2e + to_integer;
  const double n = shifted - to_integer;
  const double f = (y - n * 0.693147180369123816490) - n * 1.90821492927058770002e-10;  // ln 2 in two parts
  double series = 1.0 / 479001600;
  for (const double factor : {1.0 / 39916800, 1.0 / 3628800, 1.0 / 362880, 1.0 / 40320, 1.0 / 5040, 1.0 / 720,
                              1.0 / 120, 1.0 / 24, 1.0 / 6, 0.5, 1.0, 1.0}) {
    series = series * f + factor;
  }
  return series * std::bit_cast<double>((std::bit_cast<std::uint64_t>(shifted) + 1023) << 52);
}

// |v| = int (1 - exp(-t |v|^2)) t^(-3/2) dt / (2 sqrt(pi)), and the average of exp(-t |v|^2) over a Gaussian
// is known. The integral over ln t by the trapezoidal rule: its integrand is analytic for |Im ln t| < pi/2,
// so that a step of 1 leaves about exp(-pi^2) = 5e-5. Nodes at ln(t R^2) = -6 … 7, R^2 the mean square of the
// speed; the last two of the array, without weight, make it whole vectors.
constexpr int node_count = 14, padded_count = 16;
constexpr double first_node = -6;
using Nodes = Eigen::Array<double, padded_count, 1>;

struct Rule {
  Nodes t = Nodes::Zero();  // of R^2 t
  Nodes weight = Nodes::Zero(), reference = Nodes::Zero();
  // Below the nodes 1 - exp(-t |v|^2) is t |v|^2: a geometric series of t times weight.
  double moment = std::exp(first_node / 2) / (std::exp(0.5) - 1) / (2 * std::sqrt(std::numbers::pi));

  Rule() {
    for (int k = 0; k < node_count; ++k) {
      t[k] = std::exp(first_node + k);
      weight[k] = 1 / (2 * std::sqrt(std::numbers::pi * t[k]));
      reference[k] = exp_minus(t[k]);
    }
  }
};

const Rule& rule() {
  static const Rule rule;
  return rule;
}

// The function h(|v|^2) = |v| g(|v|) about |v| = R, and its mixture at the nodes.
struct SpeedFunction {
  double value, twice_slope;  // h(R^2) [m/s], 2 h'(R^2) [s/m]
  Nodes weight;               // of 1 - exp(-t |v|^2) [m/s]
  double moment;              // of t below the nodes [s/m]
};

SpeedFunction without_folding(double speed) {
  return {speed, 1 / speed, speed * rule().weight, rule().moment / speed};
}

// With C the covariance, (1 + 2 t C)^-1 = (1 + 2 t A + 4 t^2 B)/(1 + 2 t tr C + 4 t^2 tr B + 8 t^3 det C),
// A = tr C - C and B the adjugate of C: no principal axes are needed. Across an axis all of that is of
// the plane there: identity is that of the plane, and B, which points out of it, meets nothing and is left
// out.
struct Cloud {
  Vec3 mean;
  Mat3 covariance, identity, a, b;
  double trace, trace_b, determinant;
};

double at_least_zero(double x) { return x < 0 ? 0 : x; }  // what is not a number stays so

Mat3 adjugate(const Mat3& m) {
  Mat3 result;
  for (int i = 0; i < 3; ++i) result.row(i) = m.col((i + 1) % 3).cross(m.col((i + 2) % 3)).transpose();
  return result;
}

// In space. Eigenvalues are 0 or more where all coefficients of their polynomial are.
Cloud cloud_of(const GustStatistics& gusts) {
  const auto with = [&](const Mat3& c) {
    const Mat3 b = adjugate(c);
    return Cloud{gusts.mean, c,         Mat3::Identity(), c.trace() * Mat3::Identity() - c,
                 b,          c.trace(), b.trace(),        c.row(0).dot(b.col(0))};
  };
  Cloud cloud = with(gusts.covariance);
  if (cloud.trace < 0 || cloud.trace_b < 0 || cloud.determinant < 0) {
    const Eigen::SelfAdjointEigenSolver<Mat3> principal(gusts.covariance);
    const Mat3& axes = principal.eigenvectors();
    cloud = with(axes * principal.eigenvalues().cwiseMax(0).asDiagonal() * axes.transpose());
  }
  cloud.trace_b = at_least_zero(cloud.trace_b);
  cloud.determinant = at_least_zero(cloud.determinant);
  return cloud;
}

Cloud across(const Cloud& cloud, const Vec3& axis) {
  const Mat3 along = axis * axis.transpose(), across = Mat3::Identity() - along;
  const Vec3 mixed = cloud.covariance * axis;
  const double own = axis.dot(mixed), trace = at_least_zero(cloud.trace - own);
  const Mat3 covariance =
      cloud.covariance - axis * mixed.transpose() - mixed * axis.transpose() + own * along;
  return {cloud.mean - axis.dot(cloud.mean) * axis,
          covariance,
          across,
          trace * across - covariance,
          Mat3::Zero(),
          trace,
          at_least_zero(axis.dot(cloud.b * axis)),
          0};
}

double mean_square(const Cloud& cloud) { return cloud.mean.squaredNorm() + cloud.trace; }

// In u = 2 t R^2, from the constant up: of det(1 + u C/R^2), and of that times m (1 + u C/R^2)^-1 m/R^2.
struct Polynomials {
  double determinant[4], exponent[3];
};

// Over the nodes, with q their weight times p: of the weight times exp(-t R^2) less q, of u q and u^2 q, of
// u (q/det less that again), and of u^2 q/det to u^5 q/det.
constexpr int sum_count = 8;
using Sums = std::array<double, sum_count>;

// In halves: the order in which vectors add up, whatever their width.
TREMULA_INLINE double sum_of_nodes(double* terms) {
  for (int k = 0; k < 8; ++k) terms[k] += terms[k + 8];
  for (int k = 0; k < 4; ++k) terms[k] += terms[k + 4];
  for (int k = 0; k < 2; ++k) terms[k] += terms[k + 2];
  return terms[0] + terms[1];
}

TREMULA_CLONES void sum_over_nodes(const Nodes& weight, const Polynomials& of, Sums& sums) {
  const Rule& nodes = rule();
  const auto [d0, d1, d2, d3] = of.determinant;
  const auto [e0, e1, e2] = of.exponent;
  double terms[sum_count][padded_count];
  for (int k = 0; k < padded_count; ++k) {
    const double t = nodes.t[k], u = 2 * t, u2 = u * u;
    const double inverse = 1 / (d0 + u * (d1 + u * (d2 + u * d3)));
    const double exponent = t * (e0 + u * (e1 + u * e2)) * inverse;
    const double q = weight[k] * inverse * std::sqrt(inverse) * exp_minus(exponent);
    const double given = weight[k] * nodes.reference[k], again = q * inverse;
    terms[0][k] = given - q;
    terms[1][k] = u * q;
    terms[2][k] = u2 * q;
    terms[3][k] = u * (again - given);
    terms[4][k] = u2 * again;
    terms[5][k] = u2 * u * again;
    terms[6][k] = u2 * u2 * again;
    terms[7][k] = u2 * u2 * u * again;
  }
  for (int i = 0; i < sum_count; ++i) sums[static_cast<std::size_t>(i)] = sum_of_nodes(terms[i]);
}

// Of h(|v|^2) v. With Q = (1 + 2 t C)^-1 and p = E exp(-t |v|^2) = sqrt(det Q) exp(-t m Q m), Gaussian
// integrals give E v exp(-t |v|^2) = p Q m, and the derivative of that by m is p Q - 2 t p Q m (Q m)^T. What
// exp(-t R^2) gives is known, h(R^2) and h'(R^2); the rule has the difference only, nothing without gusts.
AverageForce average(const Cloud& cloud, const SpeedFunction& function) {
  const Vec3 &m = cloud.mean, am = cloud.a * m, bm = cloud.b * m;
  const double r = 1 / mean_square(cloud), r2 = r * r;
  Sums sums;
  sum_over_nodes(function.weight,
                 {{1, r * cloud.trace, r2 * cloud.trace_b, r2 * r * cloud.determinant},
                  {r * m.squaredNorm(), r2 * m.dot(am), r2 * r * m.dot(bm)}},
                 sums);
  AverageForce result;
  result.per_velocity = (function.value + sums[0]) * cloud.identity + 2 * function.moment * cloud.covariance -
                        r * sums[1] * cloud.a - r2 * sums[2] * cloud.b;
  result.mean = result.per_velocity * m;
  const Vec3 of_m = (function.twice_slope + r * sums[3]) * m + r2 * sums[4] * am + r2 * r * sums[5] * bm;
  const Vec3 of_am = r2 * sums[4] * m + r2 * r * sums[5] * am + r2 * r2 * sums[6] * bm;
  const Vec3 of_bm = r2 * r * sums[5] * m + r2 * r2 * sums[6] * am + r2 * r2 * r * sums[7] * bm;
  result.per_velocity += m * of_m.transpose() + am * of_am.transpose() + bm * of_bm.transpose();
  return result;
}

AverageForce average_in_space(const GustStatistics& gusts, const auto& function_at) {
  const Cloud cloud = cloud_of(gusts);
  const double square = mean_square(cloud);
  if (square == 0) return {};
  return average(cloud, function_at(std::sqrt(square)));
}

// The mixture of a folding law is tabulated in ln(t U_f^2), four steps to one of the rule.
constexpr int steps_a_node = 4;
constexpr double table_step = 1.0 / steps_a_node, table_start = -26, table_end = 28;
constexpr int table_size = static_cast<int>((table_end - table_start) * steps_a_node) + 1;

// x^(1/2) (1 + x)^-b = int (1 - exp(-t x)) w(t) t^(-3/2) dt / (2 sqrt(pi)) with
// w = -2 sqrt(pi) t^b M(b, b - 1/2, -t)/Gamma(b - 1/2), M Kummer's function (DLMF 13.10.4, continued in its
// b). Its series by Kummer's transformation, exp(-t) M(-1/2, b - 1/2, t), all but one of whose terms have one
// sign; far out its asymptotic series (DLMF 13.7.2).
double mixture_density(double b, double t) {
  if (t > 40) {
    double sum = 0, term = 1;
    for (int k = 0; k < 12; ++k) {
      sum += term;
      term *= (b + k) * (1.5 + k) / ((k + 1) * t);
    }
    return sum;
  }
  double sum = b - 0.5, term = -0.5 * t;
  for (int k = 1; k < 160; ++k) {
    sum += term;
    term *= (k - 0.5) * t / ((k + 1) * (b - 0.5 + k));
  }
  return -2 * std::sqrt(std::numbers::pi) * std::pow(t, b) * std::exp(-t) * sum / std::tgamma(b + 0.5);
}

// Catmull–Rom between the entries of a table.
struct Place {
  int index;  // of the first of four entries
  std::array<double, 4> share;
  double in(const std::vector<double>& table, int k = 0) const {
    const double* at = table.data() + index + steps_a_node * k;
    return share[0] * at[0] + share[1] * at[1] + share[2] * at[2] + share[3] * at[3];
  }
};

Place place_in_table(double logarithm) {
  const double place = (logarithm - table_start) / table_step;
  const int index = static_cast<int>(place);
  const double x = place - index, y = 1 - x;
  return {index - 1,
          {-0.5 * x * y * y, 1 + x * x * (1.5 * x - 2.5), 1 + y * y * (1.5 * y - 2.5), -0.5 * x * x * y}};
}

SpeedFunction with_folding(const FoldingMixture& mixture, double speed) {
  const double factor = folding_factor(mixture.law, speed);
  // Beyond the table the law is a power of the speed, whose mixture has one form. In this order of their
  // arguments min and max take what is not a number to the table, too.
  const double wanted = mixture.law.folding_speed / speed, ratio = std::min(1e4, std::max(1e-4, wanted));
  const double beyond = factor / folding_factor({mixture.law.vogel_exponent, ratio}, 1);
  const Place place = place_in_table(first_node + 2 * std::log(ratio));
  SpeedFunction function = without_folding(speed);
  for (int k = 0; k < node_count; ++k) function.weight[k] *= beyond * place.in(mixture.density, k);
  function.value *= factor;
  function.twice_slope *= factor * (1 + folding_slope(mixture.law, speed));
  function.moment = beyond * place.in(mixture.moment) / (ratio * speed);
  return function;
}

}  // namespace

FoldingMixture mix_folding(const FoliageLaw& law) {
  check_foliage(law);
  FoldingMixture mixture{law, std::vector<double>(table_size), std::vector<double>(table_size)};
  const double b = -law.vogel_exponent / 2;
  const auto share_at = [&](std::size_t i) {  // of one node of the rule, in the moment
    const double root_t = std::exp((table_start + table_step * static_cast<double>(i)) / 2);
    return mixture.density[i] * root_t / (2 * std::sqrt(std::numbers::pi));
  };
  for (std::size_t i = 0; i < table_size; ++i) {
    mixture.density[i] = mixture_density(b, std::exp(table_start + table_step * static_cast<double>(i)));
    // At the start of the table a geometric series, as the density goes with t^b there.
    mixture.moment[i] = i < steps_a_node ? share_at(i) / (std::exp(0.5 + b) - 1)
                                         : mixture.moment[i - steps_a_node] + share_at(i - steps_a_node);
  }
  return mixture;
}

AverageForce average_drag_across(const Vec3& axis, const GustStatistics& gusts) {
  const Cloud cloud = across(cloud_of(gusts), axis);
  const double square = mean_square(cloud);
  if (square == 0) return {};
  return average(cloud, without_folding(std::sqrt(square)));
}

AverageForce average_drag(const GustStatistics& gusts) { return average_in_space(gusts, without_folding); }

AverageForce average_folding_drag(const FoldingMixture& mixture, const GustStatistics& gusts) {
  return average_in_space(gusts, [&](double speed) { return with_folding(mixture, speed); });
}

AverageForce along_normal(const AverageForce& average_drag, const Vec3& normal) {
  const Mat3 onto = normal * normal.transpose();
  return {onto * average_drag.mean, onto * average_drag.per_velocity};
}

}  // namespace tremula
