// Any movement of a structure over a loop as a Motion: by the few shapes that hold nearly all of it.
#pragma once

#include "tremula/dynamics/motion.hpp"
#include "tremula/numerics/time_axis.hpp"

#include <Eigen/Core>

namespace tremula {

struct PrincipalOptions {
  double tolerance =
      0.01;        // what the shapes leave out of the translations, root of the mean square, relative
  int most = 120;  // shapes at most, whatever they leave out
};

struct PrincipalMotion {
  Motion motion;
  double left_out = 0;  // as tolerance
};

// displacements (rows x M), a column a sample, about the lean (rows). The shapes are those of the proper
// orthogonal decomposition: for every number of them, none leave out less of the mean square of the
// translations (Sirovich 1987, method of snapshots). They are told as modes, the strongest first, each with
// the frequency that its coordinate has on the average, root of the mean square of its rate over that of
// itself. Costs the eigenvalues of an M x M matrix. Throws InputError for sizes that do not agree, and for
// options out of range.
PrincipalMotion principal_motion(const Eigen::VectorXd& lean, const TimeAxis& loop,
                                 const Eigen::MatrixXd& displacements, const PrincipalOptions& options = {});

}  // namespace tremula
