// What a list of modes lacks, by counting.
#pragma once

#include <functional>

#include <Eigen/Core>

namespace tremula {

// `found` and `by_inertia`: modes in the list, and modes there are, below a frequency just above the last one
// asked for; or, where more are equal to that one than were asked for, just below it.
struct Census {
  int missing = 0;  // of the modes asked for; those equal to the last one stand for each other
  int found = 0, by_inertia = 0;
  int equal_to_last = 0, equal_left_out = 0;  // as in Modes; equal: to the relative difference `within`
};

// `values`: omega^-2 of the modes found, descending; at least `count`, of which the first `count` are asked
// for. `count_below`: as in EigenProblem.
Census take_census(const std::function<int(double omega)>& count_below, const Eigen::VectorXd& values,
                   int count, double within);

}  // namespace tremula
