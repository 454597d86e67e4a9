// A wind, and what the cascade asks of it: coefficients at the points of a structure.
#pragma once

#include "tremula/numerics/time_axis.hpp"
#include "tremula/wind/field.hpp"
#include "tremula/wind/gust_statistics.hpp"
#include "tremula/wind/stam_wind.hpp"
#include "tremula/wind/turbulent_wind.hpp"
#include "tremula/wind/turbulent_wind_at_points.hpp"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace tremula {

// A field as it was measured or made elsewhere.
struct GivenWind {
  std::shared_ptr<const WindField> field;
  double heading = 0;  // where its x axis points to, as MeanWind::heading [degrees]
};

// A wind at fixed points and for one loop. Coefficients in the convention of StamWindAtPoints.
struct PointWind {
  Eigen::Matrix3Xd mean;  // (3 x N) [m/s]
  // (3 x N) [m/s] of a bin; another draw is another realisation. May be called from several threads.
  std::function<Eigen::Matrix3Xcd(int bin, int draw)> velocity;
  // How its power goes with the frequency [rad/s], in any unit; empty: white, or not known.
  std::function<double(double omega)> power = {};
  bool has_draws = true;       // false: what was given once, once
  bool has_slow_gusts = true;  // bin 0 is more than the mean
  std::vector<std::string> warnings = {};
  bool is_checked = false;  // its maker vouches for sizes and for numbers that are finite
};

// What a wind is like at its reference height: for captions, reports and advice.
struct ReferenceWind {
  double speed = 0;                      // mean [m/s]
  double height = 0;                     // [m]; 0: it has none
  double heading = 0;                    // where it blows to, as MeanWind::heading [degrees]
  std::optional<double> intensity = {};  // sigma_u / speed; none for gusts without unit or without mean wind
};

// Anything that blows: one of the winds of this library, or your own, from whatever says how it is at points.
struct Wind {
  ReferenceWind reference = {};
  // S_u at a height [m] and a frequency [Hz], [(m/s)^2/Hz]; empty: not known.
  std::function<double(double height, double frequency)> spectrum = {};
  // Mean and covariance at any place [m], z above the ground, as if loops had no end; empty: not known, and
  // taken from at_points where it is needed. Called by several threads.
  std::function<GustStatistics(const Vec3& place)> statistics = {};
  // At points (3 x P) [m], z above the ground, for a loop. What it returns is checked by wind_at_points.
  std::function<PointWind(const TimeAxis& loop, const Eigen::Matrix3Xd& points)> at_points = {};

  Wind() = default;
  // Throw InputError for a wind that cannot be. The speed of a given field is its Taylor speed, its intensity
  // that of the row nearest to its reference height. Who asks for points of the world is in the same gusts as
  // all others; Stam's wind and fields have one realisation for all points anyway.
  Wind(const TurbulentWind& wind, Realisation realisation = Realisation::of_points);
  Wind(const StamWind& wind);
  Wind(const GivenWind& wind);
};

// The same wind for what stands `across` [m] to the left of its heading, and counts its points from there.
Wind moved_across(Wind wind, double across);

// points (3 x P) [m], z above the ground. Throws InputError for a wind without at_points or that cannot be
// at these points, and for what it returns: sizes, and a mean, at once; coefficients and powers that are not
// finite when they are drawn.
PointWind wind_at_points(const Wind& wind, const TimeAxis& loop, const Eigen::Matrix3Xd& points);

// Mean and covariance at its points, of the loop itself: the sum over its bins. (P)
std::vector<GustStatistics> statistics_of(const PointWind& wind, const TimeAxis& loop);

}  // namespace tremula
