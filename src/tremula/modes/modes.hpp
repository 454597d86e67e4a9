// How the structure vibrates: frequencies and mass-normalised shapes, each with the evidence for its
// accuracy.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace tremula {

// Ascending frequencies. Shapes are mass-normalised (Q^T M Q = I, S section 3), sign fixed so that the
// largest entry is positive. Rows of `shapes` are those of the structure (Node::row): x y z
// [m] and rotation vector x y z [rad] of every free node, per sqrt(kg) of modal coordinate.
struct Modes {
  Eigen::VectorXd frequency;    // (m) [Hz]
  Eigen::MatrixXd shapes;       // (rows x m)
  Eigen::VectorXd residual;     // (m) |A s - s/omega^2| omega^2 of the unit vector s, symmetric form [-]
  Eigen::VectorXd error_bound;  // (m) bound of the relative error of the frequency [-]
  int operator_count = 0;       // how often the operator of the symmetric form was applied
  // Modes found, and modes there are by the pivots of K - omega^2 M, below a frequency just above the last;
  // where equal modes are left out, just below those.
  int count_below = 0, count_by_inertia = 0;
  // Where the list ends among equal modes: how many modes there are at the last frequency, to 1 part in 1e8,
  // and how many of those it leaves out. Which ones it has, is chance.
  int equal_to_last = 0, equal_left_out = 0;
  double check_seconds = 0;  // what the count, and the search for what it found missing, took [s]

  int count() const { return static_cast<int>(frequency.size()); }
  Eigen::VectorXd omega() const { return frequency * 6.283185307179586476925; }  // [rad/s]
};

}  // namespace tremula
