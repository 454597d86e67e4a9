#include "tremula/structure/plate_element.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>

#include <Eigen/Eigenvalues>

#include "tremula/numerics/quadrature.hpp"

namespace tremula {
namespace {

const PlateElement oblong{0.7, 1.3};
const PlateSection steel = plate_section(0.01, 200e9, 0.3, 7850);

// A deflection with its two derivatives, at the corners as the element has them.
struct Field {
  std::function<double(double x, double y)> w, wx, wy;
};

PlateVector at_corners(const PlateElement& element, const Field& field) {
  const double x[] = {0, element.width, element.width, 0}, y[] = {0, 0, element.height, element.height};
  PlateVector corners;
  for (int i = 0; i < 4; ++i)
    corners.segment<3>(3 * i) << field.w(x[i], y[i]), field.wy(x[i], y[i]), -field.wx(x[i], y[i]);
  return corners;
}

// a + b x + c y, moved or turned as a rigid body.
Field plane(double a, double b, double c) {
  return {[=](double x, double y) { return a + b * x + c * y; }, [=](double, double) { return b; },
          [=](double, double) { return c; }};
}

// Curved evenly: (kx x^2 + ky y^2) / 2 + kxy x y.
Field paraboloid(double kx, double ky, double kxy) {
  return {[=](double x, double y) { return (kx * x * x + ky * y * y) / 2 + kxy * x * y; },
          [=](double x, double y) { return kx * x + kxy * y; },
          [=](double x, double y) { return ky * y + kxy * x; }};
}

TEST(PlateShape, GivesBackWhatItsCornersDo) {
  const double s[] = {0, 1, 1, 0}, t[] = {0, 0, 1, 1};
  for (int i = 0; i < 4; ++i) {
    const PlateShape shape = plate_shape_at(oblong, s[i], t[i]);
    EXPECT_LT((shape.deflection - PlateVector::Unit(3 * i)).norm(), 1e-15);
    EXPECT_LT((shape.slope_y - PlateVector::Unit(3 * i + 1)).norm(), 1e-14);
    EXPECT_LT((shape.slope_x + PlateVector::Unit(3 * i + 2)).norm(), 1e-14);
  }
}

TEST(PlateShape, HasEveryCubicAndTwoTermsOfTheFourthDegree) {
  for (int i = 0; i <= 3; ++i) {
    for (int j = 0; j <= 3; ++j) {
      if (i + j > 3 && !(i * j == 3)) continue;
      const Field power{[=](double x, double y) { return std::pow(x, i) * std::pow(y, j); },
                        [=](double x, double y) { return i ? i * std::pow(x, i - 1) * std::pow(y, j) : 0; },
                        [=](double x, double y) { return j ? j * std::pow(x, i) * std::pow(y, j - 1) : 0; }};
      const PlateVector corners = at_corners(oblong, power);
      for (const auto& [s, t] : {std::pair{0.2, 0.9}, {0.55, 0.3}}) {
        EXPECT_NEAR(plate_shape_at(oblong, s, t).deflection.dot(corners),
                    power.w(s * oblong.width, t * oblong.height), 1e-14)
            << i << ' ' << j;
      }
    }
  }
}

TEST(PlateShape, HasTheDerivativesOfItsDeflection) {
  const double s = 0.37, t = 0.61, step = 1e-4;
  const auto at = [&](double i, double j) {
    return plate_shape_at(oblong, s + i * step / oblong.width, t + j * step / oblong.height);
  };
  const PlateShape shape = at(0, 0);
  const auto expect_near = [](const PlateVector& found, const PlateVector& wanted) {
    EXPECT_LT((found - wanted).norm(), 1e-7 * wanted.norm());
  };
  expect_near((at(1, 0).deflection - at(-1, 0).deflection) / (2 * step), shape.slope_x);
  expect_near((at(0, 1).deflection - at(0, -1).deflection) / (2 * step), shape.slope_y);
  expect_near((at(1, 0).slope_x - at(-1, 0).slope_x) / (2 * step), shape.bend_x);
  expect_near((at(0, 1).slope_y - at(0, -1).slope_y) / (2 * step), shape.bend_y);
  expect_near((at(0, 1).slope_x - at(0, -1).slope_x) / (2 * step), shape.twist);
}

TEST(PlateShape, IsContinuousWithItsNeighbourAlongTheEdgeTheyShare) {
  const PlateElement neighbour{2.1, oblong.height};
  const PlateVector left = PlateVector::LinSpaced(12, -1, 0.8).array().sin();
  PlateVector right = PlateVector::Constant(0.3);
  right.segment<3>(0) = left.segment<3>(3);
  right.segment<3>(9) = left.segment<3>(6);
  for (const double t : {0.1, 0.5, 0.8}) {
    const PlateShape before = plate_shape_at(oblong, 1, t), after = plate_shape_at(neighbour, 0, t);
    EXPECT_NEAR(before.deflection.dot(left), after.deflection.dot(right), 1e-14);
    EXPECT_NEAR(before.slope_y.dot(left), after.slope_y.dot(right), 1e-14);
  }
}

TEST(PlateStiffness, IsNoneAgainstRigidMotionsAndAboveZeroAgainstAllOthers) {
  const PlateMatrix K = plate_stiffness(oblong, steel);
  EXPECT_LT((K - K.transpose()).norm(), 1e-15 * K.norm());
  for (const Field& rigid : {plane(1, 0, 0), plane(0, 1, 0), plane(0, 0, 1)}) {
    const PlateVector corners = at_corners(oblong, rigid);
    EXPECT_LT((K * corners).norm(), 1e-13 * K.norm() * corners.norm());
  }
  const Eigen::SelfAdjointEigenSolver<PlateMatrix> solver(K, Eigen::EigenvaluesOnly);
  EXPECT_LT(std::abs(solver.eigenvalues()[2]), 1e-12 * solver.eigenvalues()[11]);
  EXPECT_GT(solver.eigenvalues()[3], 1e-6 * solver.eigenvalues()[11]);
}

TEST(PlateStiffness, OfAnEvenCurvatureHasTheEnergyOfThePlate) {
  const PlateMatrix K = plate_stiffness(oblong, steel);
  const double D = steel.bending_stiffness, nu = steel.poisson_ratio, area = oblong.width * oblong.height;
  for (const auto& [kx, ky, kxy] :
       {std::array{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}, {0.4, -0.7, 0.9}}) {
    const PlateVector corners = at_corners(oblong, paraboloid(kx, ky, kxy));
    const double wanted = D * area * (kx * kx + ky * ky + 2 * nu * kx * ky + 2 * (1 - nu) * kxy * kxy);
    EXPECT_NEAR(corners.dot(K * corners) / wanted, 1, 1e-13);
  }
}

// The patch test: unequal rectangles under even curvature leave the node between them without a load.
TEST(PlateStiffness, OfAPatchOfUnequalElementsCarriesAnEvenCurvature) {
  const double x[] = {0, 0.7, 1.1}, y[] = {0, 0.4, 1.3};
  const Field field = paraboloid(0.4, -0.7, 0.9);
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  double largest = 0;
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      const PlateElement element{x[i + 1] - x[i], y[j + 1] - y[j]};
      const Field here{[&](double u, double v) { return field.w(x[i] + u, y[j] + v); },
                       [&](double u, double v) { return field.wx(x[i] + u, y[j] + v); },
                       [&](double u, double v) { return field.wy(x[i] + u, y[j] + v); }};
      const PlateVector force = plate_stiffness(element, steel) * at_corners(element, here);
      const int corner = i == 0 ? (j == 0 ? 2 : 1) : (j == 0 ? 3 : 0);
      middle += force.segment<3>(3 * corner);
      largest = std::max(largest, force.cwiseAbs().maxCoeff());
    }
  }
  EXPECT_LT(middle.norm(), 1e-12 * largest);
}

