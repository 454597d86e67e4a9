// Frequency and damping out of a record of what was let go, by logarithmic decrement: as a field test has
// them from a tree that was pulled and released.
#pragma once

#include <Eigen/Core>

namespace tremula {

struct FreeDecay {
  double frequency = 0;      // of the undamped oscillator, that of the cycles over sqrt(1 - zeta^2) [Hz]
  double damping_ratio = 0;  // zeta, from the decrement delta of a cycle: delta/sqrt(4 pi^2 + delta^2)
  double cycles = 0;         // that were evaluated
  double scatter = 0;        // rms of ln(peak) about its line: 0 of one mode, more where several beat
};

struct DecayOptions {
  double lowest = 0.01;  // peaks below this share of the first that counts are too small to count
  int most_cycles = 20;
  int fewest_cycles = 2;
};

// Of a record (M) about its rest at equidistant instants, `step` apart [s]. The peaks to both sides, one
// between two crossings of zero, each the top of a parabola through the samples around it; straight lines by
// least squares through their instants and through their logarithms. What comes before the first crossing
// does not count: the release itself excites all modes, and the high ones die first. Throws InputError where
// the record has fewer cycles than it takes, numbers that are not finite or fewer than 8 samples a cycle.
FreeDecay evaluate_decay(const Eigen::VectorXd& record, double step, const DecayOptions& options = {});

}  // namespace tremula
