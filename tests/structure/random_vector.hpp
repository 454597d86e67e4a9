// Displacements and forces without any order in them.
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "tremula/numerics/random.hpp"

namespace tremula::test {

// Normal, of unit size, and the same every time for a seed.
inline Eigen::VectorXd random_vector(Eigen::Index size, std::uint64_t seed) {
  Eigen::VectorXd vector(size);
  for (Eigen::Index i = 0; i < size; ++i) {
    vector[i] = complex_gaussian({seed, RandomStream::test, 1, static_cast<std::uint64_t>(i)}).real();
  }
  return vector;
}

}  // namespace tremula::test
