#include "tremula/render/sun_view.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <Eigen/Geometry>

namespace tremula {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr float pi = std::numbers::pi_v<float>;

// Points evenly over the unit disc.
Vector2f spiral(int i, int count, float turn) {
  const float radius = std::sqrt((static_cast<float>(i) + 0.5F) / static_cast<float>(count));
  const float angle = 2.39996323F * static_cast<float>(i) + 2 * pi * turn;
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

}  // namespace

SunView::SunView(std::span<const Vector3f> positions, std::span<const std::uint32_t> triangles,
                 const Vector3f& to_sun, int size)
    : to_sun_(to_sun), across_(to_sun.unitOrthogonal()), up_(to_sun.cross(across_)), size_(size) {
  Vector3f low = Vector3f::Constant(std::numeric_limits<float>::max());
  Vector3f high = -low;
  for (const std::uint32_t index : triangles) {
    const Vector3f p = in_view(positions[index]);
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  if (triangles.empty()) low = high = Vector3f::Zero();
  centre_ = (low + high) / 2;
  half_ = std::max({high.x() - low.x(), high.y() - low.y(), 1e-4F}) / 2 * 1.02F;
  std::vector<RasterVertex> vertices(positions.size());
  for (std::size_t v = 0; v < positions.size(); ++v) {
    const Vector3f p = (in_view(positions[v]) - centre_) / half_;
    vertices[v] = {p.x(), p.y(), 1, p.z() * half_};
  }
  buffer_ = rasterise(vertices, triangles, size, size, false, 0.5F);
}

float SunView::visible_share(const Vector3f& point, const Vector3f& normal, float turn) const {
  const float texel = 2 * half_ / static_cast<float>(size_);
  const Vector3f p = in_view(point + 1.5F * texel * normal) - centre_;
  const float depth = p.z() - 1.5F * texel;
  const float x = (p.x() / half_ + 1) / 2 * static_cast<float>(size_);
  const float y = (1 - p.y() / half_) / 2 * static_cast<float>(size_);

  constexpr float softness = 0.035F;  // half angle [rad]
  constexpr float widest = 14;        // [texels]
  constexpr int searches = 8, samples = 16;
  // The softness is that of the farthest thing in the way: stem and crown at once then blur alike
  // everywhere.
  float nearest_to_sun = depth;
  for (int i = 0; i < searches; ++i) {
    const Vector2f offset = spiral(i, searches, turn) * (0.6F * widest);
    nearest_to_sun = std::min(nearest_to_sun, blocker(x + offset.x(), y + offset.y()));
  }
  if (nearest_to_sun == depth) return 1;
  const float radius = std::clamp(softness * (depth - nearest_to_sun) / texel, 1.0F, widest);
  int lit = 0;
  for (int i = 0; i < samples; ++i) {
    const Vector2f offset = spiral(i, samples, turn) * radius;
    if (blocker(x + offset.x(), y + offset.y()) >= depth) ++lit;
  }
  return static_cast<float>(lit) / samples;
}

float SunView::blocker(float x, float y) const {
  if (!(x >= 0 && y >= 0 && x < static_cast<float>(size_) && y < static_cast<float>(size_))) {
    return std::numeric_limits<float>::infinity();
  }
  return -buffer_.nearness[static_cast<std::size_t>(y) * static_cast<std::size_t>(size_) +
                           static_cast<std::size_t>(x)];
}

}  // namespace tremula
