// The light of the sun and of the sky, physically based.
#pragma once

#include <memory>

#include <Eigen/Core>

namespace tremula {

struct DaylightSettings {
  double sun_azimuth = 0;      // of the sun, from +x towards +y [rad]
  double sun_elevation = 0.7;  // above the horizon [rad]
  double turbidity = 3;        // 1 pure air … 10 hazy
  Eigen::Vector3f ground_albedo{0.2F, 0.2F, 0.2F};
};

// Radiances are in W/(m^2 sr) within each of the three linear sRGB primaries' bands, up to one factor that
// all share; a picture's exposure takes it out.
class Daylight {
 public:
  explicit Daylight(const DaylightSettings& settings);  // throws InputError for numbers out of range

  const Eigen::Vector3f& to_sun() const;          // unit
  float sun_cosine() const;                       // cosine of the sun's angular radius
  const Eigen::Vector3f& sun_irradiance() const;  // on a plane that faces it, at the ground, past the air
  Eigen::Vector3f sky(
      const Eigen::Vector3f& direction) const;  // radiance, without the disc of the sun; below the
                                                // horizon what the ground sends up, through haze
  // A direction of the sky, brighter ones more often, from two numbers in [0, 1); and its density per
  // steradian.
  Eigen::Vector3f sample_sky(const Eigen::Vector2f& random, float& density) const;
  float sky_density(const Eigen::Vector3f& direction) const;

 private:
  struct Tables;
  std::shared_ptr<const Tables> tables_;
};

}  // namespace tremula
