#include "tremula/modes/inertia.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <vector>

namespace tremula {
namespace {

// Carries a displacement rigidly along an arm: (u, theta) -> (u + theta x arm, theta).
Mat6 carry(const Vec3& arm) {
  Mat6 matrix = Mat6::Identity();
  matrix.topRightCorner<3, 3>() << 0, arm[2], -arm[1], -arm[2], 0, arm[0], arm[1], -arm[0], 0;
  return matrix;
}

// Blocks of the element's mass matrix in world axes: (start, start), (start, end), (end, end).
struct MassBlocks {
  Mat6 start, cross, end;
};

MassBlocks mass_blocks(const ElementMass& mass, const Vec3& d) {
  const Mat3 along = d * d.transpose(), across = Mat3::Identity() - along;
  Mat3 cross;  // d x
  cross << 0, -d[2], d[1], d[2], 0, -d[0], -d[1], d[0], 0;
  // With phi = theta x d: forces across are m v, moments d x (m phi) (see structure.cpp).
  const auto block = [&](int a, int b) {
    Mat6 matrix;
    const int i = 2 * a, j = 2 * b;
    matrix << mass.axial(a, b) * along + mass.bending(i, j) * across, -mass.bending(i, j + 1) * cross,
        mass.bending(i + 1, j) * cross, mass.torsion(a, b) * along + mass.bending(i + 1, j + 1) * across;
    return matrix;
  };
  return {block(0, 0), block(0, 1), block(1, 1)};
}

// A root of the tip's compliance: C = S S^T in world axes.
Mat6 compliance_root(const Compliance& c, const Vec3& d) {
  const Mat3 along = d * d.transpose(), across = Mat3::Identity() - along;
  Mat3 cross;
  cross << 0, -d[2], d[1], d[2], 0, -d[0], -d[1], d[0], 0;
  const double deflection = std::sqrt(c.deflection), slope_deflection = c.deflection_slope / deflection;
  const double slope = std::sqrt(c.slope - slope_deflection * slope_deflection);
  Mat6 root;
  root << std::sqrt(c.axial) * along + deflection * across, Mat3::Zero(), slope_deflection * cross,
      std::sqrt(c.torsion) * along + slope * across;
  return root;
}

int negative_count(const Mat6& pivot) {
  if (Eigen::LLT<Mat6>(pivot).info() == Eigen::Success) return 0;  // most are
  const Eigen::SelfAdjointEigenSolver<Mat6> solver(pivot, Eigen::EigenvaluesOnly);
  return static_cast<int>((solver.eigenvalues().array() < 0).count());
}

}  // namespace

int count_modes_below(const Structure& structure, double omega) {
  const double minus_square = -omega * omega;
  // What hangs on the end of each branch, as a dynamic stiffness there; filled by its children before it is
  // read.
  std::vector<Mat6> carried(structure.parent.size(), Mat6::Zero());
  int count = 0;
  for (int k = structure.branch_count() - 1; k >= 0; --k) {
    const auto index = static_cast<std::size_t>(k);
    const Vec3& direction = structure.direction[index];
    const MassBlocks mass = mass_blocks(structure.masses[index], direction);
    const Mat6 end = minus_square * mass.end + carried[index];
    const Mat6 root = compliance_root(structure.compliances[index], direction);
    const Mat6 pivot = Mat6::Identity() + root.transpose() * end * root;
    count += negative_count(pivot);

    const int parent = structure.parent[index];
    if (parent < 0) continue;
    // In (u_start, e), u_end = R u_start + e; then e is eliminated.
    const Mat6 rigid = carry(structure.reach[index] - structure.start_arm[index]);
    const Mat6 coupling = minus_square * mass.cross + rigid.transpose() * end;
    const Mat6 start =
        minus_square * (mass.start + mass.cross * rigid + rigid.transpose() * mass.cross.transpose()) +
        rigid.transpose() * end * rigid;
    const Mat6 half = root.transpose() * coupling.transpose();
    const Mat6 at_start = start - half.transpose() * pivot.ldlt().solve(half);
    const Mat6 to_node = carry(structure.start_arm[index]);
    carried[static_cast<std::size_t>(parent)] += to_node.transpose() * at_start * to_node;
  }
  return count;
}

}  // namespace tremula
