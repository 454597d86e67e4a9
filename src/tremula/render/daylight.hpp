// The light of the sun and of the sky, physically based: what atmosphere.hpp computes, in tables.
#pragma once

#include <memory>

#include <Eigen/Core>

namespace tremula {

struct DaylightSettings {
  double sun_azimuth = 0;                           // of the sun, from +x towards +y [rad]
  double sun_elevation = 0.7;                       // above the horizon, 0 … pi/2 [rad]
  double turbidity = 3;                             // 1 pure air … 10 hazy
  Eigen::Vector3f ground_albedo{0.2F, 0.2F, 0.2F};  // 0 … 1
};

// Light in linear sRGB whose luminance is in W weighed by the eye: 683 lm each. White is that of D65, so a
// bright noon is about white and a low sun orange; a picture's exposure takes out how bright it is
// (tone_map.hpp).
class Daylight {
 public:
  explicit Daylight(const DaylightSettings& settings);  // throws InputError for numbers out of range

  const Eigen::Vector3f& to_sun() const;          // unit
  float sun_cosine() const;                       // cosine of the sun's angular radius
  const Eigen::Vector3f& sun_irradiance() const;  // on a plane that faces it, at the ground, past the air
  const Eigen::Vector3f& sky_irradiance() const;  // of the sky without the sun, on the level ground
  Eigen::Vector3f level_irradiance() const;       // of both, on the level ground

  // Radiance from a direction (unit), without the disc of the sun; below the horizon what the ground sends
  // up, through haze.
  Eigen::Vector3f sky(const Eigen::Vector3f& direction) const;

  // A direction, brighter ones more often, from two numbers in [0, 1); and its density per steradian, nowhere
  // 0. A tenth of them is below the horizon.
  Eigen::Vector3f sample_sky(const Eigen::Vector2f& random, float& density) const;
  float sky_density(const Eigen::Vector3f& direction) const;

 private:
  struct Tables;
  std::shared_ptr<const Tables> tables_;
};

}  // namespace tremula