// Mirrored in the line x = y, w stays, and theta_x = dw/dy and theta_y = -dw/dx change places with a sign.
TEST(PlateMatrices, AreTheSameWhenTheAxesChangePlaces) {
  const PlateElement turned{oblong.height, oblong.width};
  PlateMatrix swap = PlateMatrix::Zero();
  const int corner_of[] = {0, 3, 2, 1};
  for (int i = 0; i < 4; ++i) {
    const int from = 3 * i, to = 3 * corner_of[i];
    swap(to, from) = 1;
    swap(to + 1, from + 2) = -1;
    swap(to + 2, from + 1) = -1;
  }
  const auto expect_swapped = [&](const PlateMatrix& one, const PlateMatrix& other) {
    EXPECT_LT((swap * one * swap.transpose() - other).norm(), 1e-14 * other.norm());
  };
  expect_swapped(plate_stiffness(oblong, steel), plate_stiffness(turned, steel));
  expect_swapped(plate_mass(oblong, 3), plate_mass(turned, 3));
  expect_swapped(plate_geometric_stiffness(oblong, {3, 5, 2}), plate_geometric_stiffness(turned, {5, 3, 2}));
}

TEST(PlateMass, OfARigidMotionIsThatOfTheRectangle) {
  const double per_area = 12, mass = per_area * oblong.width * oblong.height;
  const PlateMatrix M = plate_mass(oblong, per_area);
  EXPECT_LT((M - M.transpose()).norm(), 1e-15 * M.norm());
  const auto energy = [&](const Field& one, const Field& other) {
    return at_corners(oblong, one).dot(M * at_corners(oblong, other));
  };
  const Field up = plane(1, 0, 0), about_y = plane(0, 1, 0), about_x = plane(0, 0, 1);
  EXPECT_NEAR(energy(up, up), mass, 1e-13 * mass);
  EXPECT_NEAR(energy(up, about_y), mass * oblong.width / 2, 1e-13 * mass);
  EXPECT_NEAR(energy(about_y, about_y), mass * oblong.width * oblong.width / 3, 1e-13 * mass);
  EXPECT_NEAR(energy(about_x, about_x), mass * oblong.height * oblong.height / 3, 1e-13 * mass);
  const Eigen::SelfAdjointEigenSolver<PlateMatrix> solver(M, Eigen::EigenvaluesOnly);
  EXPECT_GT(solver.eigenvalues()[0], 0);
}

