// The small vectors and matrices that every stage shares. SI units; the world is right-handed, z
// up.
#pragma once

#include <cstddef>

#include <Eigen/Core>
#include <Eigen/Geometry>

// The library and its users pass Eigen's vectors to each other, and with -mavx Eigen would align them
// otherwise and take its heap memory in another way. The target tremula::tremula carries both definitions; 64
// is also what a heap block needs for the widest vector unit.
static_assert(EIGEN_MAX_STATIC_ALIGN_BYTES == 16 && EIGEN_DEFAULT_ALIGN_BYTES == 64,
              "compile with -DEIGEN_MAX_STATIC_ALIGN_BYTES=16 -DEIGEN_MAX_ALIGN_BYTES=64, as tremula was");

namespace tremula {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Vec6 = Eigen::Matrix<double, 6, 1>;  // translation x y z [m], then rotation vector x y z [rad]
using Mat6 = Eigen::Matrix<double, 6, 6>;

// cross_matrix(v) * w is v x w.
inline Mat3 cross_matrix(const Vec3& v) {
  Mat3 matrix;
  matrix << 0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0;
  return matrix;
}

// Branches, nodes and rows are counted by signed numbers, arrays of the standard library by unsigned ones.
constexpr std::size_t index_of(std::ptrdiff_t i) { return static_cast<std::size_t>(i); }

}  // namespace tremula
