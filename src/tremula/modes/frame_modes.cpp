#include "tremula/modes/frame_modes.hpp"

#include "tremula/modes/solve_problem.hpp"

namespace tremula {

Modes solve_modes(const FrameMatrices& matrices, const ModeOptions& options) {
  const int count = mode_count(options, matrices.size(), "six for each free node");
  return solve_problem(eigen_problem(matrices), count, dense_is_better(options, matrices.size(), count),
                       options);
}

}  // namespace tremula
