#include "tremula/dynamics/motion.hpp"

#include "tremula/base/check.hpp"
#include "tremula/numerics/fft.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tremula {
namespace {

// As the samples are interpolated.
Eigen::VectorXd interpolated(const Motion& motion, double time, Interpolation interpolation) {
  const int count = motion.sample_count();
  check_at_least("samples of the motion", count, 1);
  if (!(std::isfinite(motion.period) && motion.period > 0)) {
    throw InputError("period of the motion", std::to_string(motion.period), "above 0 s");
  }
  if (!std::isfinite(time)) throw InputError("time", std::to_string(time), "seconds");
  const double periods = time / motion.period;
  double position = (motion.repeats ? std::fmod(periods, 1.0) : std::clamp(periods, 0.0, 1.0)) * count;
  // A time that was meant as a sample, p T / M rounded, gives that sample to the last bit.
  if (std::abs(position - std::round(position)) < 1e-9 * count) position = std::round(position);
  if (!motion.repeats) position = std::min(position, count - 1.0);
  const double floor = std::floor(position), fraction = position - floor;
  const auto sample = [&](int offset) {
    const long long p = static_cast<long long>(floor) + offset, last = count - 1;
    const long long at = motion.repeats ? ((p % count) + count) % count : std::clamp(p, 0LL, last);
    return motion.coordinates.row(static_cast<Eigen::Index>(at)).transpose();
  };
  if (fraction == 0) return sample(0);
  if (interpolation == Interpolation::linear) return (1 - fraction) * sample(0) + fraction * sample(1);

  const double t = fraction, t2 = t * t, t3 = t2 * t;
  return (-0.5 * t3 + t2 - 0.5 * t) * sample(-1) + (1.5 * t3 - 2.5 * t2 + 1) * sample(0) +
         (-1.5 * t3 + 2 * t2 + 0.5 * t) * sample(1) + (0.5 * t3 - 0.5 * t2) * sample(2);
}

}  // namespace

Motion make_motion(Basis basis, const TimeAxis& loop, const Eigen::MatrixXcd& spectra) {
  check_equal("columns of the spectra", spectra.cols(), basis.count() - 1);
  return make_motion(std::move(basis), loop, samples_from_half_spectra(spectra, loop.sample_count));
}

Motion make_motion(Basis basis, const TimeAxis& loop, const Eigen::MatrixXd& samples) {
  check_equal("leans of the basis", basis.count(ShapeKind::lean), 1);
  check_equal("rows of the samples", samples.rows(), loop.sample_count);
  check_equal("columns of the samples", samples.cols(), basis.count() - 1);
  Motion motion{loop.period, std::move(basis), Eigen::MatrixXd(loop.sample_count, samples.cols() + 1)};
  motion.coordinates << Eigen::VectorXd::Ones(loop.sample_count), samples;
  return motion;
}

void check_motion(const Motion& motion) {
  check_at_least("samples of the motion", motion.sample_count(), 1);
  if (!(std::isfinite(motion.period) && motion.period > 0)) {
    throw InputError("period of the motion", std::to_string(motion.period), "above 0 s");
  }
  check_basis(motion.basis);
  check_equal("columns of the coordinates", motion.coordinates.cols(), motion.basis.count());
  if (!motion.coordinates.allFinite())
    throw InputError("motion", "a coordinate that is not finite", "finite numbers");
}

Eigen::VectorXd coordinates_at(const Motion& motion, double time, Interpolation interpolation) {
  check_equal("columns of the coordinates", motion.coordinates.cols(), motion.basis.count());
  check_equal("kinds of the shapes", static_cast<std::ptrdiff_t>(motion.basis.kind.size()),
              motion.basis.count());
  Eigen::VectorXd coordinates = interpolated(motion, time, interpolation);
  // Weights of samples add up to 1 but for rounding.
  for (std::size_t c = 0; c < motion.basis.kind.size(); ++c) {
    if (motion.basis.kind[c] == ShapeKind::lean) coordinates[static_cast<Eigen::Index>(c)] = 1;
  }
  return coordinates;
}

Eigen::VectorXd displacement_at(const Motion& motion, double time, Interpolation interpolation) {
  return superpose(motion.basis, coordinates_at(motion, time, interpolation));
}

}  // namespace tremula
