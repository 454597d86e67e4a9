#include "tremula/dynamics/oscillators.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/error.hpp"
#include "tremula/base/types.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>

#include <tbb/parallel_for.h>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SparseLU>
#include <unsupported/Eigen/MatrixFunctions>

namespace tremula {
namespace {

using Sparse = Eigen::SparseMatrix<double>;
using Eigen::Matrix2d;

constexpr Eigen::Index most_full = 1000;  // oscillators whose eigenvalues and exponential are found at once

std::string shown(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

// exp(z), phi_1 = (exp(z) - 1)/z and phi_2 = (phi_1 - 1)/z.
struct Exponentials {
  double zeroth, first, second;
};
Exponentials exponentials(double z) {
  if (std::abs(z) > 0.5) {
    const double first = std::expm1(z) / z;
    return {std::exp(z), first, (first - 1) / z};
  }
  double first = 0, second = 0, term = 1;  // z^k/(k + 1)!
  for (int k = 0; k < 20; ++k) {
    first += term;
    second += term / (k + 2);
    term *= z / (k + 2);
  }
  return {std::exp(z), first, second};
}

// The same functions of the step times the matrix of one oscillator.
struct StepFunctions {
  Matrix2d zeroth, first, second;
};

StepFunctions by_series(const Matrix2d& z) {
  StepFunctions f{Matrix2d::Identity(), Matrix2d::Zero(), Matrix2d::Zero()};
  Matrix2d term = Matrix2d::Identity();  // z^k/(k + 1)!
  for (int k = 0; k < 32; ++k) {
    f.first += term;
    f.second += term / (k + 2);
    term = term * z / (k + 2);
  }
  f.zeroth += z * f.first;
  return f;
}

// Two real poles far from each other (the slower may be hardly any).
StepFunctions by_poles(const Matrix2d& z, double slow, double fast) {
  const Matrix2d to_slow = (z - fast * Matrix2d::Identity()) / (slow - fast);
  const Matrix2d to_fast = Matrix2d::Identity() - to_slow;
  const Exponentials s = exponentials(slow), f = exponentials(fast);
  return {s.zeroth * to_slow + f.zeroth * to_fast, s.first * to_slow + f.first * to_fast,
          s.second * to_slow + f.second * to_fast};
}

// What remains: a pair of poles that are not small. c and s are cosine and sine, or their hyperbolic kin,
// over the square root of +-difference.
StepFunctions by_pair(const Matrix2d& z, double mean, double difference) {
  const double root = std::sqrt(std::abs(difference));
  const double cosine = difference < 0 ? std::cos(root) : std::cosh(root);
  const double sine =
      root < 1e-4 ? 1 + difference / 6 : (difference < 0 ? std::sin(root) : std::sinh(root)) / root;
  StepFunctions f;
  f.zeroth = std::exp(mean) * (cosine * Matrix2d::Identity() + sine * (z - mean * Matrix2d::Identity()));
  const Matrix2d inverse = z.inverse();
  f.first = inverse * (f.zeroth - Matrix2d::Identity());
  f.second = inverse * (f.first - Matrix2d::Identity());
  return f;
}

// x' = A x of some oscillators, in ascending order, and of each displacement and velocity over `scale` [1/s]:
// in such units what swings is a rotation, whose exponential takes the fewest squarings.
struct System {
  Eigen::MatrixXd matrix;  // (2k x 2k)
  Eigen::VectorXd scale;   // (k)
};

System system_of(const OscillatorNetwork& network, const std::vector<Eigen::Index>& chosen) {
  const auto count = static_cast<Eigen::Index>(chosen.size());
  System system{Eigen::MatrixXd::Zero(2 * count, 2 * count), Eigen::VectorXd::Ones(count)};
  for (Eigen::Index k = 0; k < count; ++k) {
    const Eigen::Index own = chosen[index_of(k)];
    const double square = std::abs(network.coupling.coeff(own, own)) / network.mass[own];
    if (square > 0) system.scale[k] = std::sqrt(square);
  }
  for (Eigen::Index k = 0; k < count; ++k) {
    system.matrix(2 * k, 2 * k + 1) = system.scale[k];
    const Eigen::Index column = chosen[index_of(k)];
    const auto add = [&](const Sparse& matrix, Eigen::Index offset, double unit) {
      for (Sparse::InnerIterator entry(matrix, column); entry; ++entry) {
        const auto found = std::ranges::lower_bound(chosen, entry.row());
        if (found == chosen.end() || *found != entry.row()) continue;
        const Eigen::Index row = found - chosen.begin();
        system.matrix(2 * row + 1, 2 * k + offset) -=
            entry.value() * unit / (network.mass[entry.row()] * system.scale[row]);
      }
    };
    add(network.coupling, 0, 1);
    add(network.damping, 1, system.scale[k]);
  }
  return system;
}

// What of (X, X') of `from` before adds to (X, X') of `onto` after, in their own units.
Matrix2d transition_of(const Eigen::MatrixXd& exponential, const System& system, Eigen::Index onto,
                       Eigen::Index from) {
  Matrix2d pair = exponential.block<2, 2>(2 * onto, 2 * from);
  pair.row(1) *= system.scale[onto];
  pair.col(1) /= system.scale[from];
  return pair;
}

std::vector<Eigen::Index> everyone(Eigen::Index count) {
  std::vector<Eigen::Index> all(index_of(count));
  for (Eigen::Index k = 0; k < count; ++k) all[index_of(k)] = k;
  return all;
}

bool is_upper(const Sparse& matrix) {
  for (Eigen::Index column = 0; column < matrix.outerSize(); ++column) {
    for (Sparse::InnerIterator entry(matrix, column); entry; ++entry) {
      if (entry.row() > column && entry.value() != 0) return false;
    }
  }
  return true;
}

[[noreturn]] void refuse_growth(const std::string& who, double rate, double frequency) {
  char found[160];
  std::snprintf(found, sizeof found, "%s grows by %.4g 1/s, at %.4g Hz", who.c_str(), rate, frequency);
  throw InputError("oscillators", found,
                   "a network whose motions stay or die: more damping, or couplings that hold");
}

void check_one_way(const OscillatorNetwork& network) {
  for (Eigen::Index k = 0; k < network.size(); ++k) {
    const double stiffness = network.coupling.coeff(k, k), damping = network.damping.coeff(k, k);
    const std::string who = "oscillator " + std::to_string(k);
    if (!(stiffness > 0))
      throw InputError(who, "nothing holds it (alpha is " + shown(stiffness) + ")", "a stiffness above 0");
    if (damping < 0) {
      refuse_growth("the motion of " + who, -damping / (2 * network.mass[k]),
                    std::sqrt(stiffness / network.mass[k]) / (2 * EIGEN_PI));
    }
  }
}

void check_full(const OscillatorNetwork& network) {
  if (network.size() > most_full) {
    throw InputError("oscillators", std::to_string(network.size()) + " that act both ways",
                     "at most " + std::to_string(most_full) + ", or each acting only on those before it");
  }
  const Eigen::VectorXcd poles = system_of(network, everyone(network.size())).matrix.eigenvalues();
  const double largest = poles.cwiseAbs().maxCoeff();
  for (const std::complex<double>& pole : poles) {
    if (pole.real() > 1e-9 * largest)
      refuse_growth("a motion", pole.real(), std::abs(pole.imag()) / (2 * EIGEN_PI));
    if (std::abs(pole) < 1e-9 * largest)
      throw InputError("oscillators", "a motion that nothing holds", "couplings that hold every oscillator");
  }
}

void check_sizes(const OscillatorNetwork& network) {
  check_at_least("oscillators", network.size(), 1);
  for (const Sparse* matrix : {&network.damping, &network.coupling}) {
    check_equal("rows of a matrix of the oscillators", matrix->rows(), network.size());
    check_equal("columns of a matrix of the oscillators", matrix->cols(), network.size());
    for (Eigen::Index k = 0; k < matrix->outerSize(); ++k) {
      for (Sparse::InnerIterator entry(*matrix, k); entry; ++entry) {
        if (!std::isfinite(entry.value()))
          throw InputError("oscillators", "an entry that is no number", "finite numbers");
      }
    }
  }
  for (const double mass : network.mass) check_positive("mass of an oscillator", mass, " kg");
}

}  // namespace

OscillatorState at_rest(const OscillatorNetwork& network) {
  return {Eigen::VectorXd::Zero(network.size()), Eigen::VectorXd::Zero(network.size())};
}

// The state is linear in what it was and in both forces: x = phi_0 x + h (phi_1 - phi_2) b f_before
// + h phi_2 b f_after, all phi of the step times the matrix of the oscillator, b = (0, 1).
OscillatorStep oscillator_step(double omega, double rate, double step) {
  check_positive("omega of an oscillator", omega, " rad/s");
  check_positive("step in time", step, " s");
  if (!(rate >= 0 && std::isfinite(rate)))
    throw InputError("damping of an oscillator", shown(rate) + " 1/s", "0 or more");
  const double angle = omega * step, mean = -0.5 * rate * step;
  Matrix2d z;  // of the displacement and the velocity times the step
  z << 0, 1, -angle * angle, 2 * mean;
  const double difference = mean * mean - angle * angle;
  const double fast = difference > 0 ? mean - std::sqrt(difference) : 0;  // the slow one is angle^2/fast
  StepFunctions f;
  if (std::max(angle, rate * step) < 2) {
    f = by_series(z);
  } else if (difference > 0 && angle * angle / -fast < 0.5) {
    f = by_poles(z, angle * angle / fast, fast);
  } else if (difference > 0) {
    // Where both are large exp(mean) cosh(root) is nothing times infinity: keep them as exponentials.
    f = difference > 1 ? by_poles(z, angle * angle / fast, fast) : by_pair(z, mean, difference);
  } else {
    f = by_pair(z, mean, difference);
  }
  const Eigen::Vector2d scale(1, 1 / step);
  const Eigen::Vector2d after = f.second.col(1), before = f.first.col(1) - after;
  OscillatorStep result;
  result.state = scale.asDiagonal() * f.zeroth * scale.cwiseInverse().asDiagonal();
  result.force << step * step * before[0], step * step * after[0], step * before[1], step * after[1];
  return result;
}

bool is_one_way(const OscillatorNetwork& network) {
  return is_upper(network.coupling) && is_upper(network.damping);
}

void check_network(const OscillatorNetwork& network) {
  check_sizes(network);
  if (is_one_way(network)) {
    check_one_way(network);
  } else {
    check_full(network);
  }
}

OscillatorIntegrator::OscillatorIntegrator(const OscillatorNetwork& network, double step)
    : step_(step),
      one_way_(is_one_way(network)),
      rest_(network.coupling.pruned()),
      damping_(network.damping.pruned()) {
  rest_.makeCompressed();
  damping_.makeCompressed();
  check_positive("step in time", step, " s");
  check_network(network);
  if (one_way_) {
    add_one_way(network);
  } else {
    inverse_ = Eigen::MatrixXd(rest_).inverse();
    add_full(network);
  }
}

void OscillatorIntegrator::add_one_way(const OscillatorNetwork& network) {
  const Eigen::Index count = network.size();
  // Whom each acts on, directly or through others; itself last.
  std::vector<std::vector<Eigen::Index>> onto(index_of(count));
  for (Eigen::Index k = 0; k < count; ++k) {
    std::vector<Eigen::Index>& all = onto[index_of(k)];
    for (const Sparse* matrix : {&network.coupling, &network.damping}) {
      for (Sparse::InnerIterator entry(*matrix, k); entry; ++entry) {
        if (entry.row() == k || entry.value() == 0) continue;
        const std::vector<Eigen::Index>& through = onto[index_of(entry.row())];
        all.insert(all.end(), through.begin(), through.end());
      }
    }
    all.push_back(k);
    std::ranges::sort(all);
    all.erase(std::unique(all.begin(), all.end()), all.end());
  }
  first_.assign(1, 0);
  for (const auto& all : onto) first_.push_back(first_.back() + all.size());
  onto_.resize(first_.back());
  transitions_.resize(first_.back());
  tbb::parallel_for(Eigen::Index{0}, count, [&](Eigen::Index k) {
    const std::vector<Eigen::Index>& all = onto[index_of(k)];
    const std::size_t first = first_[index_of(k)];
    for (std::size_t i = 0; i < all.size(); ++i) onto_[first + i] = static_cast<int>(all[i]);
    if (all.size() == 1) {
      const double mass = network.mass[k];
      transitions_[first] = oscillator_step(std::sqrt(network.coupling.coeff(k, k) / mass),
                                            network.damping.coeff(k, k) / mass, step_)
                                .state;
      return;
    }
    const System system = system_of(network, all);
    const Eigen::MatrixXd exponential = (step_ * system.matrix).exp();
    const auto last = static_cast<Eigen::Index>(all.size()) - 1;
    for (Eigen::Index i = 0; i <= last; ++i)
      transitions_[first + index_of(i)] = transition_of(exponential, system, i, last);
  });
}

void OscillatorIntegrator::add_full(const OscillatorNetwork& network) {
  const Eigen::Index count = network.size();
  const System system = system_of(network, everyone(count));
  const Eigen::MatrixXd exponential = (step_ * system.matrix).exp();
  first_.assign(1, 0);
  for (Eigen::Index from = 0; from < count; ++from) {
    for (Eigen::Index onto = 0; onto < count; ++onto) {
      onto_.push_back(static_cast<int>(onto));
      transitions_.push_back(transition_of(exponential, system, onto, from));
    }
    first_.push_back(onto_.size());
  }
}

// A force f + t f' has the particular solution place + t rate: rate = alpha^-1 f', place = alpha^-1 (f -
// gamma rate). One-way both come from one walk over alpha, from the last column to the first.
OscillatorIntegrator::Particular OscillatorIntegrator::particular(const Eigen::VectorXd& before,
                                                                  const Eigen::VectorXd& after) const {
  Particular p{before, (after - before) / step_};
  if (!one_way_) {
    p.rate = inverse_ * p.rate;
    p.place = inverse_ * (before - damping_ * p.rate);
    return p;
  }
  double *const place = p.place.data(), *const rate = p.rate.data();
  for (Eigen::Index k = size() - 1; k >= 0; --k) {
    const auto diagonal = rest_.outerIndexPtr()[k + 1] - 1;  // rows ascend, and none is beyond it
    const double stiffness = rest_.valuePtr()[diagonal];
    const double own_rate = rate[k] /= stiffness;
    for (auto e = damping_.outerIndexPtr()[k]; e < damping_.outerIndexPtr()[k + 1]; ++e)
      place[damping_.innerIndexPtr()[e]] -= damping_.valuePtr()[e] * own_rate;
    const double own_place = place[k] /= stiffness;
    for (auto e = rest_.outerIndexPtr()[k]; e < diagonal; ++e) {
      const auto row = rest_.innerIndexPtr()[e];
      const double value = rest_.valuePtr()[e];
      rate[row] -= value * own_rate;
      place[row] -= value * own_place;
    }
  }
  return p;
}

// What differs from the particular solution moves freely.
void OscillatorIntegrator::advance(OscillatorState& state, const Eigen::VectorXd& force_before,
                                   const Eigen::VectorXd& force_after) const {
  check_equal("displacements of the oscillators", state.displacement.size(), size());
  check_equal("velocities of the oscillators", state.velocity.size(), size());
  check_equal("forces on the oscillators", force_before.size(), size());
  check_equal("forces on the oscillators", force_after.size(), size());
  const Particular p = particular(force_before, force_after);
  Eigen::Matrix2Xd free = Eigen::Matrix2Xd::Zero(2, size());  // (X, X') after
  double* const onto_all = free.data();
  for (Eigen::Index from = 0; from < size(); ++from) {
    const double x = state.displacement[from] - p.place[from], v = state.velocity[from] - p.rate[from];
    const std::size_t end = first_[index_of(from) + 1];
    for (std::size_t i = first_[index_of(from)]; i < end; ++i) {
      const double* const m = transitions_[i].data();
      double* const onto = onto_all + 2 * static_cast<std::ptrdiff_t>(onto_[i]);
      onto[0] += m[0] * x + m[2] * v;
      onto[1] += m[1] * x + m[3] * v;
    }
  }
  state.displacement = free.row(0).transpose() + p.place + step_ * p.rate;
  state.velocity = free.row(1).transpose() + p.rate;
}

OscillatorState OscillatorIntegrator::repeating(const OscillatorState& push) const {
  check_equal("displacements of the push", push.displacement.size(), size());
  check_equal("velocities of the push", push.velocity.size(), size());
  const auto refuse_if = [](bool never_dies) {
    if (never_dies)
      throw InputError("oscillators", "a motion that never dies", "damping above 0, for a loop to repeat");
  };
  constexpr double forgets = 1e-12;  // what the determinant of an undamped swing misses 0 by, in rounding
  OscillatorState result = push;
  if (!one_way_) {
    Eigen::MatrixXd left = Eigen::MatrixXd::Identity(2 * size(), 2 * size());
    Eigen::VectorXd right(2 * size());
    for (Eigen::Index from = 0; from < size(); ++from) {
      right.segment<2>(2 * from) << push.displacement[from], push.velocity[from];
      for (std::size_t p = first_[index_of(from)]; p < first_[index_of(from) + 1]; ++p)
        left.block<2, 2>(Eigen::Index{2} * onto_[p], 2 * from) -= transitions_[p];
    }
    const Eigen::PartialPivLU<Eigen::MatrixXd> factors(left);
    refuse_if(factors.rcond() < forgets);
    const Eigen::VectorXd state = factors.solve(right);
    for (Eigen::Index k = 0; k < size(); ++k) {
      result.displacement[k] = state[2 * k];
      result.velocity[k] = state[2 * k + 1];
    }
    return result;
  }
  for (Eigen::Index from = size() - 1; from >= 0; --from) {  // an oscillator's own pair is its last
    const std::size_t own = first_[index_of(from) + 1] - 1;
    const Matrix2d left = Matrix2d::Identity() - transitions_[own];
    refuse_if(std::abs(left.determinant()) < forgets);
    const Eigen::Vector2d state =
        left.inverse() * Eigen::Vector2d(result.displacement[from], result.velocity[from]);
    result.displacement[from] = state[0];
    result.velocity[from] = state[1];
    for (std::size_t p = first_[index_of(from)]; p < own; ++p) {
      const Eigen::Vector2d on = transitions_[p] * state;
      result.displacement[onto_[p]] += on[0];
      result.velocity[onto_[p]] += on[1];
    }
  }
  return result;
}

Eigen::MatrixXd respond_in_time(const OscillatorNetwork& network, double step, const Eigen::MatrixXd& forces,
                                const std::optional<OscillatorState>& start) {
  check_at_least("instants of the forces", forces.cols(), 1);
  check_equal("rows of the forces on the oscillators", forces.rows(), network.size());
  const OscillatorIntegrator integrator(network, step);
  OscillatorState state = start.value_or(at_rest(network));
  Eigen::MatrixXd displacements(network.size(), forces.cols());
  displacements.col(0) = state.displacement;
  for (Eigen::Index p = 1; p < forces.cols(); ++p) {
    integrator.advance(state, forces.col(p - 1), forces.col(p));
    displacements.col(p) = state.displacement;
  }
  return displacements;
}

Eigen::MatrixXd repeat_in_time(const OscillatorNetwork& network, double period,
                               const Eigen::MatrixXd& forces) {
  check_at_least("instants of the forces", forces.cols(), 1);
  check_equal("rows of the forces on the oscillators", forces.rows(), network.size());
  check_positive("period of the forces", period, " s");
  const Eigen::Index count = forces.cols();
  const OscillatorIntegrator integrator(network, period / static_cast<double>(count));
  const auto run = [&](OscillatorState& state, Eigen::MatrixXd* displacements) {
    for (Eigen::Index p = 0; p < count; ++p) {
      if (displacements) displacements->col(p) = state.displacement;
      integrator.advance(state, forces.col(p), forces.col((p + 1) % count));
    }
  };
  OscillatorState state = at_rest(network);
  run(state, nullptr);
  state = OscillatorIntegrator(network, period).repeating(state);
  Eigen::MatrixXd displacements(network.size(), count);
  run(state, &displacements);
  return displacements;
}

Eigen::MatrixXcd respond_in_frequency(const OscillatorNetwork& network, const TimeAxis& axis,
                                      const Eigen::MatrixXcd& forces) {
  using Complex = Eigen::SparseMatrix<std::complex<double>>;
  check_network(network);
  check_equal("rows of the forces", forces.rows(), axis.bin_count());
  check_equal("columns of the forces", forces.cols(), network.size());
  const bool one_way = is_one_way(network);
  Sparse mass(network.size(), network.size());
  mass.setIdentity();
  mass.diagonal() = network.mass;
  Eigen::MatrixXcd displacements(forces.rows(), forces.cols());
  tbb::parallel_for(0, axis.bin_count(), [&](int bin) {
    const double omega = axis.omega(bin);
    const Sparse in_phase = network.coupling - omega * omega * mass;
    const Complex dynamic = in_phase.cast<std::complex<double>>() +
                            (std::complex<double>(0, omega) * network.damping.cast<std::complex<double>>());
    const Eigen::VectorXcd force = forces.row(bin).transpose();
    if (one_way) {
      displacements.row(bin) = dynamic.triangularView<Eigen::Upper>().solve(force).transpose();
    } else {
      displacements.row(bin) = Eigen::MatrixXcd(dynamic).partialPivLu().solve(force).transpose();
    }
  });
  if (!displacements.allFinite())
    throw InputError("oscillators", "a resonance without damping on a frequency of the loop",
                     "damping above 0");
  return displacements;
}

}  // namespace tremula
