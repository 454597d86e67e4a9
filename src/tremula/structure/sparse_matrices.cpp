#include "tremula/structure/sparse_matrices.hpp"

#include <Eigen/LU>
#include <vector>

#include "tremula/structure/element_blocks.hpp"

namespace tremula {
namespace {

void add_block(std::vector<Eigen::Triplet<double>>& triplets, int row, int column, const Mat6& block) {
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) triplets.emplace_back(6 * row + i, 6 * column + j, block(i, j));
  }
}

}  // namespace

SparseMatrices assemble_sparse(const Structure& structure) {
  std::vector<Eigen::Triplet<double>> stiffness, mass;
  for (int k = 0; k < structure.branch_count(); ++k) {
    const auto index = static_cast<std::size_t>(k);
    const int parent = structure.parent[index];
    const Mat6 tip = compliance_block(structure.compliances[index], structure.direction[index]).inverse();
    const MassBlocks blocks = mass_blocks(structure.masses[index], structure.direction[index]);
    add_block(stiffness, k, k, tip);
    add_block(mass, k, k, blocks.end);
    if (parent < 0) continue;
    const Mat6 to_end = rigid_carry(structure.reach[index]);
    const Mat6 to_start = rigid_carry(structure.start_arm[index]);
    add_block(stiffness, parent, parent, to_end.transpose() * tip * to_end);
    add_block(stiffness, parent, k, -to_end.transpose() * tip);
    add_block(stiffness, k, parent, -tip * to_end);
    add_block(mass, parent, parent, to_start.transpose() * blocks.start * to_start);
    add_block(mass, parent, k, to_start.transpose() * blocks.cross);
    add_block(mass, k, parent, blocks.cross.transpose() * to_start);
  }
  SparseMatrices matrices{Eigen::SparseMatrix<double>(structure.size(), structure.size()),
                          Eigen::SparseMatrix<double>(structure.size(), structure.size())};
  matrices.stiffness.setFromTriplets(stiffness.begin(), stiffness.end());
  matrices.mass.setFromTriplets(mass.begin(), mass.end());
  return matrices;
}

}  // namespace tremula
