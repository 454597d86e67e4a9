// K and M of a tree as sparse matrices, which the cascade never builds (beam_tree.hpp).
#pragma once

#include <Eigen/SparseCore>

#include "tremula/structure/beam_tree.hpp"

namespace tremula {

struct SparseMatrices {
  Eigen::SparseMatrix<double> stiffness, mass;  // (6N x 6N), both triangles
};
SparseMatrices assemble_sparse(const BeamTree& tree);

}  // namespace tremula
