#include "tremula/structure/sparse_matrices.hpp"

namespace tremula {

void add_element(const ElementBlocks& blocks, int start_row, int end_row,
                 std::vector<Eigen::Triplet<double>>& triplets) {
  const auto add = [&](int row, int column, const auto& block) {
    if (row < 0 || column < 0) return;
    for (int i = 0; i < 6; ++i) {
      for (int j = 0; j < 6; ++j) triplets.emplace_back(row + i, column + j, block(i, j));
    }
  };
  add(start_row, start_row, blocks.start);
  add(start_row, end_row, blocks.cross);
  add(end_row, start_row, blocks.cross.transpose());
  add(end_row, end_row, blocks.end);
}

SparseMatrices assemble_sparse(const Structure& structure) {
  std::vector<Eigen::Triplet<double>> stiffness, mass;
  for (int k = 0; k < structure.branch_count(); ++k) {
    const auto index = static_cast<std::size_t>(k);
    const Vec3& direction = structure.direction[index];
    const int row = 6 * k, parent_row = structure.parent[index] < 0 ? -1 : 6 * structure.parent[index];
    add_element(stiffness_blocks(structure.compliances[index], direction, structure.reach[index]), parent_row,
                row, stiffness);
    ElementBlocks blocks = mass_blocks(structure.masses[index], direction);
    const Mat6 to_start = rigid_carry(structure.start_arm[index]);
    blocks.start = to_start.transpose() * blocks.start * to_start;
    blocks.cross = to_start.transpose() * blocks.cross;
    add_element(blocks, parent_row, row, mass);
  }
  SparseMatrices matrices{Eigen::SparseMatrix<double>(structure.size(), structure.size()),
                          Eigen::SparseMatrix<double>(structure.size(), structure.size())};
  matrices.stiffness.setFromTriplets(stiffness.begin(), stiffness.end());
  matrices.mass.setFromTriplets(mass.begin(), mass.end());
  return matrices;
}

}  // namespace tremula
