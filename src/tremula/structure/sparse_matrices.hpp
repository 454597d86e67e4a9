// K and M as sparse matrices, for programs that want them so. The stages of the cascade do not: see
// structure.hpp.
#pragma once

#include <Eigen/SparseCore>

#include "tremula/structure/structure.hpp"

namespace tremula {

struct SparseMatrices {
  Eigen::SparseMatrix<double> stiffness, mass;  // (6N x 6N), both triangles
};
SparseMatrices assemble_sparse(const Structure& structure);

}  // namespace tremula
