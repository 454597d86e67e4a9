#include "tremula/scene/gust_arrows.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/color.hpp"
#include "tremula/io/gust_plot.hpp"
#include "tremula/wind/profile.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include <tbb/parallel_for.h>

namespace tremula {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3f;

constexpr int sides = 8;
// A ring of an arrow: how far along it is, in lengths and in lengths of the head; how wide, in thicknesses of
// the shaft; and the normal, along the arrow and away from its axis.
struct Ring {
  float lengths, heads, wide, normal_along, normal_away;
};
constexpr float head_width = 3;
constexpr std::array<Ring, 8> rings = {{{0, 0, 0, -1, 0},
                                        {0, 0, 1, -1, 0},
                                        {0, 0, 1, 0, 1},
                                        {1, -1, 1, 0, 1},
                                        {1, -1, 1, -1, 0},
                                        {1, -1, head_width, -1, 0},
                                        {1, -1, head_width, 0.37F, 0.93F},
                                        {1, 0, 0, 0.37F, 0.93F}}};
constexpr std::size_t arrow_vertices = rings.size() * sides;

void check_lattice(const ArrowLattice& lattice) {
  const Vector2d size = lattice.high - lattice.low;
  if (!size.allFinite() || !(size.minCoeff() >= 0) || !lattice.low.allFinite() || !std::isfinite(lattice.z))
    throw InputError("field of the arrows", number_text(size.x()) + " m x " + number_text(size.y()) + " m",
                     "one from low to high");
  check_positive("spacing of the arrows", lattice.spacing, " m");
  check_positive("scale of the arrows", lattice.scale, " s");
  const double count = (size.x() / lattice.spacing + 1) * (size.y() / lattice.spacing + 1);
  if (!(count <= most_gust_arrows)) {
    throw InputError("arrows", number_text(std::floor(count)),
                     "at most " + number_text(most_gust_arrows) + ": a larger spacing");
  }
}

std::vector<Vec3> places_of(const ArrowLattice& lattice) {
  const Vector2d size = lattice.high - lattice.low;
  const Eigen::Array2d last = (size.array() / lattice.spacing + 1e-9).floor();
  const Vector2d first = lattice.low + 0.5 * (size - (lattice.spacing * last).matrix());
  std::vector<Vec3> places;
  for (int i = 0; i <= static_cast<int>(last.y()); ++i) {
    for (int j = 0; j <= static_cast<int>(last.x()); ++j)
      places.emplace_back(first.x() + j * lattice.spacing, first.y() + i * lattice.spacing, lattice.z);
  }
  return places;
}

struct Pose {
  std::vector<Vector3f> position, normal;
};

// An arrow that is shorter than its head would be is smaller altogether.
void add_arrow(const Vec3& middle, const Vec3& wind, const ArrowLattice& lattice, const Vec3& still,
               std::size_t first, Pose& pose) {
  const double speed = wind.norm(), length = lattice.scale * speed;
  const Vec3 along = speed > 0 ? Vec3(wind / speed) : still;
  const Vec3 level = std::abs(along.z()) < 0.9 ? Vec3::UnitZ() : Vec3::UnitX();
  const Vec3 side = level.cross(along).normalized(), up = along.cross(side);
  const double head = std::min(0.3 * lattice.spacing, 0.5 * length), thick = 0.11 * head;
  for (std::size_t r = 0; r < rings.size(); ++r) {
    const Ring& ring = rings[r];
    const Vec3 centre =
        middle +
        ((static_cast<double>(ring.lengths) - 0.5) * length + static_cast<double>(ring.heads) * head) * along;
    for (int s = 0; s < sides; ++s) {
      const double angle = 2 * std::numbers::pi * s / sides;
      const Vec3 away = std::cos(angle) * side + std::sin(angle) * up;
      const std::size_t v = first + r * sides + static_cast<std::size_t>(s);
      pose.position[v] = (centre + static_cast<double>(ring.wide) * thick * away).cast<float>();
      pose.normal[v] =
          (static_cast<double>(ring.normal_along) * along + static_cast<double>(ring.normal_away) * away)
              .normalized()
              .cast<float>();
    }
  }
}

struct Arrows {
  std::shared_ptr<const TravellingField> field;
  ArrowLattice lattice;
  std::vector<Vec3> places;

