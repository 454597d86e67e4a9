#include "tremula/numerics/rotation.hpp"

#include <numbers>

#include <gtest/gtest.h>

namespace tremula {
namespace {

TEST(RotationMatrix, IsThatOfTheAxisAndTheAngle) {
  for (const double angle : {0.0, 1e-9, 1e-5, 0.009, 0.011, 0.7, 3.0, 20.0}) {
    const Vec3 axis = Vec3(1, -2, 0.5).normalized();
    const Mat3 wanted = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
    EXPECT_LT((rotation_matrix(angle * axis) - wanted).norm(), 1e-14 * (1 + angle)) << angle;
  }
}

TEST(RotationVector, UndoesTheMatrixUpToHalfATurn) {
  for (const double angle : {0.0, 1e-12, 1e-6, 0.3, 1.6, 3.1, std::numbers::pi - 1e-7}) {
    const Vec3 vector = angle * Vec3(0.2, 1, -0.7).normalized();
    EXPECT_LT((rotation_vector(rotation_matrix(vector)) - vector).norm(), 1e-8) << angle;
  }
}

TEST(RotationTangent, TellsHowTheRotationTurnsWhenItsVectorGrows) {
  for (const double angle : {1e-6, 0.009, 0.011, 0.8, 2.5}) {
    const Vec3 vector = angle * Vec3(-0.4, 0.3, 1).normalized(), growth = 1e-6 * Vec3(0.6, -1, 0.2);
    const Vec3 turned =
        rotation_vector(rotation_matrix(vector + growth) * rotation_matrix(vector).transpose());
    EXPECT_LT((turned - rotation_tangent(vector) * growth).norm(), 1e-11) << angle;
  }
}

TEST(RotationTangentGrowth, IsTheDerivativeOfTheTransposedTangent) {
  const Vec3 force(1.3, -0.4, 0.9);
  for (const double angle : {0.0, 1e-6, 0.09, 0.11, 0.8, 2.5}) {
    const Vec3 vector = angle * Vec3(-0.4, 0.3, 1).normalized(), growth = 1e-5 * Vec3(0.6, -1, 0.2);
    const Vec3 difference =
        (rotation_tangent(vector + growth) - rotation_tangent(vector - growth)).transpose() * force;
    EXPECT_LT((0.5 * difference - rotation_tangent_growth(vector, force) * growth).norm(), 1e-14) << angle;
  }
}

}  // namespace
}  // namespace tremula
