// From an eigenproblem to modes, none missing, whatever the kind of structure.
#pragma once

#include "tremula/modes/eigen_problem.hpp"
#include "tremula/modes/solve_modes.hpp"

#include <string>

namespace tremula {

// The number of modes that the options ask for, of those there are. Throws InputError where that is none or
// too many; `explanation` says where the largest number comes from.
int mode_count(const ModeOptions& options, Eigen::Index degrees_of_freedom, const std::string& explanation);

// Whether all modes at once are the better way to that many.
bool dense_is_better(const ModeOptions& options, Eigen::Index degrees_of_freedom, int count);

// Lanczos sees one vector of every multiple eigenvalue and may pass by members of a tight cluster. What the
// inertia says is missing is searched for at right angles to what is there, until nothing is missing. Throws
// as solve_modes does.
Modes solve_problem(const EigenProblem& problem, int count, bool dense, const ModeOptions& options);

}  // namespace tremula
