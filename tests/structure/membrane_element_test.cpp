#include "tremula/structure/membrane_element.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include <Eigen/Eigenvalues>

namespace tremula {
namespace {

const PlateElement oblong{0.7, 1.3};
const MembraneSection steel = membrane_section(0.01, 200e9, 0.3, 7850);

// u, v and theta_z of the corners of an element that stands at (x0, y0).
PlateVector at_corners(const PlateElement& element,
                       const std::function<Eigen::Vector3d(double x, double y)>& field, double x0 = 0,
                       double y0 = 0) {
  const double x[] = {0, element.width, element.width, 0}, y[] = {0, 0, element.height, element.height};
  PlateVector corners;
  for (int i = 0; i < 4; ++i) corners.segment<3>(3 * i) = field(x0 + x[i], y0 + y[i]);
  return corners;
}

// Even stretch and shear, turned: u = a x + b y, v = c x + d y.
std::function<Eigen::Vector3d(double, double)> even(double a, double b, double c, double d) {
  return [=](double x, double y) { return Eigen::Vector3d(a * x + b * y, c * x + d * y, (c - b) / 2); };
}

TEST(MembraneStiffness, LeavesRigidMotionsWithoutForce) {
  const PlateMatrix stiffness = membrane_stiffness(oblong, steel);
  for (const auto& rigid : {std::function<Eigen::Vector3d(double, double)>(
                                [](double, double) { return Eigen::Vector3d(1, 0, 0); }),
                            std::function<Eigen::Vector3d(double, double)>(
                                [](double, double) { return Eigen::Vector3d(0, 1, 0); }),
                            even(0, -1, 1, 0)}) {
    const PlateVector moved = at_corners(oblong, rigid);
    EXPECT_LT((stiffness * moved).norm(), 1e-14 * stiffness.norm() * moved.norm());
  }
  const Eigen::SelfAdjointEigenSolver<PlateMatrix> solver(stiffness);
  EXPECT_LT(std::abs(solver.eigenvalues()[2]), 1e-12 * solver.eigenvalues()[11]);
  EXPECT_GT(solver.eigenvalues()[3], 1e-3 * solver.eigenvalues()[11]) << "and no others";
}

TEST(MembraneStiffness, HasTheEnergyOfEvenStretchAndShearWhateverTheRotationIsTiedWith) {
  const double a = 1e-3, b = 3e-4, c = -5e-4, d = 2e-3;
  const Eigen::Vector3d strains(a, d, b + c);
  const double wanted = oblong.width * oblong.height * steel.stretch_stiffness *
                        strains.dot(plane_stress(steel.poisson_ratio) * strains);
  const PlateVector moved = at_corners(oblong, even(a, b, c, d));
  for (const double tie : {1e-3, 1.0, 50.0})
    EXPECT_NEAR(moved.dot(membrane_stiffness(oblong, steel, tie) * moved) / wanted, 1, 1e-12) << tie;
}

// A mesh of rectangles of several sizes, u v theta_z of every node.
struct Mesh {
  std::vector<double> x, y;

  int across() const { return static_cast<int>(x.size()); }
  int node(int i, int j) const { return j * across() + i; }
  int size() const { return 3 * across() * static_cast<int>(y.size()); }

