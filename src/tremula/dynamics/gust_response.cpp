#include "tremula/dynamics/gust_response.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/number_text.hpp"
#include "tremula/dynamics/damping.hpp"
#include "tremula/dynamics/drag_in_time.hpp"
#include "tremula/dynamics/oscillators.hpp"
#include "tremula/numerics/fft.hpp"
#include "tremula/numerics/rotation.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <tbb/parallel_for.h>
#include <Eigen/LU>

namespace tremula {
namespace {

// What the drag on all sites makes of a state of the coordinates.
class DragOnMotion {
 public:
  DragOnMotion(const Lean& lean, Eigen::Ref<const Eigen::MatrixXd> moving, const ChangingWind& wind,
               const TimeAxis& axis, const GustResponseOptions& options)
      : lean_(lean), wind_(wind), axis_(axis), options_(options), blocks_(cut_between_points(lean.sites)) {
    for (const auto& [first, last] : blocks_) {
      motion_.push_back(lean.sites.motion(first, last, moving));
      if (options.turning) turning_.push_back(lean.sites.turning(first, last, moving));
    }
  }

  // Forces on the coordinates (c), beyond the mean loads of the lean [N/sqrt(kg)].
  Eigen::VectorXd operator()(double time, const Eigen::VectorXd& displacement,
                             const Eigen::VectorXd& velocity) const {
    const Mat3 change = wind_.change(time);
    const double at = std::clamp(time / axis_.period * axis_.sample_count, 0.0, axis_.sample_count - 1.0);
    const auto sample = static_cast<Eigen::Index>(at);
    const auto next = std::min<Eigen::Index>(sample + 1, axis_.sample_count - 1);
    const double part = at - std::floor(at);
    const auto wind_at = [&](Eigen::Index point) -> Vec3 {
      Vec3 wind = wind_.mean.col(point);
      if (wind_.gusts.size() > 0) {
        wind += ((1 - part) * wind_.gusts.row(sample).segment<3>(3 * point) +
                 part * wind_.gusts.row(next).segment<3>(3 * point))
                    .transpose();
      }
      return change * wind;
    };
    std::vector<Eigen::VectorXd> parts(blocks_.size());
    tbb::parallel_for(std::size_t{0}, blocks_.size(), [&](std::size_t b) {
      const auto [first, last] = blocks_[b];
      const Eigen::VectorXd speeds = motion_[b] * velocity;
      const Eigen::VectorXd turns = options_.turning ? turning_[b] * displacement : Eigen::VectorXd();
      Eigen::VectorXd forces(speeds.size());
      for (std::size_t s = first; s < last; ++s) {
        const auto row = 3 * static_cast<Eigen::Index>(s - first);
        const SiteLoad& load = lean_.loads.sites[s];
        Site site = lean_.sites.sites[s];
        if (options_.turning) site.axis = rotation_matrix(Vec3(turns.segment<3>(row))) * site.axis;
        Vec3 met = load.gust_share * wind_at(site.point);
        if (options_.damps) met -= speeds.segment<3>(row);
        forces.segment<3>(row) = drag_on(site, met, options_.loads) - load.mean;
      }
      parts[b].noalias() = motion_[b].transpose() * forces;
    });
    // In the order of the blocks, whichever thread was first.
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(displacement.size());
    for (const Eigen::VectorXd& of_block : parts) sum += of_block;
    return sum;
  }

