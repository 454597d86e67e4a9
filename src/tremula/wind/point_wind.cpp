#include "tremula/wind/point_wind.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/error.hpp"
#include "tremula/base/number_text.hpp"
#include "tremula/wind/field_at_points.hpp"
#include "tremula/wind/field_statistics.hpp"
#include "tremula/wind/synthesis.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include <tbb/parallel_for.h>

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

PointWind at_points(const TurbulentWind& wind, Realisation realisation, const TimeAxis& loop,
                    const Eigen::Matrix3Xd& points) {
  const auto drawn = std::make_shared<const TurbulentWindAtPoints>(
      wind, loop, points, WindAtPointsOptions{.realisation = realisation});
  PointWind result{.mean = mean_velocity(wind.mean, points), .velocity = draws_of(drawn), .is_checked = true};
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
                   .velocity = draws_of(std::make_shared<const StamWindAtPoints>(wind, loop, points)),
                   .is_checked = true};
  const double height = middle_height(points), speed = mean_speed(wind.mean, height);
  if (wind.rows == StamRows::unit_variance && speed > 0) {
    result.power = [height, speed](double omega) {
      return simiu_scanlan_spectrum(omega / (2 * std::numbers::pi), height, speed, 1)[0];
    };
  }
  return result;
}

PointWind at_points(const GivenWind& wind, const TimeAxis& loop, const Eigen::Matrix3Xd& points) {
  const auto field = std::make_shared<const FieldAtPoints>(*wind.field, wind.heading, loop, points);
  PointWind result{.mean = field->mean_velocity(),
                   .velocity = [field](int bin, int) { return field->velocity(bin); },
                   .has_draws = false,
                   .has_slow_gusts = false,
                   .is_checked = true};
  result.warnings = field->warnings();
  return result;
}

// From along, across and up into world axes.
GustStatistics statistics_at(const MeanWind& mean, const Vec3& variance, double covariance_uw,
                             const Vec3& place) {
  const Vec3 along = heading_direction(mean, place.z());
  Mat3 axes;
  axes << along, Vec3::UnitZ().cross(along), Vec3::UnitZ();
  Mat3 covariance = variance.asDiagonal();
  covariance(0, 2) = covariance(2, 0) = covariance_uw;
  return {mean_velocity(mean, place.z()), axes * covariance * axes.transpose()};
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

void check_drawn(const char* what, Eigen::Index rows, Eigen::Index columns, bool finite,
                 Eigen::Index points) {
  if (rows != 3 || columns != points) {
    throw InputError(std::string("wind: ") + what,
                     std::to_string(rows) + " x " + std::to_string(columns) + " numbers",
                     "3 x " + std::to_string(points));
  }
  if (!finite) throw InputError(std::string("wind: ") + what, "a number that is not finite", "m/s");
}

// A wind that somebody brings is checked now and whenever it is drawn.
void check_own(const ReferenceWind& reference, PointWind& wind, Eigen::Index count) {
  if (!std::isfinite(reference.speed) || reference.speed < 0 || !std::isfinite(reference.heading)) {
    throw InputError("wind",
                     "speed " + number_text(reference.speed) + ", heading " + number_text(reference.heading),
                     "0 m/s or more and an angle in degrees");
  }
  if (!wind.velocity) throw InputError("wind", "no function velocity", "one");
  check_drawn("mean", wind.mean.rows(), wind.mean.cols(), wind.mean.allFinite(), count);
  wind.velocity = [velocity = std::move(wind.velocity), count](int bin, int draw) {
    Eigen::Matrix3Xcd drawn = velocity(bin, draw);
    check_drawn("velocity", drawn.rows(), drawn.cols(), drawn.allFinite(), count);
    return drawn;
  };
  if (!wind.power) return;
  wind.power = [power = std::move(wind.power)](double omega) {
    const double value = power(omega);
    if (!std::isfinite(value) || value <= 0)
      throw InputError("wind: power", number_text(value), "a finite number above 0");
    return value;
  };
}

}  // namespace

Wind::Wind(const TurbulentWind& wind, Realisation realisation)
    : reference(reference_of(wind)),
      at_points([wind, realisation](const TimeAxis& loop, const Eigen::Matrix3Xd& points) {
        return tremula::at_points(wind, realisation, loop, points);
      }) {
  const Vec3 variance = spectrum_variance(wind.spectrum);
  statistics = [mean = wind.mean, variance, covariance = wind.covariance_uw](const Vec3& place) {
    return statistics_at(mean, mean_speed(mean, place.z()) > 0 ? variance : Vec3::Zero(), covariance, place);
  };
  if (variance[0] > 0)
    spectrum = [wind](double height, double frequency) { return spectrum_at(wind, height, frequency)[0]; };
}

