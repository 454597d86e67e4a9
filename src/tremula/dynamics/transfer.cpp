#include "tremula/dynamics/transfer.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/types.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <utility>

#include <tbb/parallel_for.h>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace tremula {
namespace {

using Complex = std::complex<double>;
using std::numbers::pi;

// A pole further than this many bins from the middle of a bin is the same all over the bin, to a part in a
// thousand of its power.
constexpr double reach_in_bins = 8;
// Parts of the power of a bin that are not worth a draw of their own.
constexpr double negligible_share = 2e-3;
constexpr int pieces_of_a_bin = 4;

std::string brief(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

// ln(ratio), to all digits where the ratio is hardly more than 1 too: `more` is ratio - 1.
Complex log_of(Complex ratio, Complex more) {
  if (std::norm(more) > 0.25) return std::log(ratio);
  return {0.5 * std::log1p(more.real() * (2 + more.real()) + more.imag() * more.imag()),
          std::arg(1.0 + more)};
}

// The integrals over one piece of a bin that the means are made of, for a power that is linear in omega
// there. Logarithms of ratios, not differences of logarithms: a pole may lie so far from the piece, or so
// close to another pole, that nothing would be left of these.
struct Piece {
  double low, high, constant, slope;  // power = constant + slope * omega

  double width() const { return high - low; }
  // Of 1 / (i omega - s), which goes round the pole by less than half a turn.
  Complex of_plain_pole(Complex s) const {
    const Complex i(0, 1), from = i * low - s;
    return -i * log_of((i * high - s) / from, i * width() / from);
  }
  // Of power / (i omega - s).
  Complex of_pole(Complex s) const {
    const Complex i(0, 1), plain = of_plain_pole(s);
    return constant * plain - i * slope * (width() + s * plain);
  }
  // Of power / ((i omega - s) (i omega - t)^*) = -power / ((i omega - s) (i omega - v)), v = -t^*.
  Complex of_poles(Complex s, Complex t) const {
    const Complex i(0, 1), v = -std::conj(t), apart = s - v;
    const Complex far = i * high - v, near = i * low - s;
    Complex log = log_of((i * high - s) / near * ((i * low - v) / far), i * width() / near * (apart / far));
    // The way round both poles, 0 to a whole turn, is known but for rounding: that picks the branch.
    const double turn = of_plain_pole(s).real() - of_plain_pole(v).real();
    log.imag(log.imag() + 2 * pi * std::round((turn - log.imag()) / (2 * pi)));
    const Complex plain = i * log / apart;
    return (constant - i * slope * s) * plain + i * slope * of_plain_pole(v);
  }
  double of_one() const { return width() * (constant + 0.5 * slope * (high + low)); }
};

}  // namespace

void check_system(const ModalSystem& system) {
  check_equal("columns of the damping", system.damping.cols(), system.damping.rows());
  check_equal("frequencies of the system", system.omega.size(), system.damping.rows());
  if (system.stiffness.size() > 0) {
    check_equal("rows of the stiffness", system.stiffness.rows(), system.damping.rows());
    check_equal("columns of the stiffness", system.stiffness.cols(), system.damping.rows());
    if (!system.stiffness.allFinite()) throw InputError("stiffness", "one that is not finite", "numbers");
  }
  if (!system.damping.allFinite()) throw InputError("damping", "one that is not finite", "numbers");
  if (!(system.omega.allFinite() && (system.omega.array() > 0).all())) {
    throw InputError("frequencies of the system", "one that is not above 0", "numbers above 0");
  }
}

Eigen::MatrixXcd transfer_function(const ModalSystem& system, double omega) {
  const Eigen::Index m = system.omega.size();
  Eigen::MatrixXcd transfer = Eigen::MatrixXcd::Zero(m, m);
  if (system.damping.isDiagonal(0) && system.stiffness.size() == 0) {
    transfer.diagonal() = (system.omega.array().square() - omega * omega +
                           Complex(0, omega) * system.damping.diagonal().array())
                              .inverse();
  } else {
    Eigen::MatrixXcd dynamic = Complex(0, omega) * system.damping;
    dynamic.diagonal().array() += system.omega.array().square() - omega * omega;
    if (system.stiffness.size() > 0) dynamic += system.stiffness;
    transfer = dynamic.partialPivLu().inverse();
  }
  return transfer;
}

Poles find_poles(const ModalSystem& system) {
  check_system(system);
  const Eigen::Index m = system.omega.size();
  if (m == 0) return {};
  // The velocities in units of the highest frequency: numbers of one size.
  const double unit = system.omega.maxCoeff();
  for (int attempt = 0; attempt < 3; ++attempt) {
    Eigen::MatrixXd state = Eigen::MatrixXd::Zero(2 * m, 2 * m);
    state.topRightCorner(m, m).diagonal().setConstant(unit);
    state.bottomLeftCorner(m, m).diagonal() = -system.omega.cwiseAbs2() / unit;
    if (system.stiffness.size() > 0) state.bottomLeftCorner(m, m) -= system.stiffness / unit;
    state.bottomRightCorner(m, m) = -system.damping;
    // Poles that coincide have one vector between them (critical damping): a nudge parts them.
    for (Eigen::Index r = 0; r < m; ++r)
      state(m + r, m + r) *= 1 + attempt * 1e-6 * static_cast<double>(r + 1);
    const Eigen::EigenSolver<Eigen::MatrixXd> solver(state);
    if (solver.info() != Eigen::Success) continue;
    const Eigen::MatrixXcd vectors = solver.eigenvectors();
    Eigen::MatrixXcd input = Eigen::MatrixXcd::Zero(2 * m, m);
    input.bottomRows(m).diagonal().setConstant(1 / unit);
    Poles poles{solver.eigenvalues(), vectors.partialPivLu().solve(input), vectors.topRows(m)};
    const double growth = poles.pole.real().maxCoeff();
    if (growth >= 0 && growth < 1e-12 * poles.pole.cwiseAbs().maxCoeff()) {
      throw Error(
          "response: modes of " + brief(system.omega.minCoeff() / (2 * pi)) + " to " +
          brief(unit / (2 * pi)) + " Hz damped by " + brief(system.damping.diagonal().maxCoeff()) +
          " /s lie too far apart for double precision; choose less damping, less wind or stiffer wood");
    }
    if (growth >= 0) {
      throw Error(
          "response: the wind makes motion grow (by " + brief(growth) +
          " /s, where none may): choose more damping, less wind, stiffer wood or a lower lift coefficient");
    }
    const double omega = 0.37 * unit;
    const Eigen::MatrixXcd direct = transfer_function(system, omega);
    const Eigen::VectorXcd middle = (Complex(0, omega) - poles.pole.array()).inverse();
    const Eigen::MatrixXcd sum = poles.right * middle.asDiagonal() * poles.left;
    if ((sum - direct).norm() < 1e-5 * direct.norm()) return poles;
  }
  throw Error("response: the damping between the modes could not be taken apart; choose another damping");
}

BinTransfer::BinTransfer(const ModalSystem& system, const TimeAxis& axis, Transfer kind,
                         std::function<double(double omega)> power)
    : system_(system), axis_(axis), kind_(kind), power_(std::move(power)) {
  check_system(system_);
  check_at_least("samples of the loop", axis.sample_count, 1);
  if (kind_ == Transfer::bin_averaged) poles_ = find_poles(system_);
}

BinTransfer::Weights BinTransfer::weights(int bin) const {
  const double middle = 2 * pi * axis_.middle_frequency(bin), width = 2 * pi / axis_.period;
  if (kind_ == Transfer::sampled) return {Eigen::MatrixXcd::Zero(0, 1)};

  std::vector<Eigen::Index> near;
  // What is the same all over the bin is one function, 1.
  Eigen::VectorXcd far(poles_.pole.size());
  for (Eigen::Index j = 0; j < far.size(); ++j) {
    const Complex distance = Complex(0, middle) - poles_.pole[j];
    const bool is_near = std::abs(distance) < reach_in_bins * width;
    if (is_near) near.push_back(j);
    far[j] = is_near ? 0.0 : 1.0 / distance;
  }

  // The means of the products of all functions of the bin: 1 and 1/(i omega - pole) of each near pole.
  const auto n = static_cast<Eigen::Index>(near.size()) + 1;
  const double low = bin == 0 ? 0 : middle - 0.5 * width;
  const double high = bin == 0 ? 0.5 * width : 2 * bin == axis_.sample_count ? middle : middle + 0.5 * width;
  // Where there is no power at all (a wind without gusts, or far above them), any shape of it will do.
  const double in_the_middle = power_ ? power_(middle) : 0;
  const auto power = [&](double omega) {
    return in_the_middle > 0 ? power_(std::max(omega, 1e-3 * width)) / in_the_middle : 1.0;
  };
  Eigen::MatrixXcd products = Eigen::MatrixXcd::Zero(n, n);
  for (int p = 0; p < pieces_of_a_bin; ++p) {
    const double from = low + (high - low) * p / pieces_of_a_bin,
                 to = low + (high - low) * (p + 1) / pieces_of_a_bin;
    const double at_from = power(from), at_to = power(to), slope = (at_to - at_from) / (to - from);
    const Piece piece{from, to, at_from - slope * from, slope};
    products(0, 0) += piece.of_one();
    for (Eigen::Index a = 1; a < n; ++a) {
      const Complex s = poles_.pole[near[static_cast<std::size_t>(a - 1)]];
      products(a, 0) += piece.of_pole(s);
      for (Eigen::Index b = 1; b <= a; ++b) {
        products(a, b) += piece.of_poles(s, poles_.pole[near[static_cast<std::size_t>(b - 1)]]);
      }
    }
  }
  products /= high - low;
  const Eigen::VectorXd size = products.diagonal().real().cwiseSqrt();
  if (!(size.array() > 0).all() || !size.allFinite()) {
    throw Error("response: at " + brief(axis_.middle_frequency(bin)) +
                " Hz the answer of a mode is beyond what numbers hold; choose another period");
  }
  Eigen::MatrixXcd correlation(n, n);
  for (Eigen::Index a = 0; a < n; ++a) {
    for (Eigen::Index b = 0; b <= a; ++b) correlation(a, b) = products(a, b) / (size[a] * size[b]);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXcd> solver(correlation);  // reads the lower triangle
  Eigen::Index draws = 1;
  while (draws < n && solver.eigenvalues()[n - 1 - draws] > negligible_share * static_cast<double>(n))
    ++draws;
  Eigen::MatrixXcd share(n, draws);
  for (Eigen::Index i = 0; i < draws; ++i)
    share.col(i) = std::sqrt(solver.eigenvalues()[n - 1 - i]) * solver.eigenvectors().col(n - 1 - i);
  for (Eigen::Index a = 0; a < n; ++a) share.row(a) *= size[a] / share.row(a).norm();

  // The phase of an eigenvector is anyone's: it is chosen so that the functions have that of the middle.
  for (Eigen::Index i = 0; i < draws; ++i) {
    Complex along = share(0, i) / size[0];
    for (Eigen::Index a = 1; a < n; ++a) {
      const Complex value = 1.0 / (Complex(0, middle) - poles_.pole[near[static_cast<std::size_t>(a - 1)]]);
      along += share(a, i) / size[a] * std::conj(value) / std::abs(value);
    }
    if (std::abs(along) > 0) share.col(i) *= std::conj(along) / std::abs(along);
  }

  Weights weights{far * share.row(0)};
  for (Eigen::Index a = 1; a < n; ++a) weights.pole.row(near[static_cast<std::size_t>(a - 1)]) = share.row(a);
  return weights;
}

int BinTransfer::most_draws() const {
  if (kind_ == Transfer::sampled) return 1;
  std::vector<int> draws(index_of(axis_.bin_count()));
  tbb::parallel_for(0, axis_.bin_count(),
                    [&](int bin) { draws[index_of(bin)] = static_cast<int>(weights(bin).draws()); });
  return *std::max_element(draws.begin(), draws.end());
}

Eigen::VectorXcd BinTransfer::respond(int bin, const Weights& weights, const Eigen::MatrixXcd& forces) const {
  if (kind_ == Transfer::sampled) return transfer_function(system_, axis_.omega(bin)) * forces.col(0);
  Eigen::VectorXcd response =
      poles_.right * (poles_.left * forces).cwiseProduct(weights.pole).rowwise().sum();
  if (bin == 0) response = (std::sqrt(2.0) * response.real()).cast<Complex>();
  return response;
}

}  // namespace tremula
