#include "tremula/wind/point_wind.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/error.hpp"
#include "tremula/base/number_text.hpp"
#include "tremula/wind/field_at_points.hpp"
#include "tremula/wind/field_statistics.hpp"
#include "tremula/wind/synthesis.hpp"
#include "tremula/wind/wind_at_points.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

namespace tremula {
namespace {

Eigen::Matrix3Xd mean_velocity(const MeanWind& wind, const Eigen::Matrix3Xd& points) {
  Eigen::Matrix3Xd velocity(3, points.cols());
  for (Eigen::Index k = 0; k < points.cols(); ++k)
    velocity.col(k) = tremula::mean_velocity(wind, points(2, k));
  return velocity;
}

// Half way up the plant: where the spectrum's shape is taken that bends inside a bin.
double middle_height(const Eigen::Matrix3Xd& points) {
  return std::max(lowest_spectrum_height, 0.5 * (points.row(2).minCoeff() + points.row(2).maxCoeff()));
}

template <class AtPoints>
std::function<Eigen::Matrix3Xcd(int, int)> draws_of(const std::shared_ptr<const AtPoints>& wind) {
  return [wind](int bin, int draw) { return wind->velocity(bin, draw); };
}

PointWind at_points(const TurbulentWind& wind, const TimeAxis& loop, const Eigen::Matrix3Xd& points) {
  PointWind result{.mean = mean_velocity(wind.mean, points),
                   .velocity = draws_of(std::make_shared<const TurbulentWindAtPoints>(wind, loop, points))};
  const double height = middle_height(points), speed = mean_speed(wind.mean, height);
  if (speed > 0) {
    result.power = [model = wind.spectrum, height, speed](double omega) {
      return spectrum(model, omega / (2 * std::numbers::pi), height, speed)[0];
    };
  }
  return result;
}

PointWind at_points(const StamWind& wind, const TimeAxis& loop, const Eigen::Matrix3Xd& points) {
  PointWind result{.mean = mean_velocity(wind.mean, points),
                   .velocity = draws_of(std::make_shared<const StamWindAtPoints>(wind, loop, points))};
  const double height = middle_height(points), speed = mean_speed(wind.mean, height);
  if (wind.rows == StamRows::unit_variance && speed > 0) {
    result.power = [height, speed](double omega) {
      return simiu_scanlan_spectrum(omega / (2 * std::numbers::pi), height, speed, 1)[0];
    };
  }
  return result;
}

PointWind at_points(const GivenWind& wind, const TimeAxis& loop, const Eigen::Matrix3Xd& points) {
  if (!wind.field) throw InputError("wind", "no field", "one");
  const auto field = std::make_shared<const FieldAtPoints>(*wind.field, wind.heading, loop, points);
  PointWind result{.mean = field->mean_velocity(),
                   .velocity = [field](int bin, int) { return field->velocity(bin); },
                   .has_draws = false,
                   .has_slow_gusts = false};
  result.warnings = field->warnings();
  return result;
}

ReferenceWind reference_of(const MeanWind& mean) { return {mean.speed, mean.reference_height, mean.heading}; }

ReferenceWind reference_of(const TurbulentWind& wind) {
  ReferenceWind result = reference_of(wind.mean);
  if (wind.mean.speed > 0)
    result.intensity = std::sqrt(spectrum_variance(wind.spectrum)[0]) / wind.mean.speed;
  return result;
}

ReferenceWind reference_of(const StamWind& wind) {
  ReferenceWind result = reference_of(wind.mean);
  if (wind.mean.speed > 0 && wind.rows == StamRows::unit_variance)
    result.intensity = wind.turbulence_intensity;
  return result;
}

ReferenceWind reference_of(const GivenWind& wind) {
  if (!wind.field) throw InputError("wind", "no field", "one");
  const WindGrid& grid = wind.field->grid;
  ReferenceWind result{grid.mean_speed, grid.reference_height, wind.heading};
  const FieldStatistics moments = field_moments(*wind.field);
  const auto hub_row = static_cast<std::size_t>(hub_point(grid)[0]);
  if (grid.mean_speed > 0) result.intensity = moments.rows[hub_row].deviation[0] / grid.mean_speed;
  return result;
}

ReferenceWind reference_of(const OwnWind& wind) { return {wind.speed, 0, wind.heading}; }

void check_own(const char* what, Eigen::Index rows, Eigen::Index columns, bool finite, Eigen::Index points) {
  if (rows != 3 || columns != points) {
    throw InputError(std::string("own wind: ") + what,
                     std::to_string(rows) + " x " + std::to_string(columns) + " numbers",
                     "3 x " + std::to_string(points));
  }
  if (!finite) throw InputError(std::string("own wind: ") + what, "a number that is not finite", "m/s");
}

PointWind at_points(const OwnWind& wind, const TimeAxis& loop, const Eigen::Matrix3Xd& points) {
  if (!wind.at_points) throw InputError("own wind", "no function at_points", "one");
  if (!std::isfinite(wind.speed) || wind.speed < 0 || !std::isfinite(wind.heading)) {
    throw InputError("own wind",
                     "speed " + number_text(wind.speed) + ", heading " + number_text(wind.heading),
                     "0 m/s or more and an angle in degrees");
  }
  PointWind own = wind.at_points(loop, points);
  if (!own.velocity) throw InputError("own wind", "no function velocity", "one");
  const Eigen::Index count = points.cols();
  check_own("mean", own.mean.rows(), own.mean.cols(), own.mean.allFinite(), count);
  own.velocity = [velocity = std::move(own.velocity), count](int bin, int draw) {
    Eigen::Matrix3Xcd drawn = velocity(bin, draw);
    check_own("velocity", drawn.rows(), drawn.cols(), drawn.allFinite(), count);
    return drawn;
  };
  if (own.power) {
    own.power = [power = std::move(own.power)](double omega) {
      const double value = power(omega);
      if (!std::isfinite(value) || value <= 0)
        throw InputError("own wind: power", number_text(value), "a finite number above 0");
      return value;
    };
  }
  return own;
}

}  // namespace

ReferenceWind at_reference_height(const Wind& wind) {
  return std::visit([](const auto& kind) { return reference_of(kind); }, wind);
}

PointWind wind_at_points(const Wind& wind, const TimeAxis& loop, const Eigen::Matrix3Xd& points) {
  check_at_least("points in the wind", points.cols(), 1);
  if (!points.allFinite())
    throw InputError("points in the wind", "one that is not finite", "finite coordinates");
  return std::visit([&](const auto& kind) { return at_points(kind, loop, points); }, wind);
}

}  // namespace tremula
