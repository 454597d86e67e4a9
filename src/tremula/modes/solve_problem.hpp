// From an eigenproblem to modes, none missing, whatever the kind of structure.
#pragma once

#include "tremula/modes/census.hpp"
#include "tremula/modes/solve_modes.hpp"
#include "tremula/structure/eigen_problem.hpp"

#include <string>

namespace tremula {

// The number of modes that the options ask for, of those there are. Throws InputError where that is none or
// too many; `explanation` says where the largest number comes from.
int mode_count(const ModeOptions& options, Eigen::Index degrees_of_freedom, const std::string& explanation);

// Whether all modes at once are the better way to that many.
bool dense_is_better(const ModeOptions& options, Eigen::Index degrees_of_freedom, int count);

// The relative difference up to which frequencies count as equal: enough for the errors of the eigenvalues,
// and not for neighbours.
double equal_within(const ModeOptions& options);

// Bytes that so many modes take: likely, and the fewest they can do with.
struct ModeMemory {
  std::size_t likely, least;
};
ModeMemory mode_memory(Eigen::Index size, int count, bool dense);

// Before any of it is taken: throws InputError where the limit of the options does not hold the fewest, Error
// where the machine does not have what is likely, or the limit.
void check_memory(const ModeMemory& memory, int count, Eigen::Index degrees_of_freedom,
                  const ModeOptions& options);

void keep_census(const Census& census, Modes& modes);

// Lanczos sees one vector of every multiple eigenvalue and may pass by members of a tight cluster. What the
// census says is missing is searched for by blocks, at right angles to what is there, until nothing is
// missing. Throws as solve_modes does.
Modes solve_problem(const EigenProblem& problem, int count, bool dense, const ModeOptions& options);

}  // namespace tremula
