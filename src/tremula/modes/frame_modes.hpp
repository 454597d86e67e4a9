// The modes of structures with loops and several clamps.
#pragma once

#include "tremula/modes/solve_modes.hpp"
#include "tremula/structure/frame.hpp"

namespace tremula {

// As solve_modes of a Structure, with the same proof that none is missing; shapes have the rows of the
// matrices (FrameMatrices::row). Residuals and bounds are those of the operator as assembled: K has lost
// about log10(omega_max^2 / omega_1^2) digits of the lowest mode before. Throws as solve_modes does.
Modes solve_modes(const FrameMatrices& matrices, const ModeOptions& options = {});

}  // namespace tremula
