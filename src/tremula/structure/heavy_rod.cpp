#include "tremula/structure/heavy_rod.hpp"

#include "tremula/base/check.hpp"
#include "tremula/numerics/rotation.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Dense>

namespace tremula {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// The upright chain, small angles of its pieces for coordinates.
struct LinearChain {
  VectorXd above;    // weight above the middles of pieces [N]
  MatrixXd bending;  // of EI = 1 [1/m]
  MatrixXd mass;     // [kg m^2]
  MatrixXd reach;    // of the middles of pieces, and of the tip, for angles [m]
};

LinearChain linear_chain(const HeavyRod& rod) {
  const int n = rod.pieces;
  const double h = rod.length / n;
  LinearChain chain;
  chain.above.resize(n);
  chain.bending = MatrixXd::Zero(n, n);
  chain.reach = MatrixXd::Zero(n + 1, n);
  for (int i = 0; i < n; ++i) {
    chain.above[i] = rod.gravity * (rod.mass * h * (n - i - 0.5) + rod.tip_mass);
    // The clamp holds the foot of the first piece, half a piece below its middle.
    chain.bending(i, i) += (i == 0 ? 2 : 1) / h;
    if (i > 0) {
      chain.bending(i - 1, i - 1) += 1 / h;
      chain.bending(i, i - 1) = chain.bending(i - 1, i) = -1 / h;
    }
    chain.reach.row(i).head(i).setConstant(h);
    chain.reach(i, i) = h / 2;
  }
  chain.reach.row(n).setConstant(h);
  VectorXd masses = VectorXd::Constant(n + 1, rod.mass * h);
  masses[n] = rod.tip_mass;
  chain.mass = chain.reach.transpose() * masses.asDiagonal() * chain.reach;
  return chain;
}

MatrixXd geometric(const HeavyRod& rod, const LinearChain& chain) {
  return (rod.length / rod.pieces * chain.above).asDiagonal();
}

// Forces on the middles of pieces and on the tip; the wind's power 2 for drag, 1 for what goes with a speed.
VectorXd forces_of(const HeavyRod& rod, const RodDrag& drag, double power) {
  const int n = rod.pieces;
  VectorXd forces(n + 1);
  for (int i = 0; i < n; ++i) {
    const double s = (i + 0.5) / n;
    forces[i] = drag.along * rod.length / n * std::exp(-power * drag.decay * (1 - s));
  }
  forces[n] = drag.tip;
  return forces;
}

// The first mode: its square frequency and the angles of the pieces.
struct FirstMode {
  double omega_squared;
  VectorXd angles;
};

FirstMode first_mode(const HeavyRod& rod, const LinearChain& chain) {
  const MatrixXd stiffness = rod.bending_stiffness * chain.bending - geometric(rod, chain);
  // M x = 1/omega^2 K x would want K above 0; M is, always.
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> solver(stiffness, chain.mass);
  return {solver.eigenvalues()[0], solver.eigenvectors().col(0)};
}

Eigen::Vector2d across(const Mat3& frame, const Vec3& moment) {
  return {frame.col(0).dot(moment), frame.col(1).dot(moment)};
}

// The turn that takes z to a direction and does not twist.
Mat3 turn_to(const Vec3& direction) {
  return Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), direction).matrix();
}

void check_numbers(const HeavyRod& rod) {
  check_positive("length of the rod", rod.length, " m");
  check_positive("mass of the rod", rod.mass, " kg/m");
  check_at_least("pieces of the rod", rod.pieces, 4);
  if (!(rod.tip_mass >= 0) || !std::isfinite(rod.tip_mass) || !(rod.gravity >= 0) ||
      !std::isfinite(rod.gravity))
    throw InputError("rod", "a mass or weight below 0", "finite numbers, 0 or more");
}

}  // namespace

void check_rod(const HeavyRod& rod) {
  check_numbers(rod);
  check_positive("bending stiffness of the rod", rod.bending_stiffness, " N m^2");
  if (!(first_mode(rod, linear_chain(rod)).omega_squared > 0)) {
    throw InputError("bending stiffness of the rod", number_text(rod.bending_stiffness) + " N m^2",
                     "one that carries its weight");
  }
}

double stiffness_of_frequency(const HeavyRod& rod, double frequency) {
  check_numbers(rod);
  check_positive("frequency of the rod", frequency, " Hz");
  const LinearChain chain = linear_chain(rod);
  const double omega = 2 * std::numbers::pi * frequency;
  // (omega^2 M + G) x = EI K x: the largest EI is that of the first mode.
  const MatrixXd loads = omega * omega * chain.mass + geometric(rod, chain);
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> solver(loads, chain.bending,
                                                                  Eigen::EigenvaluesOnly);
  return solver.eigenvalues()[rod.pieces - 1];
}

double first_frequency(const HeavyRod& rod) {
  check_rod(rod);
  return std::sqrt(first_mode(rod, linear_chain(rod)).omega_squared) / (2 * std::numbers::pi);
}

double linear_tip_angle(const HeavyRod& rod, const RodDrag& drag) {
  check_rod(rod);
  const LinearChain chain = linear_chain(rod);
  const MatrixXd stiffness = rod.bending_stiffness * chain.bending - geometric(rod, chain);
  const VectorXd angles = stiffness.ldlt().solve(chain.reach.transpose() * forces_of(rod, drag, 2));
  return angles[rod.pieces - 1];
}

