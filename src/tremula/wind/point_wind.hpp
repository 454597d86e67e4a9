// The winds there are, and what the cascade asks of any of them: coefficients at the plant's points.
#pragma once

#include "tremula/numerics/time_axis.hpp"
#include "tremula/wind/field.hpp"
#include "tremula/wind/stam_wind.hpp"
#include "tremula/wind/turbulent_wind.hpp"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>
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
};

// A wind of your own: a function that gives it at any points (3 x N) [m], z above the ground, for any loop.
// What it returns is checked: sizes when it is made, and that every coefficient is finite when it is drawn.
struct OwnWind {
  std::function<PointWind(const TimeAxis& loop, const Eigen::Matrix3Xd& points)> at_points = {};
  double speed = 0;    // mean, for captions and reports [m/s]
  double heading = 0;  // as MeanWind::heading [degrees]
};

using Wind = std::variant<TurbulentWind, StamWind, GivenWind, OwnWind>;

// What any wind is like at its reference height.
struct ReferenceWind {
  double speed = 0;                      // mean [m/s]
  double height = 0;                     // [m]; 0 for an OwnWind, which has none
  double heading = 0;                    // where it blows to, as MeanWind::heading [degrees]
  std::optional<double> intensity = {};  // sigma_u / speed; none for gusts without unit or without mean wind
};

// Of a given field: its Taylor speed, and the deviation of the row nearest to its reference height. Throws
// InputError where there is no field.
ReferenceWind at_reference_height(const Wind& wind);

// points (3 x N) [m], z above the ground. Throws InputError for a wind that cannot be; so does the velocity
// of an OwnWind that gives numbers that are none.
PointWind wind_at_points(const Wind& wind, const TimeAxis& loop, const Eigen::Matrix3Xd& points);

}  // namespace tremula
