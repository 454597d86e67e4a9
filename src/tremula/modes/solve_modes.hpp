// The eigenproblem K q = omega^2 M q of a structure (S section 3).
#pragma once

#include <functional>
#include <limits>

#include "tremula/modes/modes.hpp"
#include "tremula/structure/structure.hpp"

namespace tremula {

enum class ModeMethod {
  automatic,  // dense where the structure is small or most modes are wanted, else iterative
  dense,      // all eigenpairs of the symmetric form, O(N^3): the first algorithm of S section 3
  iterative,  // the largest omega^-2 by Lanczos (S section 3's `lanz`)
};

struct ModeOptions {
  int count = 40;  // how many of the lowest modes, 1 … rows of the structure; `all_modes` for every one
  ModeMethod method = ModeMethod::automatic;
  double tolerance = 1e-10;  // of the iterative method: relative residual of omega^-2; at most 1e-6
  // For the vectors of the search; where they do not fit, it takes longer (restarts). The dense method takes
  // two matrices of all modes, and cannot do with less. [bytes]
  std::size_t memory_limit = std::numeric_limits<std::size_t>::max();
  std::function<void(double done)> progress = {};  // 0 … 1; throw to cancel
};
inline constexpr int all_modes = -1;

// The lowest modes, none missing: their number is checked against EigenParts::count_below, and the search
// goes on until both agree. Of a frame, residuals and bounds are those of the operator as assembled: K has
// lost about log10(omega_max^2 / omega_1^2) digits of the lowest mode before. Throws InputError when count is
// 0, below 0 (but for all_modes) or larger than the rows, the memory limit is too small or the structure has
// too few digits for its modes to be told, Error when the machine has not the memory that the work takes, the
// iteration does not converge or the counts cannot be made to agree.
//
// Parts that stand on the ground by themselves are problems of their own and are solved one by one. Where the
// list ends among equal modes, it has as many of them as make up the count (Modes::equal_left_out).
Modes solve_modes(const Structure& structure, const ModeOptions& options = {});

// All modes below a frequency [Hz] > 0: as many as the count says. Throws InputError where there is
// none.
Modes solve_modes_up_to(const Structure& structure, double frequency, const ModeOptions& options = {});

}  // namespace tremula
