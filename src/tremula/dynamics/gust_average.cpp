#include "tremula/dynamics/gust_average.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/Eigenvalues>

namespace tremula {
namespace {

// |v| = int (1 - exp(-t |v|^2)) t^(-3/2) dt / (2 sqrt(pi)), and the average of exp(-t |v|^2) over a Gaussian
// is a product over its principal axes. The integral over ln t by the trapezoidal rule: its integrand is
// analytic for |Im ln t| < pi/2, so that a step of 1 leaves about exp(-pi^2) = 5e-5. Nodes at
// ln(t R^2) = -6 … 7, R^2 the mean square of the speed.
constexpr int node_count = 14;
constexpr double first_node = -6;
using Nodes = Eigen::Array<double, node_count, 1>;

struct Rule {
  Nodes t = Nodes::LinSpaced(node_count, first_node, first_node + node_count - 1).exp();  // of R^2 t
  Nodes weight = 1 / (2 * std::sqrt(std::numbers::pi) * t.sqrt());
  Nodes reference = (-t).exp();
  // Below the nodes 1 - exp(-t |v|^2) is t |v|^2: a geometric series of t times weight.
  double moment = std::exp(first_node / 2) / (std::exp(0.5) - 1) / (2 * std::sqrt(std::numbers::pi));
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

template <int n>
struct Average {
  Eigen::Matrix<double, n, 1> mean;
  Eigen::Matrix<double, n, n> per_velocity;
};

template <int n>
double mean_square(const Eigen::Matrix<double, n, 1>& mean, const Eigen::Matrix<double, n, 1>& variance) {
  return mean.squaredNorm() + variance.sum();
}

// Of h(|v|^2) v in the principal axes of the gusts. With q_i = 1/(1 + 2 t s_i^2) and
// p = E exp(-t |v|^2) = prod sqrt(q_i) exp(-t m_i^2 q_i), Gaussian integrals give E v_i exp(-t |v|^2) =
// m_i q_i p, and the derivative of that by m_j is (delta_ij - 2 t m_i q_i m_j) q_j p. What
// exp(-t R^2) gives is known, h(R^2) and h'(R^2); the rule has the difference only, nothing without gusts.
template <int n>
Average<n> average_in_principal_axes(const Eigen::Matrix<double, n, 1>& mean,
                                     const Eigen::Matrix<double, n, 1>& variance,
                                     const SpeedFunction& function) {
  const Nodes t = rule().t / mean_square<n>(mean, variance);
  Eigen::Array<double, node_count, n> q;
  Nodes product = Nodes::Ones(), exponent = Nodes::Zero();
  for (int i = 0; i < n; ++i) {
    q.col(i) = 1 / (1 + 2 * variance[i] * t);
    product *= q.col(i);
    exponent += mean[i] * mean[i] * q.col(i);
  }
  const Nodes p = product.sqrt() * (-t * exponent).exp();
  Average<n> result;
  for (int i = 0; i < n; ++i) {
    const Nodes left = q.col(i) * p;
    const double force = function.value + (function.weight * (rule().reference - left)).sum() +
                         2 * variance[i] * function.moment;
    result.mean[i] = mean[i] * force;
    for (int j = 0; j <= i; ++j) {
      const double slope =
          function.twice_slope + 2 * (t * function.weight * (left * q.col(j) - rule().reference)).sum();
      result.per_velocity(i, j) = result.per_velocity(j, i) = mean[i] * mean[j] * slope;
    }
    result.per_velocity(i, i) += force;
  }
  return result;
}

AverageForce average_in_space(const GustStatistics& gusts, const auto& function_at) {
  Eigen::SelfAdjointEigenSolver<Mat3> principal;
  principal.computeDirect(gusts.covariance);
  const Mat3& axes = principal.eigenvectors();
  const Vec3 variance = principal.eigenvalues().cwiseMax(0), mean = axes.transpose() * gusts.mean;
  const double square = mean_square<3>(mean, variance);
  if (square == 0) return {};
  const Average<3> average = average_in_principal_axes<3>(mean, variance, function_at(std::sqrt(square)));
  return {axes * average.mean, axes * average.per_velocity * axes.transpose()};
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
  Eigen::Matrix<double, 3, 2> across;
  across.col(0) = axis.unitOrthogonal();
  across.col(1) = axis.cross(across.col(0));
  // Principal axes of the gusts across, in closed form.
  const Eigen::Matrix2d covariance = across.transpose() * gusts.covariance * across;
  const double half_difference = 0.5 * (covariance(0, 0) - covariance(1, 1)), shear = covariance(0, 1);
  const double angle = 0.5 * std::atan2(shear, half_difference), c = std::cos(angle), s = std::sin(angle);
  Eigen::Matrix2d turn;
  turn << c, -s, s, c;
  const Eigen::Matrix<double, 3, 2> axes = across * turn;
  const double middle = 0.5 * covariance.trace(), radius = std::hypot(half_difference, shear);
  const Eigen::Vector2d variance = Eigen::Vector2d(middle + radius, middle - radius).cwiseMax(0);
  const Eigen::Vector2d mean = axes.transpose() * gusts.mean;
  const double square = mean_square<2>(mean, variance);
  if (square == 0) return {};
  const Average<2> average = average_in_principal_axes<2>(mean, variance, without_folding(std::sqrt(square)));
  return {axes * average.mean, axes * average.per_velocity * axes.transpose()};
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
