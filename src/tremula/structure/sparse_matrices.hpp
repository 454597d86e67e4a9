// K and M as sparse matrices, for programs that want them so. The stages of the cascade do not: see
// structure.hpp.
#pragma once

#include <Eigen/SparseCore>
#include <vector>

#include "tremula/structure/element_blocks.hpp"
#include "tremula/structure/structure.hpp"

namespace tremula {

struct SparseMatrices {
  Eigen::SparseMatrix<double> stiffness, mass;  // (6N x 6N), both triangles
};
SparseMatrices assemble_sparse(const Structure& structure);

// Adds the blocks of an element to the rows of its two nodes; start_row and end_row are the first of six, -1
// where the node is clamped and has none.
void add_element(const ElementBlocks& blocks, int start_row, int end_row,
                 std::vector<Eigen::Triplet<double>>& triplets);

}  // namespace tremula