TEST(PlateGeometricStiffness, OfASlopeIsThePullTimesItsSquare) {
  const MembraneForce force{3, -5, 2};
  const PlateMatrix G = plate_geometric_stiffness(oblong, force);
  const double b = 0.3, c = -0.8;
  const PlateVector corners = at_corners(oblong, plane(0.1, b, c));
  const double wanted =
      oblong.width * oblong.height * (force.x * b * b + force.y * c * c + 2 * force.xy * b * c);
  EXPECT_NEAR(corners.dot(G * corners), wanted, 1e-13);
}

// Slopes by differences of the deflection, integrated by another number of points.
TEST(PlateGeometricStiffness, IsTheQuadratureOfTheSlopes) {
  const MembraneForce force{3, -5, 2};
  PlateMatrix wanted = PlateMatrix::Zero();
  const double step = 1e-4;
  for (const QuadraturePoint& along : gauss_legendre(6)) {
    for (const QuadraturePoint& up : gauss_legendre(6)) {
      const auto w = [&](double i, double j) {
        return plate_shape_at(oblong, along.position + i * step, up.position + j * step).deflection;
      };
      const PlateVector x = (w(1, 0) - w(-1, 0)) / (2 * step * oblong.width),
                        y = (w(0, 1) - w(0, -1)) / (2 * step * oblong.height);
      wanted += along.weight * up.weight * oblong.width * oblong.height *
                (force.x * x * x.transpose() + force.y * y * y.transpose() +
                 force.xy * (x * y.transpose() + y * x.transpose()));
    }
  }
  const PlateMatrix G = plate_geometric_stiffness(oblong, force);
  EXPECT_LT((G - wanted).norm(), 1e-7 * G.norm());
}

}  // namespace
}  // namespace tremula