double damping_rate(const HeavyRod& rod, const RodDrag& per_velocity) {
  check_rod(rod);
  const LinearChain chain = linear_chain(rod);
  const FirstMode mode = first_mode(rod, chain);
  const VectorXd places = chain.reach * mode.angles;
  const double mass = mode.angles.dot(chain.mass * mode.angles);
  return forces_of(rod, per_velocity, 1).dot(places.cwiseAbs2()) / mass;
}

RodBender::RodBender(const HeavyRod& rod, const Eigen::Matrix3Xd& rest, double tolerance)
    : rod_(rod), tolerance_(tolerance), directions_(rest) {
  check_rod(rod);
  check_equal("pieces of the rod at rest", rest.cols(), rod.pieces);
  const auto n = index_of(rod.pieces);
  frames_.resize(n);
  rest_turns_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 direction = rest.col(static_cast<Eigen::Index>(i));
    if (!direction.allFinite() || std::abs(direction.norm() - 1) > 1e-6)
      throw InputError("rod at rest", "a direction that is none", "unit vectors");
    // Carried on from piece to piece, so that the curvature at rest has no twist either.
    frames_[i] = i == 0 ? turn_to(direction)
                        : Mat3(Eigen::Quaterniond::FromTwoVectors(frames_[i - 1].col(2), direction).matrix() *
                               frames_[i - 1]);
    rest_turns_[i] = i == 0 ? frames_[0] : Mat3(frames_[i - 1].transpose() * frames_[i]);
  }
  strains_.assign(n, Eigen::Vector2d::Zero());
  rest_.resize(n);
  moments_.resize(n);
  find_moments(VectorXd::Zero(rod.pieces + 1), Vec3::UnitX());
  for (std::size_t i = 0; i < n; ++i) rest_[i] = across(frames_[i], moments_[i]);
}

void RodBender::find_moments(const VectorXd& drags, const Vec3& heading) {
  const int n = rod_.pieces;
  const double h = rod_.length / n;
  const auto force_on = [&](double size, double mass, const Vec3& direction) -> Vec3 {
    const Vec3 across_rod = heading - heading.dot(direction) * direction;
    return size * across_rod.norm() * across_rod - mass * rod_.gravity * Vec3::UnitZ();
  };
  Vec3 force = force_on(drags[n], rod_.tip_mass, directions_.col(n - 1)), moment = Vec3::Zero();
  for (int i = n - 1; i >= 0; --i) {
    const Vec3 direction = directions_.col(i), own = force_on(drags[i], rod_.mass * h, direction);
    moment += (h * direction).cross(force) + (0.5 * h * direction).cross(own);
    force += own;
    moments_[index_of(i)] = moment;
  }
}

void RodBender::stand() {
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    const Vec3 turn(strains_[i].x(), strains_[i].y(), 0);
    frames_[i] = (i == 0 ? rest_turns_[0] : Mat3(frames_[i - 1] * rest_turns_[i])) * rotation_matrix(turn);
    directions_.col(static_cast<Eigen::Index>(i)) = frames_[i].col(2);
  }
}

const Eigen::Matrix3Xd& RodBender::bend(const RodDrag& drag, const Vec3& heading) {
  constexpr int most_steps = 4000;
  const double h = rod_.length / rod_.pieces;
  const VectorXd drags = forces_of(rod_, drag, 2);
  std::vector<Eigen::Vector2d> step(strains_.size(), Eigen::Vector2d::Zero());
  // As through syrup: steps get shorter where one turns off the way of the one before, and longer again. A
  // rod that leans against the wind may have to go over to the other side.
  double share = 0.5;
  for (int count = 0; count < most_steps; ++count) {
    find_moments(drags, heading);
    double off = 0, onwards = 0, before = 0, now = 0;
    for (std::size_t i = 0; i < strains_.size(); ++i) {
      const double compliance = (i == 0 ? 0.5 : 1) * h / rod_.bending_stiffness;
      const Eigen::Vector2d wanted = compliance * (across(frames_[i], moments_[i]) - rest_[i]);
      const Eigen::Vector2d way = wanted - strains_[i];
      off = std::max(off, way.norm());
      onwards += way.dot(step[i]);
      before += step[i].squaredNorm();
      now += way.squaredNorm();
      step[i] = way;
    }
    at_rest_ = off < tolerance_;
    if (at_rest_) break;
    share = onwards < 0.6 * std::sqrt(before * now) ? 0.6 * share : std::min(1.08 * share, 1.0);
    const double most = 0.3 / off;  // a turn between two pieces that is not lost sight of [rad]
    for (std::size_t i = 0; i < strains_.size(); ++i) strains_[i] += std::min(share, most) * step[i];
    stand();
  }
  return directions_;
}

Eigen::Matrix3Xd bend_rod(const HeavyRod& rod, const Eigen::Matrix3Xd& rest, const RodDrag& drag,
                          const Vec3& heading) {
  RodBender bender(rod, rest);
  // Load by load, so that no step goes far.
  constexpr int loads = 8;
  for (int i = 1; i < loads; ++i) {
    const double share = static_cast<double>(i) / loads;
    bender.bend({share * drag.along, share * drag.tip, drag.decay}, heading);
  }
  const Eigen::Matrix3Xd bent = bender.bend(drag, heading);
  if (!bender.is_at_rest()) throw Error("a rod does not come to rest in the wind");
  return bent;
}

}  // namespace tremula
