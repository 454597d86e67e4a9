#include "tremula/deformation/impression_motion.hpp"

#include "tremula/base/error.hpp"
#include "tremula/wind/profile.hpp"

#include <algorithm>
#include <string>

namespace tremula {

using Eigen::Vector2f;
using Eigen::Vector4f;

FieldResponse tremble_response(double give) {
  constexpr double frequency = 2, damping = 0.15;
  return {.along = oscillator_impedance(frequency, damping, give),
          .across = oscillator_impedance(frequency, damping, give),
          .up = oscillator_impedance(frequency, damping, give),
          .spatial = {SpatialResponse::Kind::shinya_fournier, 1}};
}

ImpressionMotion impression_motion(const TrunkSway& sway, const TravellingField& gusts,
                                   const FieldResponse& tremble) {
  return {.heading = gusts.heading,
          .heights = sway.heights,
          .lean = sway.lean,
          .share = sway.share,
          .sway = std::make_shared<const TravellingField>(respond(gusts, sway.response)),
          .tremble = std::make_shared<const TravellingField>(respond(gusts, tremble))};
}

void check_motion(const ImpressionMotion& motion) {
  const std::size_t count = motion.heights.size();
  if (count != motion.lean.size() || count != motion.share.size() || count == 1)
    throw InputError("motion of an impressionist tree", std::to_string(count) + " heights",
                     "two or more, with a lean and a share each");
  if (motion.sway && count == 0)
    throw InputError("motion of an impressionist tree", "a sway without heights", "a trunk that sways");
  if (count > 0 && !(motion.heights.front() == 0 && motion.heights.back() > 0))
    throw InputError("motion of an impressionist tree", "heights that do not begin at 0", "a trunk");
}

TrunkCurve trunk_curve(const ImpressionMotion& motion) {
  TrunkCurve curve;
  if (motion.heights.empty()) return curve;
  constexpr int pieces = 16;
  curve.step = static_cast<float>(motion.heights.back() / pieces);
  for (int i = 0; i <= pieces; ++i) {
    const double height = motion.heights.back() * i / pieces;
    const auto above = std::ranges::lower_bound(motion.heights, height - 1e-9);
    const auto high = index_of(std::max<std::ptrdiff_t>(above - motion.heights.begin(), 1));
    const double t = (height - motion.heights[high - 1]) / (motion.heights[high] - motion.heights[high - 1]);
    const auto between = [&](const std::vector<Eigen::Vector2d>& of) {
      return Eigen::Vector2d((1 - t) * of[high - 1] + t * of[high]);
    };
    Eigen::Vector4d knot;
    knot << between(motion.lean), between(motion.share);
    curve.knots.push_back(knot.cast<float>());
  }
  for (std::size_t i = 0; i < curve.knots.size(); ++i) {
    const std::size_t low = i > 0 ? i - 1 : 0, high = std::min(i + 1, curve.knots.size() - 1);
    const float apart = static_cast<float>(high - low) * curve.step;
    curve.slopes.emplace_back((curve.knots[high] - curve.knots[low]) / apart);
  }
  curve.slopes.front().setZero();  // clamped
  return curve;
}

void TrunkCurve::at(float height, Vector4f& value, Vector4f& slope) const {
  const float place = std::max(height / step, 0.0F);
  const auto low = std::min(static_cast<std::size_t>(place), knots.size() - 1);
  const float t = place - static_cast<float>(low);
  if (low + 1 == knots.size()) {
    slope = slopes.back();
    value = knots.back() + t * step * slope;
    return;
  }
  const Vector4f rise = knots[low + 1] - knots[low];
  const Vector4f a = step * slopes[low], b = step * slopes[low + 1];
  value = knots[low] + t * (a + t * ((3 * rise - 2 * a - b) + t * (a + b - 2 * rise)));
  slope = (a + t * (2 * (3 * rise - 2 * a - b) + 3 * t * (a + b - 2 * rise))) / step;
}

Vector2f top_of(const ImpressionMotion& motion, const Instance& instance, double time) {
  if (!motion.sway) return Vector2f::Zero();
  return local_value_at(*motion.sway, instance.position, time + instance.time_shift).head<2>();
}

Vec3 place_in_wind(const ImpressionMotion& motion, const TrunkCurve& curve, const Instance& instance,
                   const Vec3& resting, double time) {
  Vec3 place = instance.rotation() * resting;
  if (curve.moves()) {
    Vector4f value, slope;
    curve.at(static_cast<float>(resting.z()), value, slope);
    const Eigen::Vector2d shift =
        (value.head<2>() + value.tail<2>().cwiseProduct(top_of(motion, instance, time))).cast<double>();
    const Vec3 along = heading_direction(motion.heading);
    place += shift.x() * along + shift.y() * Vec3(-along.y(), along.x(), 0);
  }
  return instance.position + instance.scale * place;
}

}  // namespace tremula
