// How a structure answers to a wind that changes as a whole: modes about one shape of it, driven by the drag
// on every site at every instant, of the wind that the site then meets. Nothing of the drag is linearised: it
// goes with the square of the wind, what moves meets more or less of it, and what is turned another part. So
// the damping by the wind is that of the wind which blows just then.
#pragma once

#include "tremula/dynamics/lean.hpp"
#include "tremula/dynamics/loads.hpp"
#include "tremula/numerics/time_axis.hpp"
#include "tremula/wind/point_wind.hpp"

#include <functional>

#include <Eigen/Core>

namespace tremula {

// The structure as it stands in still air, with the loads that a wind has on it there but for their means:
// for a wind that is yet to come. Throws as find_lean does.
Lean lean_at_rest(const Structure& structure, const WindAt& wind, const LoadOptions& loads,
                  const LeanOptions& options = {});

// At the points of the sites, change(t) (mean + gusts(t)); gusts are linear between their samples.
struct ChangingWind {
  Eigen::Matrix3Xd mean;                    // (3 x P) [m/s]
  Eigen::MatrixXd gusts = {};               // (M x 3P) [m/s]; empty: none
  std::function<Mat3(double time)> change;  // [s]
};
// The gusts are those of one realisation, without what is slower than the axis is long.
ChangingWind changing_wind(const PointWind& wind, const TimeAxis& axis,
                           std::function<Mat3(double time)> change);

struct GustResponseOptions {
  LoadOptions loads = {};
  bool turning = true;      // the drag turns with the branch
  bool damps = true;        // what moves meets the wind at another speed
  bool from_rest = false;   // q = 0 at first; otherwise what stands still in the wind of the first instant
  double step_angle = 0.3;  // at most so much of omega, or of what the wind damps by, a step [rad]
};

// Coordinates (M x c) of moving shapes (rows x c) about the lean, mass-normalised, with their omega [rad/s]
// and structural damping c_r [1/s] (c each). The drag counts from the mean loads of the lean. Between steps,
// several to a sample where modes are fast, the modes are integrated exactly for forces linear in time
// (oscillators.hpp), with one look at the drag a step: of second order in the step. Throws InputError for
// loads as printed and sizes that do not agree, and Error where the first wind finds no equilibrium or the
// motion leaves what numbers hold.
Eigen::MatrixXd respond_to_gusts(const Lean& lean, Eigen::Ref<const Eigen::MatrixXd> moving,
                                 const Eigen::VectorXd& omega, const Eigen::VectorXd& damping,
                                 const ChangingWind& wind, const TimeAxis& axis,
                                 const GustResponseOptions& options,
                                 const std::function<void(double done)>& progress = {});

}  // namespace tremula
