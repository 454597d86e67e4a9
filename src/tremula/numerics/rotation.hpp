// Rotations in space by their rotation vectors: axis times angle [rad].
#pragma once

#include "tremula/base/types.hpp"

#include <algorithm>
#include <cmath>

namespace tremula {

namespace rotation_detail {

// sin(x)/x, (1 - cos x)/x^2 and (x - sin x)/x^3 of x^2. Up to a third of a radian, as branches bend, by their
// series, to the last digit: there the quotients lose some and take twice the time.
struct Coefficients {
  double sine, cosine, rest;
  explicit Coefficients(double square) {
    if (square < 0.1) {
      const auto series = [square](double a, double b, double c, double d) {
        return 1 -
               square * (1 / a) * (1 - square * (1 / b) * (1 - square * (1 / c) * (1 - square * (1 / d))));
      };
      sine = 1 - square * (1.0 / 6) * series(20, 42, 72, 110);
      cosine = 0.5 - square * (1.0 / 24) * series(30, 56, 90, 132);
      rest = 1.0 / 6 - square * (1.0 / 120) * series(42, 72, 110, 156);
      return;
    }
    const double angle = std::sqrt(square);
    const double sin = std::sin(angle);
    sine = sin / angle;
    cosine = (1 - std::cos(angle)) / square;
    rest = (angle - sin) / (square * angle);
  }
};

}  // namespace rotation_detail

// exp of the cross matrix of v (Rodrigues).
inline Mat3 rotation_matrix(const Vec3& v) {
  const double x = v[0], y = v[1], z = v[2], square = x * x + y * y + z * z;
  const rotation_detail::Coefficients c(square);
  const double s = c.sine, k = c.cosine;
  Mat3 rotation;
  rotation << 1 - k * (y * y + z * z), k * x * y - s * z, k * x * z + s * y,  //
      k * x * y + s * z, 1 - k * (x * x + z * z), k * y * z - s * x,          //
      k * x * z - s * y, k * y * z + s * x, 1 - k * (x * x + y * y);
  return rotation;
}

// The vector of at most half a turn that gives this rotation.
inline Vec3 rotation_vector(const Mat3& rotation) {
  const Eigen::Quaterniond q(rotation);
  const double sine = q.vec().norm();
  if (sine < 1e-9) return 2 * q.vec() * (q.w() < 0 ? -1 : 1);
  const double angle = 2 * std::atan2(q.w() < 0 ? -sine : sine, std::abs(q.w()));
  return angle / sine * q.vec();
}

// The rotation that takes one unit vector into another by the shortest way.
inline Mat3 shortest_turn(const Vec3& from, const Vec3& to) {
  const Vec3 axis = from.cross(to);
  const double cosine = from.dot(to);
  if (cosine < -0.999999) return Eigen::Quaterniond::FromTwoVectors(from, to).toRotationMatrix();
  const Mat3 cross = cross_matrix(axis);
  return Mat3::Identity() + cross + cross * cross / (1 + cosine);
}

// How the rotation turns when its vector grows: exp(v + dv) = exp(T dv) exp(v) to first order.
inline Mat3 rotation_tangent(const Vec3& v) {
  const rotation_detail::Coefficients c(v.squaredNorm());
  const Mat3 cross = cross_matrix(v);
  return Mat3::Identity() + c.cosine * cross + c.rest * cross * cross;
}

// How rotation_tangent(v)^T w grows with v.
inline Mat3 rotation_tangent_growth(const Vec3& v, const Vec3& w) {
  const double square = v.squaredNorm();
  const rotation_detail::Coefficients c(square);
  // The gradients of cosine and rest are these times v.
  const bool small = square < 1e-2;
  const double cosine_growth =
      small ? -1.0 / 12 + square / 180 * (1 - square * 3 / 112) : (c.sine - 2 * c.cosine) / square;
  const double rest_growth =
      small ? -1.0 / 60 + square / 1260 * (1 - square / 48) : (c.cosine - 3 * c.rest) / square;
  const Vec3 once = v.cross(w), twice = v.cross(once);
  return c.cosine * cross_matrix(w) +
         c.rest * (v.dot(w) * Mat3::Identity() + v * w.transpose() - 2 * w * v.transpose()) +
         (rest_growth * twice - cosine_growth * once) * v.transpose();
}

}  // namespace tremula
