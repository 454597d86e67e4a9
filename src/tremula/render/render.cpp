#include "tremula/render/render.hpp"

#include "tremula/base/color.hpp"
#include "tremula/base/error.hpp"
#include "tremula/base/noise.hpp"
#include "tremula/render/raster.hpp"
#include "tremula/render/shading.hpp"
#include "tremula/render/sky.hpp"
#include "tremula/render/sun_view.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include <tbb/parallel_for.h>
#include <Eigen/Geometry>

namespace tremula {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr float pi = std::numbers::pi_v<float>;

std::uint8_t srgb_byte(float linear) {
  return static_cast<std::uint8_t>(srgb_from_linear(std::clamp(linear, 0.0F, 1.0F)) * 255 + 0.5F);
}

void check(const Surface& surface, std::span<const Vector3f> positions, std::span<const Vector3f> normals,
           const Camera& camera, const RenderOptions& options) {
  const auto in_range = [](const char* name, double value, double low, double high) {
    if (value >= low && value <= high) return;
    throw InputError(std::string("render options: ") + name, std::to_string(value),
                     "a number from " + std::to_string(low) + " to " + std::to_string(high));
  };
  in_range("width", options.width, 1, 8192);
  in_range("height", options.height, 1, 8192);
  in_range("samples", options.samples, 1, 8);
  in_range("shadow_map", options.shadow_map, 16, 8192);
  in_range("sun_azimuth", options.sun_azimuth, -1000, 1000);
  in_range("sun_elevation", options.sun_elevation, 0.01, std::numbers::pi / 2);
  in_range("exposure", options.exposure, 1e-3, 1e3);
  if (options.ground) in_range("ground", *options.ground, -1e7, 1e7);
  const double aspect = static_cast<double>(options.width) / options.height;
  in_range("aspect of the camera", camera.aspect, 0.98 * aspect, 1.02 * aspect);

  if (!(camera.eye.cwiseAbs().maxCoeff() <= 1e8) ||
      !(camera.half_height > 1e-6 && camera.half_height < 1e3) || !camera.right.allFinite() ||
      !camera.up.allFinite() || !camera.forward.allFinite()) {
    throw InputError("camera", "a number that is not finite or far too large",
                     "one made by frame_extent or frame_points");
  }

  const std::size_t count = surface.vertex_count();
  if (positions.size() != count || normals.size() != count || surface.texture.size() != count) {
    throw InputError("surface to render",
                     std::to_string(positions.size()) + " positions, " + std::to_string(normals.size()) +
                         " normals and " + std::to_string(surface.texture.size()) + " texture coordinates",
                     std::to_string(count) + " each");
  }
  for (std::size_t v = 0; v < count; ++v) {
    const bool fine = positions[v].cwiseAbs().maxCoeff() <= 1e7F && positions[v].allFinite() &&
                      normals[v].allFinite() && surface.texture[v].allFinite();
    if (fine) continue;
    throw InputError("surface to render: vertex " + std::to_string(v),
                     "a number that is not finite or above 1e7 m", "finite numbers");
  }
  for (const SurfacePart& part : surface.parts) {
    if (part.triangles.size() % 3 != 0) {
      throw InputError("surface to render", std::to_string(part.triangles.size()) + " indices",
                       "3 per triangle");
    }
    for (const std::uint32_t index : part.triangles) {
      if (index >= count) {
        throw InputError("surface to render", "index " + std::to_string(index),
                         "one below " + std::to_string(count));
      }
    }
  }
}

// Where stems meet the ground: rings of tubes within the lowest hundredth of the plant.
std::vector<Stem> find_stems(const Surface& surface, float lowest, float highest) {
  constexpr std::size_t enough = 32;
  const float below = lowest + 0.01F * (highest - lowest);
  const auto is_piece = [&](std::size_t v) {
    return std::any_of(surface.parts.begin(), surface.parts.end(), [&](const SurfacePart& part) {
      return part.pieces.owns(static_cast<std::uint32_t>(v));
    });
  };
  std::vector<Stem> stems;
  std::size_t first = 0;
  const std::size_t count = surface.vertex_count();
  for (std::size_t v = 1; v <= count && stems.size() < enough; ++v) {
    if (v < count && surface.branch[v] == surface.branch[first] && surface.along[v] == surface.along[first] &&
        is_piece(v) == is_piece(first))
      continue;
    Stem stem;
    bool low = v - first > 2 && !is_piece(first);
    for (std::size_t i = first; i < v; ++i) {
      low = low && surface.position[i].z() <= below;
      stem.centre += surface.position[i].head<2>() / static_cast<float>(v - first);
    }
    for (std::size_t i = first; i < v; ++i) {
      stem.radius = std::max(stem.radius, (surface.position[i].head<2>() - stem.centre).norm());
    }
    if (low) stems.push_back(stem);
    first = v;
  }
  return stems;
}

struct Bounds {
  Vector3f low = Vector3f::Zero(), high = Vector3f::Zero();

