#include "tremula/dynamics/motion.hpp"

#include <cmath>

namespace tremula {

Eigen::VectorXd coordinates_at(const Motion& motion, double time, Interpolation interpolation) {
  const int count = motion.sample_count();
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

}  // namespace tremula
