#include "tremula/dynamics/motion.hpp"

#include "tremula/base/check.hpp"

#include <cmath>

namespace tremula {

Eigen::VectorXd coordinates_at(const Motion& motion, double time, Interpolation interpolation) {
  const int count = motion.sample_count();
  check_at_least("samples of the motion", count, 1);
  if (!(std::isfinite(motion.period) && motion.period > 0)) {
    throw InputError("period of the motion", std::to_string(motion.period), "above 0 s");
  }
  if (!std::isfinite(time)) throw InputError("time", std::to_string(time), "seconds");
  double position = std::fmod(time / motion.period, 1.0) * count;
  // A time that was meant as a sample, p T / M rounded, gives that sample to the last bit.
  if (std::abs(position - std::round(position)) < 1e-9 * count) position = std::round(position);
  const double floor = std::floor(position), fraction = position - floor;
  const auto sample = [&](int offset) {
    const long long p = static_cast<long long>(floor) + offset;
    return motion.coordinates.row(static_cast<Eigen::Index>(((p % count) + count) % count)).transpose();
  };
  if (fraction == 0) return sample(0);
  if (interpolation == Interpolation::linear) return (1 - fraction) * sample(0) + fraction * sample(1);

  const double t = fraction, t2 = t * t, t3 = t2 * t;
  return (-0.5 * t3 + t2 - 0.5 * t) * sample(-1) + (1.5 * t3 - 2.5 * t2 + 1) * sample(0) +
         (-1.5 * t3 + 2 * t2 + 0.5 * t) * sample(1) + (0.5 * t3 - 0.5 * t2) * sample(2);
}

void check_fit(const Modes& modes, const Motion& motion) {
  check_at_least("samples of the motion", motion.sample_count(), 1);
  check_equal("columns of the mode shapes", modes.shapes.cols(), modes.count());
  check_equal("modes of the motion", motion.mode_count(), modes.count());
  check_equal("rows of the lean", motion.lean.size(), modes.shapes.rows());
  check_equal("columns of the static shapes", motion.static_shapes.shapes.cols(),
              motion.static_shapes.count());
  if (motion.static_shapes.count() > 0) {
    check_equal("rows of the static shapes", motion.static_shapes.shapes.rows(), modes.shapes.rows());
  }
}

}  // namespace tremula