  Vector3f middle() const { return (low + high) / 2; }
};

Bounds bounds_of(std::span<const Vector3f> positions) {
  Bounds bounds;
  if (!positions.empty()) bounds.low = bounds.high = positions[0];
  for (const Vector3f& p : positions) {
    bounds.low = bounds.low.cwiseMin(p);
    bounds.high = bounds.high.cwiseMax(p);
  }
  return bounds;
}

Drawn draw_list(const Surface& surface, std::span<const Vector3f> positions,
                std::span<const Vector3f> normals) {
  Drawn drawn{surface, positions, normals, {}, {}, {}};
  for (const SurfacePart& part : surface.parts) {
    drawn.triangles.insert(drawn.triangles.end(), part.triangles.begin(), part.triangles.end());
    drawn.part_ends.push_back(drawn.triangles.size() / 3);
    drawn.colors.emplace_back(part.material.color.unaryExpr(&linear_from_srgb<float>));
  }
  return drawn;
}

Eye eye_of(const Camera& camera, const RenderOptions& options) {
  const auto to_float = [](const Vec3& v) { return Vector3f(v.cast<float>()); };
  const auto half_height = static_cast<float>(camera.half_height);
  return {to_float(camera.eye),
          to_float(camera.right),
          to_float(camera.up),
          to_float(camera.forward),
          half_height,
          half_height * static_cast<float>(camera.aspect),
          2 * half_height / static_cast<float>(options.height)};
}

// The ground and the stems on it are those of the plant at rest: they do not move with it.
Ground ground_of(const Surface& surface, const Bounds& moved, const Camera& camera,
                 const RenderOptions& options) {
  const Bounds rest = bounds_of(surface.position);
  const float lowest = rest.low.z();
  Ground ground{.height = options.ground ? static_cast<float>(*options.ground) : lowest,
                .centre = Vector2f::Zero(),
                .radius = 0,
                .stems = find_stems(surface, lowest, rest.high.z()),
                .drawn = options.draw_ground};
  if (ground.stems.empty()) ground.centre = moved.middle().head<2>();
  for (const Stem& stem : ground.stems)
    ground.centre += stem.centre / static_cast<float>(ground.stems.size());
  const Vector3f size = moved.high - moved.low;
  const auto in_view =
      static_cast<float>(camera.half_height * (camera.eye - moved.middle().cast<double>()).norm());
  ground.radius = 7 * std::max({size.x(), size.y(), 0.8F * size.z(), in_view, 1e-3F});
  return ground;
}

Vector3f direction_of_sun(const Camera& camera, const RenderOptions& options) {
  const double heading = std::atan2(-camera.forward.y(), -camera.forward.x()) + options.sun_azimuth;
  const double level = std::cos(options.sun_elevation);
  return {static_cast<float>(level * std::cos(heading)), static_cast<float>(level * std::sin(heading)),
          static_cast<float>(std::sin(options.sun_elevation))};
}

// The colour of what hides the sky: of what is thin where the surface has such, else of its first part.
Rgb foliage_color(const Drawn& drawn) {
  const std::vector<SurfacePart>& parts = drawn.surface.parts;
  if (parts.empty()) return Rgb::Zero();
  const auto thin = std::find_if(parts.begin(), parts.end(),
                                 [](const SurfacePart& part) { return part.material.two_sided; });
  return drawn.colors[thin == parts.end() ? 0 : static_cast<std::size_t>(thin - parts.begin())];
}

Light light_of(const Drawn& drawn, const Bounds& moved, const Ground& ground, const Vector3f& to_sun,
               const RenderOptions& options) {
  constexpr int fog_cells = 36;  // along the longest edge
  FogGrid fog = make_fog(moved.low, moved.high, fog_cells);
  for (const SurfacePart& part : drawn.surface.parts) add_fog(fog, drawn.positions, part);
  const Rgb ground_radiance =
      ground_color.cwiseProduct(sun_light * to_sun.z() + pi * sky_horizon) / pi * 0.7F;
  return {to_sun, static_cast<float>(options.exposure),
          SunView(drawn.positions, drawn.triangles, to_sun, options.shadow_map),
          AmbientLight(fog, {sky_zenith, sky_horizon, ground_radiance, foliage_color(drawn) * 0.25F}),
          GroundLight(fog, ground.centre, ground.height, 2.2F / 7 * ground.radius)};
}

VisibilityBuffer see(const Drawn& drawn, const Camera& camera, const Vec3& middle,
                     const RenderOptions& options) {
  std::vector<RasterVertex> vertices(drawn.positions.size());
  const double near = std::max(1e-4 * (camera.eye - middle).norm(), 1e-6);
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    const Vec3 offset = drawn.positions[v].cast<double>() - camera.eye;
    const double depth = offset.dot(camera.forward);
    vertices[v] = {static_cast<float>(offset.dot(camera.right) / (camera.half_height * camera.aspect)),
                   static_cast<float>(offset.dot(camera.up) / camera.half_height), static_cast<float>(depth),
                   static_cast<float>(depth)};
  }
  return rasterise(vertices, drawn.triangles, options.width * options.samples,
                   options.height * options.samples, true, static_cast<float>(near));
}