  Pose pose_at(double time) const {
    const Vec3 still = heading_direction(field->heading);
    Pose pose;
    pose.position.resize(places.size() * arrow_vertices);
    pose.normal.resize(pose.position.size());
    tbb::parallel_for(std::size_t{0}, places.size(), [&](std::size_t k) {
      add_arrow(places[k], value_at(*field, places[k], time), lattice, still, k * arrow_vertices, pose);
    });
    return pose;
  }
};

SurfacePart triangles_of(std::size_t arrow_count) {
  SurfacePart part{.material = {.name = "arrow", .color = {0.93F, 0.33F, 0.10F}}, .triangles = {}};
  for (std::size_t k = 0; k < arrow_count; ++k) {
    for (std::size_t r = 0; r + 1 < rings.size(); r += 2) {
      for (std::size_t s = 0; s < sides; ++s) {
        const std::size_t next = (s + 1) % sides, low = k * arrow_vertices + r * sides, high = low + sides;
        for (const std::size_t corner : {low + s, low + next, high + next, low + s, high + next, high + s})
          part.triangles.push_back(static_cast<std::uint32_t>(corner));
      }
    }
  }
  return part;
}

}  // namespace

std::size_t arrow_count(const ArrowLattice& lattice) {
  check_lattice(lattice);
  return places_of(lattice).size();
}

Loop gust_arrows(std::shared_ptr<const TravellingField> field, const ArrowLattice& lattice) {
  check_lattice(lattice);
  const auto arrows = std::make_shared<const Arrows>(Arrows{field, lattice, places_of(lattice)});
  Pose rest = arrows->pose_at(0);
  const std::size_t vertices = rest.position.size();
  auto surface = std::make_shared<Surface>();
  surface->position = std::move(rest.position);
  surface->normal = std::move(rest.normal);
  surface->texture.assign(vertices, Eigen::Vector2f::Zero());
  surface->branch.assign(vertices, 0);
  surface->along.assign(vertices, 0);
  surface->parts = {triangles_of(arrows->places.size())};

  Loop loop;
  loop.facts.name = "gusts";
  loop.facts.frames_per_second = field->loop.sample_count / field->loop.period;
  loop.facts.wind_speed = field->speed;
  loop.facts.heading = field->heading;
  loop.period = field->loop.period;
  loop.rest = surface;
  loop.coordinates.resize(field->loop.sample_count, 0);
  loop.skin_at = [arrows, surface](double time) {
    Pose pose = arrows->pose_at(time);
    SurfaceDelta delta{std::move(pose.position), std::move(pose.normal)};
    for (std::size_t v = 0; v < delta.position.size(); ++v) {
      delta.position[v] -= surface->position[v];
      delta.normal[v] -= surface->normal[v];
    }
    return delta;
  };
  return loop;
}

std::function<Eigen::Vector4f(const Eigen::Vector2f& place, double time)> gust_tint(
    std::shared_ptr<const TravellingField> field, const ArrowLattice& lattice) {
  check_lattice(lattice);
  const SpeedRange range = speeds_of(*field);
  // Still air leaves the ground as it is; gusts are as light as what grows, where a plot's colours would
  // shine.
  static constexpr float most_cover = 0.85F, darker = 0.6F;
  return [field, lattice, range](const Eigen::Vector2f& place, double time) -> Eigen::Vector4f {
    const Vector2d at = place.cast<double>();
    const double inside = std::min((at - lattice.low).minCoeff(), (lattice.high - at).minCoeff());
    if (inside <= 0) return Eigen::Vector4f::Zero();
    const Vec3 wind = value_at(*field, {at.x(), at.y(), lattice.z}, time);
    const double share =
        (wind.head<2>().norm() - range.slowest) / std::max(range.fastest - range.slowest, 1e-9);
    const Vector3f color = gust_color(share);
    const double edge = std::min(1.0, inside / (0.25 * lattice.spacing));  // where it fades
    Eigen::Vector4f tint(0, 0, 0, most_cover * static_cast<float>(edge * std::clamp(share, 0.0, 1.0)));
    for (int c = 0; c < 3; ++c) tint[c] = darker * linear_from_srgb(color[c]);
    return tint;
  };
}

}  // namespace tremula
