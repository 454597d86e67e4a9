// How the structure vibrates: frequencies and mass-normalised shapes, each with the evidence for its
// accuracy.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace tremula {

// Ascending frequencies. Shapes are mass-normalised (Q^T M Q = I, S section 3), sign fixed so that the
// largest entry is positive. Rows 6k … 6k+5 of `shapes` are the displacement of the end of branch k (x y z
// [m], rotation vector x y z [rad], per sqrt(kg) of modal coordinate); the clamped roots have no rows.
struct Modes {
  Eigen::VectorXd frequency;    // (m) [Hz]
  Eigen::MatrixXd shapes;       // (6N x m)
  Eigen::VectorXd residual;     // (m) |A s - s/omega^2| omega^2 of the unit vector s, compliance form [-]
  Eigen::VectorXd error_bound;  // (m) bound of the relative error of the frequency [-]
  int operator_count = 0;       // how often the compliance operator was applied
  int count_below = 0;       // modes found below a frequency just above the last (its duplicates count too)
  int count_by_inertia = 0;  // modes there are below it, by the inertia of K - omega^2 M
  double check_seconds = 0;  // what the inertia, and the search for what it found missing, took [s]

  int count() const { return static_cast<int>(frequency.size()); }
  Eigen::VectorXd omega() const { return frequency * 6.283185307179586476925; }  // [rad/s]
};

}  // namespace tremula
