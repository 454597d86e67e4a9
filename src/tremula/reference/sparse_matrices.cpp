#include "tremula/reference/sparse_matrices.hpp"

#include "tremula/structure/element_blocks.hpp"

namespace tremula {

SparseMatrices assemble_sparse(const BeamTree& tree) {
  std::vector<Eigen::Triplet<double>> stiffness, mass;
  for (int k = 0; k < tree.branch_count(); ++k) {
    const auto index = static_cast<std::size_t>(k);
    const Vec3& direction = tree.members[index].direction;
    const int row = 6 * k, parent_row = tree.parent[index] < 0 ? -1 : 6 * tree.parent[index];
    add_element(stiffness_blocks(tree.compliances[index], direction, tree.reach[index]), parent_row, row,
                stiffness);
    if (tree.is_loaded()) {
      add_element(geometric_blocks(tree.geometric[index], tree.reach[index]), parent_row, row, stiffness);
    }
    ElementBlocks blocks = mass_blocks(tree, index);
    const Mat6 to_start = rigid_carry(tree.members[index].start_arm);
    blocks.start = to_start.transpose() * blocks.start * to_start;
    blocks.cross = to_start.transpose() * blocks.cross;
    add_element(blocks, parent_row, row, mass);
  }
  SparseMatrices matrices{Eigen::SparseMatrix<double>(tree.size(), tree.size()),
                          Eigen::SparseMatrix<double>(tree.size(), tree.size())};
  matrices.stiffness.setFromTriplets(stiffness.begin(), stiffness.end());
  matrices.mass.setFromTriplets(mass.begin(), mass.end());
  return matrices;
}

}  // namespace tremula
