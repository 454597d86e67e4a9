// The same structure the way textbooks assemble it: 12 x 12 element matrices in local axes, rotated and added
// up (Przemieniecki 1968; S section 2 and appendix A). The second method that the compliance form is compared
// with.
#pragma once

#include "tremula/geometry/skeleton.hpp"
#include "tremula/structure/beam_tree.hpp"

#include <Eigen/LU>

namespace tremula::test {

using Matrix12 = Eigen::Matrix<double, 12, 12>;

// Rows: x y z and rotations of the start, then of the end; local x along the branch.
inline Matrix12 local_stiffness(const BeamTree& tree, std::size_t k) {
  const Compliance& c = tree.compliances[k];
  Mat6 flexibility = Mat6::Zero();
  flexibility(0, 0) = c.axial;
  flexibility(1, 1) = flexibility(2, 2) = c.deflection;
  flexibility(3, 3) = c.torsion;
  flexibility(4, 4) = flexibility(5, 5) = c.slope;
  flexibility(1, 5) = flexibility(5, 1) = c.deflection_slope;
  flexibility(2, 4) = flexibility(4, 2) = -c.deflection_slope;
  const double L = tree.members[k].beam.length;
  Mat6 carry = Mat6::Identity();  // end displacement of a rigid beam from the start's
  carry(1, 5) = L;
  carry(2, 4) = -L;
  Eigen::Matrix<double, 6, 12> relative;
  relative << -carry, Mat6::Identity();
  return relative.transpose() * flexibility.inverse() * relative;
}

inline Matrix12 local_mass(const BeamTree& tree, std::size_t k) {
  const ElementMass& m = tree.masses[k];
  Matrix12 matrix = Matrix12::Zero();
  const int axial[] = {0, 6}, torsion[] = {3, 9}, xy[] = {1, 5, 7, 11}, xz[] = {2, 4, 8, 10};
  const double sign[] = {1, -1, 1, -1};  // slope of z along x is minus the rotation about y
  for (int a = 0; a < 2; ++a) {
    for (int b = 0; b < 2; ++b) {
      matrix(axial[a], axial[b]) = m.axial(a, b);
      matrix(torsion[a], torsion[b]) = m.torsion(a, b);
    }
  }
  for (int a = 0; a < 4; ++a) {
    for (int b = 0; b < 4; ++b) {
      matrix(xy[a], xy[b]) = m.bending(a, b);
      matrix(xz[a], xz[b]) = sign[a] * sign[b] * m.bending(a, b);
    }
  }
  return matrix;
}

struct Assembled {
  Eigen::MatrixXd stiffness, mass;
};

inline Assembled assemble_dense(const Skeleton& skeleton, const BeamTree& tree) {
  Assembled global{Eigen::MatrixXd::Zero(tree.size(), tree.size()),
                   Eigen::MatrixXd::Zero(tree.size(), tree.size())};
  for (int k = 0; k < tree.branch_count(); ++k) {
    const auto index = static_cast<std::size_t>(k);
    const Branch& branch = skeleton.branches[index];
    const Vec3 x = (branch.end - branch.start).normalized(), y = x.unitOrthogonal();
    Mat3 local_to_world;
    local_to_world << x, y, x.cross(y);
    Matrix12 rotation = Matrix12::Zero();
    for (int block = 0; block < 4; ++block) rotation.block<3, 3>(3 * block, 3 * block) = local_to_world;
    // T_k: from the nodes to the ends of the branch; the start may be an arm away from its node.
    Eigen::MatrixXd select = Eigen::MatrixXd::Zero(12, tree.size());
    select.block<6, 6>(6, 6 * k).setIdentity();
    if (const int parent = skeleton.parent(k); parent >= 0) {
      const Vec3 arm = branch.start - skeleton.node_position(branch.start_node);
      select.block<6, 6>(0, 6 * parent).setIdentity();
      select.block<3, 3>(0, 6 * parent + 3) << 0, arm[2], -arm[1], -arm[2], 0, arm[0], arm[1], -arm[0], 0;
    }
    global.stiffness +=
        select.transpose() * rotation * local_stiffness(tree, index) * rotation.transpose() * select;
    global.mass += select.transpose() * rotation * local_mass(tree, index) * rotation.transpose() * select;
  }
  return global;
}

}  // namespace tremula::test
