#include "tremula/dynamics/grass_response.hpp"

#include "tremula/base/check.hpp"
#include "tremula/dynamics/gust_average.hpp"
#include "tremula/dynamics/oscillators.hpp"
#include "tremula/wind/profile.hpp"

#include <cmath>
#include <numbers>
#include <string>

namespace tremula {

BladeResponse blade_response(const GrassSpecies& species, int kind_number, int frequency_class, double height,
                             const GustStatistics& wind, double air_density) {
  if (kind_number < 0 || index_of(kind_number) >= species.kinds.size())
    throw InputError("kind of blades", std::to_string(kind_number), "one of the species");
  if (frequency_class < 0 || frequency_class >= frequency_classes)
    throw InputError("frequency class of blades", std::to_string(frequency_class), "0 to 2");
  const BladeKind& kind = species.kinds[index_of(kind_number)];
  check_positive("frequency of the blades", kind.frequency, " Hz");
  check_positive("height of the grass", height, " m");
  check_positive("density of the air", air_density, " kg/m^3");
  if (!wind.mean.allFinite() || !wind.covariance.allFinite())
    throw InputError("wind on the grass", "no finite numbers", "finite numbers");
  const double longer = 1 + kind.length_spread * (2 * (frequency_class + 0.5) / frequency_classes - 1);
  BladeResponse blade;
  blade.frequency = kind.frequency / longer;
  blade.rod = {.length = height * kind.length * longer, .mass = kind.mass, .tip_mass = kind.tip_mass};
  blade.rod.bending_stiffness = stiffness_of_frequency(blade.rod, blade.frequency);
  const double on_metre = 0.5 * air_density * kind.drag_coefficient * kind.width;
  const double on_tip = 0.5 * air_density * kind.drag_area;
  const double mean_share = species.mean_share, gust_share = species.gust_share;
  const AverageForce drag =
      average_drag({.mean = mean_share * wind.mean, .covariance = gust_share * gust_share * wind.covariance});
  const auto per = [&](double size) { return RodDrag{on_metre * size, on_tip * size, species.canopy_decay}; };
  const double of_one = linear_tip_angle(blade.rod, per(1));
  blade.load = per(of_one > 0 ? 1 / of_one : 0);
  blade.lean = of_one * drag.mean.x();
  blade.along = of_one * gust_share * drag.per_velocity(0, 0);
  blade.across = of_one * gust_share * drag.per_velocity(1, 1);
  const double critical = 4 * std::numbers::pi * blade.frequency;
  const auto damping = [&](double per_velocity) {
    return kind.damping_ratio + damping_rate(blade.rod, per(per_velocity)) / critical;
  };
  blade.damping_along = damping(drag.per_velocity(0, 0));
  blade.damping_across = damping(drag.per_velocity(1, 1));
  return blade;
}

GustStatistics statistics_at(const TravellingField& gusts, double height) {
  const Vec3 along = heading_direction(gusts.heading), across(-along.y(), along.x(), 0);
  const Vec3 mean = mean_at(gusts, gusts.ground + height);
  GustStatistics statistics;
  statistics.mean = {mean.dot(along), mean.dot(across), mean.z()};
  const FieldPlane& plane = gusts.plane;
  Vec3 sum = Vec3::Zero();
  for (int column = 0; column < plane.columns; ++column) {
    const Vec3 place =
        (plane.first_column + column * plane.spacing) * across + (gusts.ground + height) * Vec3::UnitZ();
    for (int p = 0; p < gusts.loop.sample_count; ++p) {
      const Vec3 gust =
          local_value_at(gusts, place, gusts.loop.period * p / gusts.loop.sample_count).cast<double>();
      sum += gust;
      statistics.covariance += gust * gust.transpose();
    }
  }
  const double count = static_cast<double>(plane.columns) * gusts.loop.sample_count;
  statistics.mean += sum / count;
  statistics.covariance = statistics.covariance / count - (sum / count) * (sum / count).transpose();
  return statistics;
}

FieldResponse field_response(const BladeResponse& blade) {
  return {
      .along = oscillator_impedance(blade.frequency, blade.damping_along, blade.along, Transfer::sampled),
      .across = oscillator_impedance(blade.frequency, blade.damping_across, blade.across, Transfer::sampled),
      .up = {}};
}

Eigen::Matrix2Xd sway_in_time(const BladeResponse& blade, const TravellingField& gusts, const Vec3& place) {
  const double omega = 2 * std::numbers::pi * blade.frequency;
  OscillatorNetwork network;
  network.mass = Eigen::Vector2d::Ones();
  network.damping.resize(2, 2);
  network.coupling.resize(2, 2);
  network.damping.insert(0, 0) = 2 * blade.damping_along * omega;
  network.damping.insert(1, 1) = 2 * blade.damping_across * omega;
  network.coupling.insert(0, 0) = network.coupling.insert(1, 1) = omega * omega;
  const int samples = gusts.loop.sample_count;
  Eigen::MatrixXd forces(2, samples);
  for (int p = 0; p < samples; ++p) {
    const Eigen::Vector3f gust = local_value_at(gusts, place, gusts.loop.period * p / samples);
    forces.col(p) = omega * omega *
                    Eigen::Vector2d(blade.along * static_cast<double>(gust.x()),
                                    blade.across * static_cast<double>(gust.y()));
  }
  return repeat_in_time(network, gusts.loop.period, forces);
}

}  // namespace tremula