// A triangle (or the background) within one pixel: how many samples see it, and the sums of their places.
struct Seen {
  std::uint32_t triangle;
  int count, x, y;
};

void find_seen(const VisibilityBuffer& view, int samples, int x, int y, std::vector<Seen>& seen) {
  seen.clear();
  for (int j = y * samples; j < (y + 1) * samples; ++j) {
    for (int i = x * samples; i < (x + 1) * samples; ++i) {
      const std::uint32_t triangle =
          view.triangle[static_cast<std::size_t>(j) * static_cast<std::size_t>(view.width) +
                        static_cast<std::size_t>(i)];
      auto same =
          std::find_if(seen.begin(), seen.end(), [&](const Seen& s) { return s.triangle == triangle; });
      if (same == seen.end()) same = seen.insert(seen.end(), {triangle, 0, 0, 0});
      ++same->count;
      same->x += i;
      same->y += j;
    }
  }
}

// Each triangle (and the background) is shaded once per pixel, in the middle of the samples that see it.
Image shade(const PictureScene& scene, const VisibilityBuffer& view, const RenderOptions& options,
            float water_scale) {
  Image image{options.width, options.height, {}};
  image.rgb.resize(3 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
  tbb::parallel_for(0, image.height, [&](int y) {
    std::vector<Seen> seen;
    for (int x = 0; x < image.width; ++x) {
      find_seen(view, options.samples, x, y, seen);
      const float turn =
          hash_to_unit(static_cast<std::uint32_t>(y) * 0x85ebca6bU + static_cast<std::uint32_t>(x));
      Rgb sum = Rgb::Zero();
      for (const Seen& s : seen) {
        const auto mean_of = [&](int total, int size) {
          return (static_cast<float>(total) / static_cast<float>(s.count) + 0.5F) / static_cast<float>(size);
        };
        const Vector3f direction = scene.eye.ray(mean_of(s.x, view.width), mean_of(s.y, view.height));
        Rgb color = s.triangle == no_triangle ? shade_ground(scene, direction, turn)
                                              : shade_triangle(scene, s.triangle, direction, turn);
        if (scene.under_water && s.triangle != no_triangle) {
          const Vector3f& place = scene.drawn.positions[scene.drawn.triangles[3 * std::size_t{s.triangle}]];
          color = through_water(color, direction, (place - scene.eye.position).norm(), water_scale);
        }
        sum += static_cast<float>(s.count) * color;
      }
      sum /= static_cast<float>(options.samples * options.samples);
      for (int c = 0; c < 3; ++c) image.pixel(x, y)[c] = srgb_byte(sum[c]);
    }
  });
  return image;
}

}  // namespace

Image render_surface(const Surface& surface, std::span<const Vector3f> positions,
                     std::span<const Vector3f> normals, const Camera& camera, const RenderOptions& options) {
  check(surface, positions, normals, camera, options);
  const Bounds moved = bounds_of(positions);
  Drawn drawn = draw_list(surface, positions, normals);
  Ground ground = ground_of(surface, moved, camera, options);
  Light light = light_of(drawn, moved, ground, direction_of_sun(camera, options), options);
  const Vec3 middle = moved.middle().cast<double>();
  const VisibilityBuffer view = see(drawn, camera, middle, options);
  return shade(
      {std::move(drawn), eye_of(camera, options), std::move(ground), std::move(light), options.under_water},
      view, options, static_cast<float>((camera.eye - middle).norm()));
}

}  // namespace tremula
