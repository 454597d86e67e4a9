#include "tremula/raytrace/far_light.hpp"

#include "tremula/base/noise.hpp"
#include "tremula/render/patterns.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tremula {
namespace {

using Eigen::Vector3f;

constexpr float pi = std::numbers::pi_v<float>;

// What clear coastal water takes away and scatters [1/m]: red first (Jerlov's types between I and 1).
const Rgb water_extinction(0.25F, 0.055F, 0.042F);
constexpr float refractive_index = 1.33F;

}  // namespace

FarLight::FarLight(const TraceScene& scene) : extinction_(scene.haze.extinction), water_(scene.under_water) {
  if (scene.uniform_sky) {
    uniform_ = *scene.uniform_sky;
    horizon_.fill(uniform_);
    hazy_ = extinction_.maxCoeff() > 0;
    water_ = false;
    return;
  }
  daylight_ = std::make_shared<const Daylight>(scene.daylight);
  sun_ = daylight_->sun_irradiance();
  cosine_ = daylight_->sun_cosine();
  Vector3f to_sun = daylight_->to_sun();
  if (water_) {
    to_sun.head<2>() /= refractive_index;
    to_sun.z() = std::sqrt(std::max(0.0F, 1 - to_sun.head<2>().squaredNorm()));
    water_light_ = sun_.mean() * std::max(daylight_->to_sun().z(), 0.0F) / pi;
    sun_ = sun_.cwiseProduct(Rgb(0.40F, 0.80F, 0.82F));  // some metres down
    if (!(extinction_.maxCoeff() > 0)) extinction_ = water_extinction;
  }
  axes_ = LocalAxes(to_sun);
  hazy_ = extinction_.maxCoeff() > 0;
  for (int i = 0; i <= directions; ++i) {
    const float angle = 2 * pi * static_cast<float>(i) / directions - pi;
    constexpr float above = 0.003F;
    horizon_[static_cast<std::size_t>(i)] =
        daylight_->sky(Vector3f(std::cos(angle), std::sin(angle), above).normalized());
  }
}

Rgb FarLight::sky(const Vector3f& direction) const {
  if (water_) return 1.1F * water_light_ * water_behind(direction);
  return daylight_ ? Rgb(daylight_->sky(direction)) : uniform_;
}

Rgb FarLight::disc(const Vector3f& direction) const {
  // By the chord: floats hold a cosine near 1 to a hundredth of the disc.
  if (water_ || !has_sun() || (direction - axes_.z).squaredNorm() > 2 * (1 - cosine_)) return Rgb::Zero();
  return sun_ / (2 * pi * (1 - cosine_));
}

// Bright lines where waves bend light together, painted: about 1 on average.
Rgb FarLight::sun_at(const Vector3f& point) const {
  if (!water_) return sun_;
  const Eigen::Vector2f at =
      (point.head<2>() - point.z() / axes_.z.z() * axes_.z.head<2>()).cwiseMax(-1e6F).cwiseMin(1e6F);
  const float warp = noise(0.8F * at.x(), 0.8F * at.y(), 0, 51);
  const auto lines = [&](float per_metre, std::uint32_t seed) {
    const float ridge =
        1 - std::abs(2 * noise(per_metre * at.x() + 2 * warp, per_metre * at.y() - warp, 0, seed) - 1);
    return ridge * ridge * ridge * ridge;
  };
  return (0.35F + lines(1.7F, 52) + lines(2.9F, 53)) * sun_;
}

Rgb FarLight::passed(float distance) const { return (-distance * extinction_).array().exp().matrix(); }

Rgb FarLight::haze(const Vector3f& direction) const {
  if (water_) return sky(direction);
  const float place = (std::atan2(direction.y(), direction.x()) + pi) / (2 * pi) * directions;
  const int cell = std::clamp(static_cast<int>(place), 0, directions - 1);
  const float t = place - static_cast<float>(cell);
  return (1 - t) * horizon_[static_cast<std::size_t>(cell)] +
         t * horizon_[static_cast<std::size_t>(cell) + 1];
}

}  // namespace tremula
