// What a strain gauge on a plant reads: the wrench in one cross section, as a linear function of the motion.
#pragma once

#include "tremula/dynamics/gauge_reading.hpp"
#include "tremula/dynamics/lean.hpp"
#include "tremula/dynamics/motion.hpp"
#include "tremula/geometry/skeleton.hpp"

#include <string>
#include <vector>

#include <Eigen/Core>

namespace tremula {

// Where a gauge is to sit, in words:
//   base          the foot of the thickest stem at the ground
//   stem:1.3      1.3 m from there, by the path along the main stem
//   branch:12:0.5 half-way along branch 12, counted from 0
// Its name is what was asked for. Throws InputError for other words, and for places that are not on the
// plant.
Gauge place_gauge(const Skeleton& skeleton, const std::string& text);

// Of a lean with wrenches its part is what they sum up to beyond the section, what loads the gauge's own
// branch taken as even along it; of others it is the elastic answer to the displacement, as that of the
// coordinates always is: C^-1 of what the end of the member does against its start, the spring of a soft root
// being part of C, carried from the end to the section. Loads count there as they are lumped to the nodes.
// Throws InputError for a gauge that is not on the structure, and for a basis that is not of it.
GaugeReading read_gauge(const Lean& lean, const Basis& basis, const Gauge& gauge);

// The feet of the `count` branches whose surface is strained most, the worst first: by the mean and three and
// a half root mean squares of the strain along the fibre for which that is most. All, where there are fewer.
// Throws as read_gauge does.
std::vector<Gauge> most_strained(const Lean& lean, const Motion& motion, int count);

// What it reads at every sample of the loop. (M) each
struct GaugeSeries {
  std::string gauge;
  double period = 0;                    // T [s]
  Eigen::VectorXd bending_moment = {};  // its magnitude [N m]
  // Its parts that bend the beam along the wind, as far as that blows across the beam, and to the left of it,
  // seen from the end [N m]. Of a beam that points into the wind: upwards, and across that.
  Eigen::VectorXd along_wind = {}, across_wind = {};
  Eigen::VectorXd shear = {};    // its magnitude [N]
  Eigen::VectorXd axial = {};    // [N]
  Eigen::VectorXd torsion = {};  // [N m]
  Eigen::VectorXd strain = {};   // of the surface where it is pulled most, M r/(EI) + N/(EA)
};

// heading: where the wind blows to, from x towards y [degrees]. Throws InputError for a motion with other
// coordinates (check_motion).
GaugeSeries gauge_series(const GaugeReading& reading, const Motion& motion, double heading);

struct Extremes {
  double mean = 0;
  double rms = 0;   // about the mean
  double peak = 0;  // the sample farthest from zero
  // Of the samples, mean cube about the mean over rms^3: 0 for a Gaussian process, as linear drag has it;
  // above 0 where gusts pull harder than lulls let go. 0 where nothing moves.
  double skewness = 0;
  // Of a Gaussian process with this mean and spectrum: how often a second it crosses its mean upwards,
  // and by how many rms the largest of `duration` seconds exceeds the mean on the average.
  double crossing_rate = 0;  // nu, sigma'/(2 pi sigma), from the spectrum of the loop [Hz]
  double peak_factor = 0;    // g
  double expected_peak = 0;  // mean + g rms, or mean - g rms where the mean is below zero
};

// g = sqrt(2 ln(nu T)) + 0.5772/sqrt(2 ln(nu T)) (Davenport 1964, Proc. ICE 28, 187-196); below nu T = 1.33,
// where that would grow again, its least value, 1.52. series: the samples of one period [s] of a loop. Throws
// InputError for a series without samples or not finite, and for times that are not above 0.
Extremes extremes_of(const Eigen::VectorXd& series, double period, double duration = 600);

}  // namespace tremula
