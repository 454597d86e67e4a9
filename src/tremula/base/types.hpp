// Names for the small vectors and matrices that every stage shares. SI units; the world is right-handed, z
// up.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace tremula {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Vec6 = Eigen::Matrix<double, 6, 1>;  // translation x y z [m], then rotation vector x y z [rad]
using Mat6 = Eigen::Matrix<double, 6, 6>;

}  // namespace tremula
