#include "tremula/raytrace/grass.hpp"

#include "tremula/base/noise.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>

namespace tremula {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3f;

constexpr double side = 1.5;  // of a tile [m]
struct Density {
  int blades;
  float wider;
  double until;  // distance from the eye, in heights of grass of 4 to 16 cm
};
constexpr std::array<Density, 4> densities = {
    {{4200, 1, 75}, {2100, 1.4F, 175}, {1000, 2, 375}, {450, 2.8F, 750}}};

void add_blade(Surface& surface, const Vector3f& foot, float height, float width, std::uint32_t seed) {
  const auto random = [&](std::uint32_t of) { return hash_to_unit(hash(seed) + of); };
  const float turn = 2 * std::numbers::pi_v<float> * random(1), bend = 0.15F + 0.75F * random(2) * random(2);
  const float facing = turn + 1.2F * (random(3) - 0.5F);
  const Vector3f out(std::cos(turn), std::sin(turn), 0), across(-std::sin(facing), std::cos(facing), 0);
  constexpr std::array<float, 4> along = {0, 0.4F, 0.75F, 1}, widths = {0.8F, 1, 0.65F, 0};
  const auto first = static_cast<std::uint32_t>(surface.vertex_count());
  for (std::size_t i = 0; i < along.size(); ++i) {
    const float s = along[i];
    const Vector3f middle =
        foot + height * (s * (1 - 0.25F * bend * s) * Vector3f::UnitZ() + bend * s * s * out);
    const Vector3f tangent = (1 - 0.5F * bend * s) * Vector3f::UnitZ() + 2 * bend * s * out;
    for (int half = 0; half < (i + 1 < along.size() ? 2 : 1); ++half) {
      surface.position.emplace_back(middle + (half == 0 ? -0.5F : 0.5F) * width * widths[i] * across);
      surface.normal.push_back(across.cross(tangent).normalized());
      surface.texture.emplace_back(half == 0 ? 0.0F : 1.0F, s);
      surface.branch.push_back(0);
      surface.along.push_back(s);
    }
  }
  for (const std::uint32_t corner : {0U, 1U, 3U, 0U, 3U, 2U, 2U, 3U, 5U, 2U, 5U, 4U, 4U, 5U, 6U})
    surface.parts[0].triangles.push_back(first + corner);
}

Surface tile(double height, const Density& density) {
  Surface surface;
  surface.parts.push_back({.material = {.name = "blade", .roughness = 0.5F, .two_sided = true},
                           .triangles = {},
                           .pieces = {.first_vertex = 0, .size = 7, .count = 0}});
  for (int i = 0; i < density.blades; ++i) {
    const auto seed = static_cast<std::uint32_t>(i);
    // Evenly over the tile, yet in no rows.
    const auto spread = [&](double step, std::uint32_t of) {
      const double apart = side / std::sqrt(density.blades);
      return side * (std::fmod(0.5 + step * i, 1.0) - 0.5) +
             1.6 * apart * (static_cast<double>(hash_to_unit(7 * seed + of)) - 0.5);
    };
    const Vector3f foot(static_cast<float>(spread(0.7548776662, 5)),
                        static_cast<float>(spread(0.5698402910, 6)), 0);
    // Tufts are higher than what is between them.
    const float tuft = noise(3 * foot.x() + 10, 3 * foot.y() + 10, 0, 61);
    const float tall = static_cast<float>(height) * (0.35F + 0.4F * tuft + 0.4F * hash_to_unit(7 * seed + 3));
    add_blade(surface, foot, tall, density.wider * (0.003F + 0.003F * hash_to_unit(7 * seed + 4)), seed);
  }
  surface.parts[0].pieces.count = static_cast<std::uint32_t>(density.blades);
  return surface;
}

}  // namespace

std::vector<std::shared_ptr<const Surface>> grass_tiles(double height) {
  std::vector<std::shared_ptr<const Surface>> tiles;
  for (const Density& density : densities)
    tiles.push_back(std::make_shared<const Surface>(tile(height, density)));
  return tiles;
}

std::vector<LoopShape> grass_before(const Camera& camera, const GroundLook& ground,
                                    const std::vector<std::shared_ptr<const Surface>>& tiles) {
  std::vector<Loop> loops(tiles.size());
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    loops[i].facts.name = "grass";
    loops[i].rest = tiles[i];
    loops[i].instances.clear();
    loops[i].skin_at = [vertices = tiles[i]->vertex_count()](double) {
      return SurfaceDelta{std::vector<Vector3f>(vertices, Vector3f::Zero()),
                          std::vector<Vector3f>(vertices, Vector3f::Zero())};
    };
  }
  const double unit = std::clamp(ground.grass_height, 0.04, 0.16), most = densities.back().until * unit;
  const double above = camera.eye.z() - ground.height;
  const int reach = static_cast<int>(most / side) + 1;
  const auto column = std::llround(camera.eye.x() / side), row = std::llround(camera.eye.y() / side);
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) {
      const auto number =
          hash(static_cast<std::uint32_t>(column + dx)) + 0x9e3779b9U * static_cast<std::uint32_t>(row + dy);
      const Vec3 middle(side * static_cast<double>(column + dx), side * static_cast<double>(row + dy),
                        ground.height);
      if ((middle - camera.eye).dot(camera.forward) < -2 * side) continue;
      const auto is_sown = [&](const Eigen::Vector3d& circle) {
        return (middle.head<2>() - circle.head<2>()).norm() < circle.z();
      };
      if (std::ranges::any_of(ground.sown, is_sown)) continue;
      const double away = (middle - camera.eye).head<2>().norm();
      const double distance =
          std::hypot(away, above) * (0.85 + 0.3 * static_cast<double>(hash_to_unit(number)));
      for (std::size_t i = 0; i < tiles.size(); ++i) {
        if (distance > densities[i].until * unit) continue;
        const double quarter = std::numbers::pi / 2 * (hash(number + 1) % 4);
        loops[i].instances.push_back({.position = middle, .turn = quarter});
        break;
      }
    }
  }
  std::vector<LoopShape> shapes;
  for (Loop& loop : loops) {
    if (!loop.instances.empty()) shapes.push_back(shape_of(std::make_shared<const Loop>(std::move(loop)), 1));
  }
  return shapes;
}

}  // namespace tremula
