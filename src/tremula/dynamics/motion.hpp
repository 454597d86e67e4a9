// What the wind does to a structure during one loop: shapes that never change, and a small table.
#pragma once

#include "tremula/dynamics/basis.hpp"
#include "tremula/dynamics/gauge_reading.hpp"
#include "tremula/dynamics/pull.hpp"
#include "tremula/numerics/time_axis.hpp"

#include <optional>
#include <vector>

#include <Eigen/Core>

namespace tremula {

// What damps every coordinate but the lean's, c_r of damping.hpp [1/s]; the ratio is c_r/(2 omega_r). Of the
// medium the diagonal: it also couples modes.
struct DampingBySource {
  Eigen::VectorXd structure, medium;  // (c - 1)
};

// Coordinates of the basis at M equidistant instants: of a loop that closes (sample M would equal sample 0),
// or of a clip with a beginning and an end, which stands as in sample 0 before and as in the last one after
// it.
struct Motion {
  double period = 0;  // T [s]
  Basis basis;
  Eigen::MatrixXd coordinates;  // (M x c), row p at t = p T/M: 1 for the lean, else [m sqrt(kg)]
  // (rows) Strains of the lean of a tree that bends far (structure/bent_tree.hpp): modes and static shapes
  // are then small displacements about that shape, and poses bend by strains. Empty: displacements superpose
  // (S eq. 1).
  Eigen::VectorXd lean_strains = {};
  // Of a sheet: displacements tell all of where its nodes go, not what is across it alone (flapping.hpp).
  bool in_space = false;
  bool repeats = true;  // false: a clip; what goes on behind T then is the last sample

  DampingBySource damping = {};
  std::vector<GaugeReading> readings = {};       // of the gauges that were asked for
  std::vector<GaugeReading> most_strained = {};  // at the feet of the branches that are, the worst first
  Vec3 mean_drag = Vec3::Zero();                 // on the whole structure under the mean wind [N]
  std::optional<PullTest> pull = {};             // of what was pulled and let go

  int sample_count() const { return static_cast<int>(coordinates.rows()); }
};

// From the coefficients of all coordinates but the lean's, a row a bin (M/2+1 x (c - 1)).
Motion make_motion(Basis basis, const TimeAxis& loop, const Eigen::MatrixXcd& spectra);

// From samples of those coordinates (M x (c - 1)).
Motion make_motion(Basis basis, const TimeAxis& loop, const Eigen::MatrixXd& samples);

enum class Interpolation {
  linear,  // S section 7
  cubic,   // periodic Catmull-Rom: smooth velocity, same samples
};

// Throws InputError unless there is a sample and a period, and coordinates and basis belong together and are
// finite.
void check_motion(const Motion& motion);

// The coordinates (c) at any time [s], before 0 and after T too; exact at the samples. Throws InputError for
// a motion without samples or period, and for a time that is not finite.
Eigen::VectorXd coordinates_at(const Motion& motion, double time,
                               Interpolation interpolation = Interpolation::linear);

// The displacement of the structure (rows) at any time [s] (S section 3 and 6), linear in the coordinates: of
// a motion with lean_strains it is right to first order about the lean (deformation/bent_pose.hpp bends). The
// same bytes whether asked for alone or in a sequence. Throws as coordinates_at does.
Eigen::VectorXd displacement_at(const Motion& motion, double time,
                                Interpolation interpolation = Interpolation::linear);

}  // namespace tremula
