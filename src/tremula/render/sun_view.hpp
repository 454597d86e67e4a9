// The sun's light on a surface: what it sees of a point, with soft shadows.
#pragma once

#include "tremula/render/raster.hpp"

#include <cstdint>
#include <span>

#include <Eigen/Core>

namespace tremula {

// What the sun sees: a parallel view along its rays.
class SunView {
 public:
  // `to_sun`: unit. `size`: of the view [pixels].
  SunView(std::span<const Eigen::Vector3f> positions, std::span<const std::uint32_t> triangles,
          const Eigen::Vector3f& to_sun, int size);

  // Share of the sun's disc that a point sees. The sun is taken larger than it is: soft shadows from high
  // twigs, sharp ones where a stem meets the ground. `turn` in [0, 1) turns the pattern of samples.
  float visible_share(const Eigen::Vector3f& point, const Eigen::Vector3f& normal, float turn) const;

 private:
  // x and y across the rays, z along them, away from the sun.
  Eigen::Vector3f in_view(const Eigen::Vector3f& p) const {
    return {p.dot(across_), p.dot(up_), -p.dot(to_sun_)};
  }
  float blocker(float x, float y) const;

  Eigen::Vector3f to_sun_, across_, up_;
  int size_;
  Eigen::Vector3f centre_ = Eigen::Vector3f::Zero();
  float half_ = 1;
  VisibilityBuffer buffer_;
};

}  // namespace tremula