 private:
  const Lean& lean_;
  const ChangingWind& wind_;
  TimeAxis axis_;
  GustResponseOptions options_;
  std::vector<SiteBlock> blocks_;
  std::vector<Eigen::MatrixXd> motion_, turning_;  // of every block (3 sites x c)
};

// omega^2 q = f(q) in the wind of the first instant, by Newton's method with differences.
Eigen::VectorXd standing(const DragOnMotion& drag, const Eigen::VectorXd& omega) {
  constexpr int most_rounds = 30;
  constexpr double settled = 1e-10;
  const Eigen::Index count = omega.size();
  const Eigen::VectorXd still = Eigen::VectorXd::Zero(count), stiffness = omega.cwiseAbs2();
  Eigen::VectorXd displacement = still;
  for (int round = 0; round < most_rounds; ++round) {
    const Eigen::VectorXd force = drag(0, displacement, still);
    const Eigen::VectorXd missing = force - stiffness.cwiseProduct(displacement);
    const double size = std::max(missing.cwiseQuotient(stiffness).norm(), displacement.norm());
    if (size == 0) return displacement;
    Eigen::MatrixXd tangent = stiffness.asDiagonal();
    const double little = 1e-5 * size;
    for (Eigen::Index c = 0; c < count; ++c) {
      Eigen::VectorXd aside = displacement;
      aside[c] += little;
      tangent.col(c) -= (drag(0, aside, still) - force) / little;
    }
    const Eigen::VectorXd step = tangent.partialPivLu().solve(missing);
    if (!step.allFinite()) break;
    displacement += step;
    if (step.norm() < settled * displacement.norm()) return displacement;
  }
  throw Error("gusts: the wind of the first instant finds no equilibrium; less wind, or start from rest");
}

// The fastest there is: an oscillation, or what the strongest wind of the script damps by [1/s].
double fastest_rate(const Lean& lean, Eigen::Ref<const Eigen::MatrixXd> moving, const Eigen::VectorXd& omega,
                    const ChangingWind& wind, const TimeAxis& axis, bool damps) {
  double fastest = omega.maxCoeff();
  if (!damps) return fastest;
  double strongest = 1;  // of the wind that the loads of the lean are for
  for (int p = 0; p < axis.sample_count; ++p)
    strongest = std::max(strongest, wind.change(axis.period * p / axis.sample_count).norm() / std::sqrt(3.0));
  const Eigen::MatrixXd by_wind = aerodynamic_damping(lean.sites, lean.loads, moving);
  return std::max(fastest, strongest * by_wind.diagonal().maxCoeff());
}

}  // namespace

Lean lean_at_rest(const Structure& structure, const WindAt& wind, const LoadOptions& loads,
                  const LeanOptions& options) {
  const WindAt calm = [](Eigen::Index, const Vec3&) { return GustStatistics{}; };
  Lean lean = find_lean(structure, calm, loads, options);
  LeanOptions small = options;
  small.rotations = Rotations::small;
  lean.loads = find_lean(structure, wind, loads, small).loads;
  for (SiteLoad& load : lean.loads.sites) load.mean.setZero();
  return lean;
}

ChangingWind changing_wind(const PointWind& wind, const TimeAxis& axis,
                           std::function<Mat3(double time)> change) {
  ChangingWind result{.mean = wind.mean, .change = std::move(change)};
  Eigen::MatrixXcd spectra(axis.bin_count(), 3 * wind.mean.cols());
  spectra.row(0).setZero();
  tbb::parallel_for(1, axis.bin_count(),
                    [&](int bin) { spectra.row(bin) = wind.velocity(bin, 0).reshaped().transpose(); });
  if (!spectra.isZero(0)) result.gusts = samples_from_half_spectra(spectra, axis.sample_count);
  return result;
}

Eigen::MatrixXd respond_to_gusts(const Lean& lean, Eigen::Ref<const Eigen::MatrixXd> moving,
                                 const Eigen::VectorXd& omega, const Eigen::VectorXd& damping,
                                 const ChangingWind& wind, const TimeAxis& axis,
                                 const GustResponseOptions& options,
                                 const std::function<void(double done)>& progress) {
  check_loads(options.loads);
  check_loads(lean.sites, lean.loads);
  if (options.loads.model == LoadModel::paper)
    throw InputError("gusts", "loads as printed, which have no mean wind", "other loads");
  check_equal("points of the wind", wind.mean.cols(), lean.sites.point_count());
  check_equal("frequencies of the shapes", omega.size(), moving.cols());
  check_equal("damping of the shapes", damping.size(), moving.cols());
  check_at_least("samples", axis.sample_count, 1);
  if (!(options.step_angle > 0))
    throw InputError("angle of a step", number_text(options.step_angle), "above 0");
  const DragOnMotion drag(lean, moving, wind, axis, options);
  const double sample = axis.period / axis.sample_count;
  const double rate = fastest_rate(lean, moving, omega, wind, axis, options.damps);
  const int steps = std::clamp(static_cast<int>(std::ceil(sample * rate / options.step_angle)), 1, 1000);
  const double step = sample / steps;
  std::vector<OscillatorStep> advance;
  for (Eigen::Index c = 0; c < omega.size(); ++c)
    advance.push_back(oscillator_step(omega[c], damping[c], step));

  Eigen::VectorXd displacement = Eigen::VectorXd::Zero(omega.size()), velocity = displacement;
  if (!options.from_rest) displacement = standing(drag, omega);
  Eigen::MatrixXd coordinates(axis.sample_count, omega.size());
  coordinates.row(0) = displacement.transpose();
  Eigen::VectorXd force = drag(0, displacement, velocity), last = force, next_displacement = displacement,
                  next_velocity = velocity;
  const auto move = [&](const Eigen::VectorXd& after) {
    for (Eigen::Index c = 0; c < omega.size(); ++c) {
      const OscillatorStep& one = advance[index_of(c)];
      const Eigen::Vector2d moved = one.state * Eigen::Vector2d(displacement[c], velocity[c]) +
                                    one.force * Eigen::Vector2d(force[c], after[c]);
      next_displacement[c] = moved[0];
      next_velocity[c] = moved[1];
    }
  };
  for (int p = 1; p < axis.sample_count; ++p) {
    for (int k = 1; k <= steps; ++k) {
      move(2 * force - last);
      const double time = sample * (p - 1 + static_cast<double>(k) / steps);
      const Eigen::VectorXd after = drag(time, next_displacement, next_velocity);
      move(after);
      last = std::exchange(force, after);
      displacement = next_displacement;
      velocity = next_velocity;
    }
    if (!displacement.allFinite())
      throw Error("gusts: the motion leaves what numbers hold after " + number_text(sample * p) + " s");
    coordinates.row(p) = displacement.transpose();
    if (progress) progress(static_cast<double>(p) / axis.sample_count);
  }
  return coordinates;
}

}  // namespace tremula