  template <class Element>
  Eigen::MatrixXd assembled(const Element& element) const {
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(size(), size());
    for (int j = 0; j + 1 < static_cast<int>(y.size()); ++j) {
      for (int i = 0; i + 1 < across(); ++i) {
        const std::array nodes{node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)};
        const auto at = [](int k) { return static_cast<std::size_t>(k); };
        const PlateMatrix own = element(PlateElement{x[at(i + 1)] - x[at(i)], y[at(j + 1)] - y[at(j)]});
        for (int a = 0; a < 12; ++a) {
          for (int b = 0; b < 12; ++b)
            sum(3 * nodes[at(a / 3)] + a % 3, 3 * nodes[at(b / 3)] + b % 3) += own(a, b);
        }
      }
    }
    return sum;
  }
};

// The patch test: a stretch and shear that are even at the edge are so inside.
TEST(MembraneStiffness, CarriesEvenStretchThroughAPatchOfUnequalElements) {
  const Mesh mesh{{0, 0.2, 0.7, 1}, {0, 0.5, 0.6, 1.4}};
  const Eigen::MatrixXd stiffness =
      mesh.assembled([](const PlateElement& element) { return membrane_stiffness(element, steel); });
  const auto field = even(1e-3, 3e-4, -5e-4, 2e-3);
  Eigen::VectorXd wanted(mesh.size());
  std::vector<int> inside, edge;
  for (int j = 0; j < 4; ++j) {
    for (int i = 0; i < 4; ++i) {
      wanted.segment<3>(3 * mesh.node(i, j)) =
          field(mesh.x[static_cast<std::size_t>(i)], mesh.y[static_cast<std::size_t>(j)]);
      const bool held = i == 0 || i == 3 || j == 0 || j == 3;
      for (int k = 0; k < 3; ++k) (held && k < 2 ? edge : inside).push_back(3 * mesh.node(i, j) + k);
    }
  }
  const Eigen::VectorXd given = wanted(edge);
  const Eigen::MatrixXd inner = stiffness(inside, inside), outer = stiffness(inside, edge);
  const Eigen::VectorXd found = -inner.ldlt().solve(outer * given);
  EXPECT_LT((found - wanted(inside)).norm(), 1e-12 * wanted.norm());
}

// In its plane, held along one edge: the lowest frequencies with rotations of their own tied a thousand times
// more loosely are those of the same plate, and nearer to them the finer the elements.
TEST(MembraneStiffness, HardlyDependsOnHowTheRotationIsTied) {
  const auto lowest = [](int count, double tie) {
    Mesh mesh;
    for (int i = 0; i <= count; ++i) {
      mesh.x.push_back(1.0 * i / count);
      mesh.y.push_back(0.4 * i / count);
    }
    const Eigen::MatrixXd stiffness =
        mesh.assembled([&](const PlateElement& element) { return membrane_stiffness(element, steel, tie); });
    const Eigen::MatrixXd mass =
        mesh.assembled([](const PlateElement& element) { return membrane_mass(element, steel); });
    std::vector<int> free;
    for (int j = 0; j <= count; ++j) {
      for (int i = 0; i <= count; ++i) {
        for (int k = i == 0 ? 2 : 0; k < 3; ++k) free.push_back(3 * mesh.node(i, j) + k);
      }
    }
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(
        stiffness(free, free), mass(free, free), Eigen::EigenvaluesOnly);
    return Eigen::VectorXd(solver.eigenvalues().head(3).cwiseSqrt());
  };
  const Eigen::VectorXd coarse = lowest(4, 1).cwiseQuotient(lowest(4, 1e-3)),
                        fine = lowest(8, 1).cwiseQuotient(lowest(8, 1e-3));
  for (int r = 0; r < 3; ++r) {
    EXPECT_NEAR(fine[r], 1, 0.01) << r;
    EXPECT_LT(std::abs(fine[r] - 1), 0.6 * std::abs(coarse[r] - 1)) << r;
  }
}

TEST(MembraneMass, IsThatOfThePlateInBothDirections) {
  const PlateMatrix mass = membrane_mass(oblong, steel);
  const double whole = steel.mass_per_area * oblong.width * oblong.height;
  const auto shift = [](double u, double v) {
    return at_corners(oblong, [=](double, double) { return Eigen::Vector3d(u, v, 0); });
  };
  EXPECT_NEAR(shift(1, 0).dot(mass * shift(1, 0)), whole, 1e-12 * whole);
  EXPECT_NEAR(shift(0, 1).dot(mass * shift(0, 1)), whole, 1e-12 * whole);
  EXPECT_NEAR(shift(1, 0).dot(mass * shift(0, 1)), 0, 1e-12 * whole);
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<PlateMatrix>(mass).eigenvalues()[0], 0);
}

TEST(CornerShares, AddUpToOneAndAreOneAtTheirCorner) {
  EXPECT_NEAR(corner_shares(0.3, 0.8).sum(), 1, 1e-15);
  EXPECT_EQ(corner_shares(1, 0), Eigen::Vector4d::Unit(1));
  EXPECT_EQ(corner_shares(1, 1), Eigen::Vector4d::Unit(2));
}

}  // namespace
}  // namespace tremula
