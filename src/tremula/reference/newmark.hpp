// The slow way to the same loop: the full structure, integrated in time. What `respond` synthesises is
// compared with this; the cascade itself does not use it.
//
// Newmark's method with average acceleration (beta = 1/4, gamma = 1/2; Newmark 1959) solves
//
//   M u'' + C u' + K u = f(t)
//
// at t = 0, h, 2h, …, of second order in the step h, stable at any step, without damping of its own. What it
// gets wrong is time: a force of frequency omega is answered exactly as the structure answers the frequency
// (2/h) tan(omega h/2), and a free vibration of frequency omega swings with (2/h) atan(omega h/2): periods
// are (omega h)^2/12 longer. At a resonance of damping ratio zeta that makes a relative error of about
// (omega h)^2/(12 zeta), so for an error e take h = sqrt(12 zeta e)/omega at the highest resonance that
// matters. Modes far above are stiff and follow the force by their static share at any step; but what a start
// leaves in them hardly dies where omega h is large, so the state never repeats to the last digits.
#pragma once

#include "tremula/numerics/time_axis.hpp"
#include "tremula/reference/sparse_matrices.hpp"

#include <functional>

#include <Eigen/Core>
#include <Eigen/SparseCore>

namespace tremula {

struct TimeIntegration {
  double step = 0;     // h [s]
  int step_count = 0;  // the last instant is step_count * step
};

struct TimeState {
  Eigen::VectorXd displacement, velocity, acceleration;  // (n)
};

// f(t): (n), t [s].
using ForceAtTime = std::function<Eigen::VectorXd(double time)>;

// Is told every state, that at step 0 too.
using TimeObserver = std::function<void(int step, const TimeState& state)>;

// The state at the last instant. damping (n x n) need not be symmetric: drag is not. The acceleration of
// `initial` is not read: it follows from the equation at t = 0. Throws InputError for settings, sizes and
// numbers that are none; Error when a matrix is singular, the mass is not positive definite or the motion
// leaves the range of numbers (negative damping).
TimeState integrate_newmark(const SparseMatrices& matrices, const Eigen::SparseMatrix<double>& damping,
                            const ForceAtTime& force, const TimeState& initial,
                            const TimeIntegration& settings, const TimeObserver& observer = {});

struct PeriodicIntegration {
  int steps_per_sample = 32;  // h = T/(M steps_per_sample)
  double tolerance = 1e-4;    // of what is still missing, relative to the loop in the norm over all samples
  int largest_loop_count = 100;
};

struct PeriodicResponse {
  Eigen::MatrixXd displacement;  // (n x M), column p at t = p T/M
  int loop_count = 0;            // how many loops it took
  double missing = 0;            // about the most it differs from the loop after infinitely many, relative
};

// The motion under a force that repeats every axis.period, loop after loop until it repeats too. It starts at
// rest where the force of t = 0 holds the structure, so that the fast modes have little to ring with. Each
// loop changes less than the one before, by a factor r; what is missing after it is at most the change times
// r/(1 - r), the sum of all changes to come. Throws as integrate_newmark does, and Error when the stiffness
// is not positive definite or the largest number of loops is not enough.
PeriodicResponse periodic_response(const SparseMatrices& matrices, const Eigen::SparseMatrix<double>& damping,
                                   const ForceAtTime& force, const TimeAxis& axis,
                                   const PeriodicIntegration& settings = {});

}  // namespace tremula
