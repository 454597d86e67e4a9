#include "tremula/deformation/bent_space.hpp"

#include "tremula/numerics/quadrature.hpp"

#include <algorithm>
#include <cmath>

namespace tremula {
namespace {

using Eigen::Vector2d;

double angle_at(double tip_angle, double s) {
  const double rest = 1 - s;
  return tip_angle * (1 - rest * rest * rest);
}

}  // namespace

double tip_angle(double displacement_by_height) {
  return most_tip_angle * std::tanh(4.0 / 3 * displacement_by_height / most_tip_angle);
}

BentStation station_at(double tip, double s) {
  static const std::vector<QuadraturePoint> points = gauss_legendre(8);
  BentStation station{.along = 0, .up = 0, .angle = angle_at(tip, s)};
  for (const QuadraturePoint& point : points) {
    const double angle = angle_at(tip, s * point.position);
    station.along += s * point.weight * std::sin(angle);
    station.up += s * point.weight * std::cos(angle);
  }
  return station;
}

UnbentTable::UnbentTable() {
  for (int i = 0; i <= angles; ++i) {
    const double tip = most_tip_angle * i / angles, top = station_at(tip, 1).up;
    top_.push_back(static_cast<float>(top));
    double s = 0;
    for (int k = 0; k <= heights; ++k) {
      const double up = top * k / heights;
      for (int step = 0; step < 12; ++step) {  // Newton: up grows with s by the cosine of the angle
        const BentStation at = station_at(tip, s);
        s = std::clamp(s - (at.up - up) / std::cos(at.angle), 0.0, 1.0);
      }
      s_and_along_.emplace_back(static_cast<float>(s), static_cast<float>(station_at(tip, s).along));
    }
  }
}

bool UnbentTable::find(float tip, float up, UnbentStation& station) const {
  const float row = std::clamp(tip / static_cast<float>(most_tip_angle), 0.0F, 1.0F) * angles;
  const int i = std::min(static_cast<int>(row), angles - 1);
  const float share = row - static_cast<float>(i);
  const float top = (1 - share) * top_[index_of(i)] + share * top_[index_of(i + 1)];
  if (!(up >= 0) || up > top) return false;
  const float column = up / top * heights;
  const int k = std::min(static_cast<int>(column), heights - 1);
  const float across = column - static_cast<float>(k);
  const Eigen::Vector2f* low = &s_and_along_[index_of(i * (heights + 1) + k)];
  const Eigen::Vector2f* high = low + heights + 1;
  const Eigen::Vector2f found = (1 - share) * ((1 - across) * low[0] + across * low[1]) +
                                share * ((1 - across) * high[0] + across * high[1]);
  station = {found[0], found[1], tremula::angle_at(tip, found[0])};
  return true;
}

Bend bend_of(const Vector2d& displacement, double height) {
  const double far = displacement.norm();
  return {far > 0 ? Vector2d(displacement / far) : Vector2d::UnitX(), tip_angle(far / height)};
}

Vec3 bent_point(const Bend& bend, const Vec3& point, const Vector2d& foot, double held, double height,
                double tallness) {
  const double s = std::clamp((held >= 0 ? held : point.z()) / height, 0.0, 1.0);
  const BentStation at = station_at(bend.tip_angle, s);
  const Vec3 along(bend.along.x(), bend.along.y(), 0), axis(foot.x(), foot.y(), 0);
  const Vec3 off = point - axis - s * height * Vec3::UnitZ();
  // Turned about the horizontal across the bend.
  const double ahead = off.dot(along), sine = std::sin(at.angle), cosine = std::cos(at.angle);
  const double turned_ahead = cosine * ahead + sine * off.z(), up = cosine * off.z() - sine * ahead;
  const Vec3 beside = off - ahead * along - off.z() * Vec3::UnitZ();
  return axis + beside + (tallness * height * at.along + turned_ahead) * along +
         tallness * (height * at.up + up) * Vec3::UnitZ();
}

StrandPatch bend_strands(const StrandPatch& patch,
                         const std::function<Vector2d(const Vector2d& foot)>& displacement) {
  const auto height = static_cast<double>(patch.height);
  std::vector<Bend> bends;
  for (const Eigen::Vector2f& foot : patch.feet)
    bends.push_back(bend_of(displacement(foot.cast<double>()), height));
  StrandPatch bent = patch;
  for (Strand& strand : bent.strands) {
    const Vector2d foot = patch.feet[strand.plant].cast<double>();
    for (Eigen::Vector3f& point : strand.points) {
      point = bent_point(bends[strand.plant], point.cast<double>(), foot, static_cast<double>(strand.held),
                         height)
                  .cast<float>();
    }
  }
  return bent;
}

}  // namespace tremula