Wind::Wind(const StamWind& wind)
    : reference(reference_of(wind)), at_points([wind](const TimeAxis& loop, const Eigen::Matrix3Xd& points) {
        return tremula::at_points(wind, loop, points);
      }) {
  const bool has_unit = wind.rows == StamRows::unit_variance;
  const double friction_velocity =
      has_unit ? friction_velocity_from_intensity(wind.turbulence_intensity, wind.mean.speed) : 0;
  const Vec3 variance = Vec3(6, 2.3684, 1.6728) * friction_velocity * friction_velocity;  // errata F2
  statistics = [mean = wind.mean, variance](const Vec3& place) {
    return statistics_at(mean, mean_speed(mean, place.z()) > 0 ? variance : Vec3::Zero(), 0, place);
  };
  if (!has_unit || !(wind.turbulence_intensity > 0)) return;
  spectrum = [wind](double height, double frequency) {
    const double speed = mean_speed(wind.mean, height);
    return speed > 0 ? simiu_scanlan_spectrum(frequency, height, speed, 1)[0] : 0;
  };
}

Wind::Wind(const GivenWind& wind)
    : reference(reference_of(wind)), at_points([wind](const TimeAxis& loop, const Eigen::Matrix3Xd& points) {
        return tremula::at_points(wind, loop, points);
      }) {}

Wind moved_across(Wind wind, double across) {
  if (!std::isfinite(across))
    throw InputError("place across the wind", number_text(across), "a length in metres");
  if (across == 0) return wind;
  const double heading = wind.reference.heading * std::numbers::pi / 180;
  const Vec3 offset(-across * std::sin(heading), across * std::cos(heading), 0);
  if (wind.statistics) {
    wind.statistics = [there = std::move(wind.statistics), offset](const Vec3& place) {
      return there(place + offset);
    };
  }
  wind.at_points = [there = std::move(wind.at_points), offset](const TimeAxis& loop,
                                                               const Eigen::Matrix3Xd& points) {
    return there(loop, points.colwise() + offset);
  };
  return wind;
}

PointWind wind_at_points(const Wind& wind, const TimeAxis& loop, const Eigen::Matrix3Xd& points) {
  check_at_least("points in the wind", points.cols(), 1);
  if (!points.allFinite())
    throw InputError("points in the wind", "one that is not finite", "finite coordinates");
  if (!wind.at_points) throw InputError("wind", "no function at_points", "one");
  PointWind result = wind.at_points(loop, points);
  if (result.is_checked) return result;
  check_own(wind.reference, result, points.cols());
  return result;
}

std::vector<GustStatistics> statistics_of(const PointWind& wind, const TimeAxis& loop) {
  constexpr int together = 64;
  const Eigen::Index count = wind.mean.cols();
  const int bins = loop.bin_count(), parts = (bins + together - 1) / together;
  // Sums of few bins each, added up in their order, whichever thread was first.
  std::vector<std::vector<Mat3>> sums(index_of(parts), std::vector<Mat3>(index_of(count), Mat3::Zero()));
  tbb::parallel_for(0, parts, [&](int part) {
    for (int bin = part * together; bin < std::min(bins, (part + 1) * together); ++bin) {
      if (bin == 0 && !wind.has_slow_gusts) continue;
      const Eigen::Matrix3Xcd velocity = wind.velocity(bin, 0);
      // Bin 0 is real in the loop, sqrt(2) Re of what is drawn; the last one stands for itself.
      const double weight = bin == 0 || 2 * bin == loop.sample_count ? 1 : 2;
      for (Eigen::Index p = 0; p < count; ++p) {
        sums[index_of(part)][index_of(p)] += weight * (velocity.col(p) * velocity.col(p).adjoint()).real();
      }
    }
  });
  std::vector<GustStatistics> result(index_of(count));
  for (Eigen::Index p = 0; p < count; ++p) {
    result[index_of(p)].mean = wind.mean.col(p);
    for (const auto& part : sums) result[index_of(p)].covariance += part[index_of(p)];
  }
  return result;
}

}  // namespace tremula
