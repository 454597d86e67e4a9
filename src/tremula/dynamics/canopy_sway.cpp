#include "tremula/dynamics/canopy_sway.hpp"

#include <algorithm>
#include <cmath>

namespace tremula {

Eigen::Vector2d CanopySway::operator()(const Eigen::Vector2d& place, double time) const {
  const Vec3 at(place.x(), place.y(), field.ground + height);
  // The mean of the field is that of gusts, 2 d U^2; the mean wind pushes by d U^2.
  return (value_at(field, at, time) - 0.5 * mean_at(field, at.z())).head<2>();
}

CanopySway canopy_sway(const TravellingField& gusts, const CanopyResponse& response) {
  const double speed = gusts.mean.front().norm();
  const Impedance impedance =
      oscillator_impedance(response.frequency, response.damping_ratio, 2 * response.give * speed);
  CanopySway sway;
  sway.field =
      respond(gusts, {.along = impedance,
                      .across = impedance,
                      .spatial = {.kind = SpatialResponse::Kind::gaussian, .length = response.neighbours}});
  sway.field.ground = gusts.ground;
  sway.height = gusts.plane.heights.front();
  float most = 0;
  for (const auto& value : sway.field.values) most = std::max(most, std::hypot(value[0], value[1]));
  sway.most = static_cast<double>(most) + 0.5 * sway.field.mean.front().norm();
  return sway;
}

}  // namespace tremula
