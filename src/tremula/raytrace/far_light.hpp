// What shines on a scene from far away: sun and sky, water lit from above, or the same from everywhere.
#pragma once

#include "tremula/raytrace/raytrace.hpp"
#include "tremula/raytrace/sampling.hpp"
#include "tremula/render/sky.hpp"

#include <array>
#include <memory>

namespace tremula {

class FarLight {
 public:
  explicit FarLight(const TraceScene& scene);

  bool has_sun() const { return sun_.maxCoeff() > 0; }
  bool sampled() const { return daylight_ != nullptr && !water_; }  // worth asking for directions
  Rgb sky(const Eigen::Vector3f& direction) const;                  // radiance, without the sun's disc
  Rgb disc(const Eigen::Vector3f& direction) const;                 // radiance of the sun's disc
  Rgb sun_at(
      const Eigen::Vector3f& point) const;  // irradiance on a plane that faces it; waves gather it in water
  Eigen::Vector3f to_sun(const Eigen::Vector2f& random) const { return to_cone(random, axes_, cosine_); }
  Eigen::Vector3f sample_sky(const Eigen::Vector2f& random, float& density) const {
    return daylight_->sample_sky(random, density);
  }
  float sky_density(const Eigen::Vector3f& direction) const { return daylight_->sky_density(direction); }

  bool hazy() const { return hazy_; }
  // What is left of light after so much of the way [m], and what the air (or water) adds, seen in
  // `direction`.
  Rgb passed(float distance) const;
  Rgb haze(const Eigen::Vector3f& direction) const;

 private:
  std::shared_ptr<const Daylight> daylight_;  // none under a uniform sky
  Rgb uniform_ = Rgb::Zero(), sun_ = Rgb::Zero(), extinction_ = Rgb::Zero();
  LocalAxes axes_{Eigen::Vector3f::UnitZ()};  // of the sun
  float cosine_ = 1;
  float water_light_ = 0;
  bool water_ = false, hazy_ = false;
  static constexpr int directions = 128;
  std::array<Rgb, directions + 1> horizon_;  // of the sky, all around
};

}  // namespace tremula
