// Where the tests of the wind ask for it.
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "tremula/numerics/random.hpp"

namespace tremula::test {

// (3 x count) within a cube from 0 to `size` [m], the same every time.
inline Eigen::Matrix3Xd random_points(int count, double size) {
  Eigen::Matrix3Xd points(3, count);
  for (Eigen::Index i = 0; i < points.size(); ++i) {
    points.data()[i] = size * uniform({5, RandomStream::test, 3, static_cast<std::uint64_t>(i)});
  }
  return points;
}

}  // namespace tremula::test
