#include "tremula/render/render.hpp"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "tremula/base/error.hpp"
#include "tremula/render/raster.hpp"
#include "tremula/render/sky.hpp"

namespace tremula {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr float pi = std::numbers::pi_v<float>;

// --- Small tools
// ---------------------------------------------------------------------------------------------

std::uint32_t hash(std::uint32_t x) {
  x = (x ^ (x >> 16)) * 0x7feb352dU;
  x = (x ^ (x >> 15)) * 0x846ca68bU;
  return x ^ (x >> 16);
}

float hash_to_unit(std::uint32_t x) { return static_cast<float>(hash(x) >> 8) * 0x1p-24F; }

float smooth_step(float low, float high, float x) {
  const float t = std::clamp((x - low) / (high - low), 0.0F, 1.0F);
  return t * t * (3 - 2 * t);
}

// Smooth noise in [0, 1] with one value per unit; `period` in x (0: none) so that it closes around a stem.
float noise(float x, float y, int period, std::uint32_t seed) {
  const float fx = std::floor(x), fy = std::floor(y);
  const float tx = smooth_step(0, 1, x - fx), ty = smooth_step(0, 1, y - fy);
  const auto value = [&](int dx, int dy) {
    int ix = static_cast<int>(fx) + dx;
    if (period > 0) ix = (ix % period + period) % period;
    const int iy = static_cast<int>(fy) + dy;
    return hash_to_unit(static_cast<std::uint32_t>(ix) * 0x9e3779b9U +
                        hash(static_cast<std::uint32_t>(iy) + seed));
  };
  return (1 - ty) * ((1 - tx) * value(0, 0) + tx * value(1, 0)) +
         ty * ((1 - tx) * value(0, 1) + tx * value(1, 1));
}

Rgb linear_from_srgb(const Vector3f& srgb) {
  return srgb.unaryExpr(
      [](float c) { return c <= 0.04045F ? c / 12.92F : std::pow((c + 0.055F) / 1.055F, 2.4F); });
}

std::uint8_t srgb_byte(float linear) {
  const float c = std::clamp(linear, 0.0F, 1.0F);
  const float srgb = c <= 0.0031308F ? 12.92F * c : 1.055F * std::pow(c, 1 / 2.4F) - 0.055F;
  return static_cast<std::uint8_t>(srgb * 255 + 0.5F);
}

// Straight in the shadows, a soft shoulder in the lights; 1 is reached at `white`.
Rgb tone(const Rgb& light) {
  constexpr float white = 4;
  return light.unaryExpr([](float c) { return c * (1 + c / (white * white)) / (1 + 0.55F * c) * 1.15F; });
}

// --- The sun
// -------------------------------------------------------------------------------------------------

// What the sun sees: a parallel view along its rays.
class SunView {
 public:
  SunView(std::span<const Vector3f> positions, std::span<const std::uint32_t> triangles,
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

  // Share of the sun's disc that a point sees. The sun is taken larger than it is: soft shadows from high
  // twigs, sharp ones where a stem meets the ground. `turn` in [0, 1) turns the pattern of samples.
  float visible_share(const Vector3f& point, const Vector3f& normal, float turn) const {
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

 private:
  // x and y across the rays, z along them, away from the sun.
  Vector3f in_view(const Vector3f& p) const { return {p.dot(across_), p.dot(up_), -p.dot(to_sun_)}; }

  // Points evenly over the unit disc.
  static Vector2f spiral(int i, int count, float turn) {
    const float radius = std::sqrt((static_cast<float>(i) + 0.5F) / static_cast<float>(count));
    const float angle = 2.39996323F * static_cast<float>(i) + 2 * pi * turn;
    return {radius * std::cos(angle), radius * std::sin(angle)};
  }

  float blocker(float x, float y) const {
    if (!(x >= 0 && y >= 0 && x < static_cast<float>(size_) && y < static_cast<float>(size_))) {
      return std::numeric_limits<float>::infinity();
    }
    return -buffer_.nearness[static_cast<std::size_t>(y) * static_cast<std::size_t>(size_) +
                             static_cast<std::size_t>(x)];
  }

  Vector3f to_sun_, across_, up_;
  int size_;
  Vector3f centre_ = Vector3f::Zero();
  float half_ = 1;
  VisibilityBuffer buffer_;
};

// --- The scene
// -----------------------------------------------------------------------------------------------

// Light and colours of a bright day with a little haze.
const Rgb sun_light = Rgb(1.0F, 0.90F, 0.74F) * 3.3F;
const Rgb sky_zenith = Rgb(0.40F, 0.52F, 0.74F) * 0.95F;
const Rgb sky_horizon = Rgb(0.86F, 0.90F, 0.94F) * 0.85F;
const Rgb ground_color(0.135F, 0.205F, 0.055F);

struct Stem {
  Vector2f centre = Vector2f::Zero();
  float radius = 0;
};

struct Scene {
  const Surface& surface;
  std::span<const Vector3f> positions, normals;
  std::vector<std::uint32_t> triangles;  // bark, then leaves
  std::size_t bark_count;                // triangles
  Rgb bark, leaf;
  Vector3f eye, right, up, forward;
  float half_height, half_width;  // of the picture at distance 1
  float pixel;                    // its size at distance 1
  Vector3f to_sun;
  float ground;     // height [m]
  Vector2f centre;  // of the disc of ground
  std::vector<Stem> stems;
  float disc;  // its radius [m]
  bool draw_ground;
  float exposure;
  const SunView& sun;
  const AmbientLight& ambient;
  const GroundLight& ground_light;

  Vector3f ray(float x, float y) const {  // x, y in the picture, 0 to 1
    return (forward + (2 * x - 1) * half_width * right + (1 - 2 * y) * half_height * up).normalized();
  }
};

// The sky behind the plant, pale at the horizon; below, what the disc of ground fades into.
Rgb backdrop(const Vector3f& direction) {
  const float height = direction.z();
  const Rgb horizon(0.86F, 0.91F, 0.92F);
  const Rgb high(0.24F, 0.46F, 0.78F);
  const Rgb low(0.72F, 0.80F, 0.72F);
  if (height >= 0) return horizon + (high - horizon) * (1 - std::exp(-3.5F * height));
  return horizon + (low - horizon) * (1 - std::exp(8.0F * height));
}

Rgb shade_ground(const Scene& scene, const Vector3f& direction, float turn) {
  const Rgb behind = backdrop(direction);
  if (!scene.draw_ground || direction.z() > -1e-4F || scene.eye.z() <= scene.ground) return behind;
  const float distance = (scene.ground - scene.eye.z()) / direction.z();
  const Vector3f point = scene.eye + distance * direction;
  const float from_centre = (point.head<2>() - scene.centre).norm() / scene.disc;
  const float presence = 1 / (1 + from_centre * from_centre * from_centre);
  if (presence <= 0.004F) return behind;

  // Short grass: patches and a grain at several scales, each faded out before it is finer than a pixel.
  const Vector2f place = point.head<2>() / scene.disc;
  const float footprint = distance * scene.pixel / scene.disc / std::max(-direction.z(), 0.02F);
  const auto layer = [&](float frequency, std::uint32_t seed) {
    const float fade = std::clamp(1.5F - frequency * footprint, 0.0F, 1.0F);
    return fade * (noise(place.x() * frequency, place.y() * frequency, 0, seed) - 0.5F);
  };
  const float patches = layer(13, 11) + 0.6F * layer(41, 12);
  const float grain = layer(160, 13) + layer(460, 14) + 0.8F * layer(1300, 15);
  const Rgb albedo = ground_color.cwiseProduct(Rgb(1 + 0.3F * patches, 1 + 0.1F * patches, 1)) *
                     (1 + 0.2F * patches + 0.22F * grain);

  const float sun = scene.sun.visible_share(point, Vector3f::UnitZ(), turn) * scene.to_sun.z();
  float open = scene.ground_light.sky_share(point.x(), point.y());
  // The fog is too coarse for the foot of a stem. A tall cylinder hides this share of the sky in all
  // directions.
  for (const Stem& stem : scene.stems) {
    const float away = std::max((point.head<2>() - stem.centre).norm(), stem.radius);
    open *= 1 - std::asin(stem.radius / std::max(away, 1e-6F)) / pi;
  }
  const Rgb sky = (0.4F * sky_zenith + 0.6F * sky_horizon) * pi * open;
  const Rgb light = albedo.cwiseProduct(sun * sun_light + sky) / pi * (0.75F * scene.exposure);
  return behind + presence * (tone(light) - behind);
}

// Bark, by how high it stands out and how bright it is there, both around 0. Dark bark has furrows along the
// stem, pale bark short marks across it. Each scale is faded out before it is finer than a pixel.
struct Bark {
  float height;
  float shade;
};

Bark bark_at(const Vector2f& uv, float footprint, float paleness) {
  const auto fade = [&](float frequency) { return std::clamp(1.5F - 2 * frequency * footprint, 0.0F, 1.0F); };
  const float warp = noise(uv.x() * 6, uv.y() * 4, 6, 1) - 0.5F;
  const auto furrows = [&](float around, float along, std::uint32_t seed) {
    const float n = noise(uv.x() * around + 1.5F * warp, uv.y() * along, static_cast<int>(around), seed);
    return smooth_step(0, 0.55F, std::abs(2 * n - 1)) - 0.6F;
  };
  const float rough = fade(12) * furrows(12, 3.2F, 2) + 0.45F * fade(26) * furrows(26, 9, 3);
  const float grain = fade(60) * (noise(uv.x() * 60, uv.y() * 30, 60, 4) - 0.5F);
  const float marks = fade(26) * smooth_step(0.66F, 0.8F, noise(uv.x() * 5, uv.y() * 26, 5, 5)) +
                      fade(9) * smooth_step(0.74F, 0.8F, noise(uv.x() * 3, uv.y() * 9, 3, 6));
  const float rugged = 1 - paleness;
  return {rugged * rough + 0.3F * grain, rugged * (0.42F * rough + 0.3F * grain) - 0.7F * paleness * marks};
}

// `twig`: 1 for the twigs of trees with pale bark, which are brown.
Rgb bark_albedo(const Scene& scene, const Vector2f& uv, float footprint, float shade, float twig) {
  const float fade = std::clamp(1.5F - 6 * footprint, 0.0F, 1.0F);
  const float lichen = fade * smooth_step(0.5F, 0.9F, noise(uv.x() * 3, uv.y() * 1.1F, 3, 7));
  const Rgb color = scene.bark + 0.3F * lichen * (Rgb(0.20F, 0.22F, 0.15F) - scene.bark);
  const Rgb brown = color.cwiseMin(Rgb(0.15F, 0.10F, 0.075F));
  return (color + twig * (brown - color)) * std::max(1 + shade, 0.2F);
}

// One triangle as seen through one spot of the picture.
Rgb shade_triangle(const Scene& scene, std::uint32_t triangle, const Vector3f& direction, float turn) {
  const std::uint32_t* corner = &scene.triangles[3 * std::size_t{triangle}];
  const Vector3f& a = scene.positions[corner[0]];
  const Vector3f ab = scene.positions[corner[1]] - a;
  const Vector3f ac = scene.positions[corner[2]] - a;
  const Vector3f plane = ab.cross(ac);

  // Where the ray meets the plane, kept inside: the spot is the middle of several samples.
  const Vector3f p = direction.cross(ac);
  const float determinant = ab.dot(p);
  float s = 1.0F / 3, t = 1.0F / 3;
  if (std::abs(determinant) > 1e-20F) {
    const Vector3f from = scene.eye - a;
    s = std::clamp(from.dot(p) / determinant, 0.0F, 1.0F);
    t = std::clamp(direction.dot(from.cross(ab)) / determinant, 0.0F, 1.0F);
    if (s + t > 1) {
      const float sum = s + t;
      s /= sum;
      t /= sum;
    }
  }
  const Vector3f point = a + s * ab + t * ac;
  const auto blend = [&](const auto& values) {
    return ((1 - s - t) * values[corner[0]] + s * values[corner[1]] + t * values[corner[2]]).eval();
  };
  Vector3f normal = blend(scene.normals);
  const float length = normal.norm();
  normal = length > 1e-6F ? Vector3f(normal / length) : Vector3f(plane.normalized());
  const Vector2f uv = blend(scene.surface.texture).cwiseMax(-1e6F).cwiseMin(1e6F);  // noise counts in int
  const float distance = (point - scene.eye).norm();
  const bool seen_from_behind = plane.dot(direction) > 0;
  if (seen_from_behind && triangle >= scene.bark_count) normal = -normal;

  const float towards_sun = normal.dot(scene.to_sun);
  const float sun = scene.sun.visible_share(point, towards_sun >= 0 ? normal : Vector3f(-normal), turn);
  if (triangle < scene.bark_count) {
    const Vector2f uv_ab = scene.surface.texture[corner[1]] - scene.surface.texture[corner[0]];
    const Vector2f uv_ac = scene.surface.texture[corner[2]] - scene.surface.texture[corner[0]];
    const float per_metre = (uv_ab.norm() + uv_ac.norm()) / std::max(ab.norm() + ac.norm(), 1e-9F);
    const float footprint = std::min(distance * scene.pixel * per_metre, 100.0F);
    const float radius = 1 / (2 * pi * std::max(per_metre, 1e-6F));
    const float stem = smooth_step(0.005F, 0.02F, radius);
    const float white =
        smooth_step(0.25F, 0.5F, scene.bark.mean()) *
        smooth_step(0.5F, 0.7F, scene.bark.minCoeff() / std::max(scene.bark.maxCoeff(), 1e-6F));
    const float paleness = white * stem;
    const Bark bark = bark_at(uv, footprint, paleness);
    // The relief tilts the normal: directions of growing u and v from the triangle, heights a step farther.
    const float turn_uv = uv_ab.x() * uv_ac.y() - uv_ab.y() * uv_ac.x();
    if (std::abs(turn_uv) > 1e-12F) {
      constexpr float relief = 0.012F;  // [circumferences]
      const float step = std::max(0.004F, 0.5F * footprint);
      const Vector3f along_u = ((uv_ac.y() * ab - uv_ab.y() * ac) / turn_uv).normalized();
      const Vector3f along_v = ((uv_ab.x() * ac - uv_ac.x() * ab) / turn_uv).normalized();
      const float rise_u = bark_at(uv + Vector2f(step, 0), footprint, paleness).height - bark.height;
      const float rise_v = bark_at(uv + Vector2f(0, step), footprint, paleness).height - bark.height;
      const Vector3f tilted = normal - relief / step * (rise_u * along_u + rise_v * along_v);
      if (tilted.norm() > 1e-3F) normal = tilted.normalized();
    }
    const Rgb albedo = bark_albedo(scene, uv, footprint, bark.shade, white * (1 - stem));
    const Rgb sky = scene.ambient.irradiance(point, normal);
    return tone(albedo.cwiseProduct(std::max(normal.dot(scene.to_sun), 0.0F) * sun * sun_light + sky) / pi *
                scene.exposure);
  }

  // Leaves: no two alike, paler below; light goes through them and turns yellower.
  const std::uint32_t leaf = (corner[0] - scene.surface.first_leaf_vertex) / leaf_vertices;
  const float bright = 0.78F + 0.44F * hash_to_unit(2 * leaf);
  const float yellow = hash_to_unit(2 * leaf + 1) - 0.5F;
  Rgb albedo =
      scene.leaf.cwiseProduct(Rgb(1 + 0.55F * yellow, 1 + 0.1F * yellow, 1 - 0.5F * yellow)) * bright;
  const float rib = std::max(0.0F, 1 - std::abs(uv.x() - 0.5F) * 14);
  albedo *= 1 + 0.35F * rib;
  if (seen_from_behind) albedo = 0.8F * albedo + Rgb::Constant(0.25F * albedo.mean());
  const Rgb through = albedo.cwiseProduct(Rgb(1.25F, 1.2F, 0.35F)) * 0.75F;

  const Rgb lit = albedo * std::max(towards_sun, 0.0F) + through * std::max(-towards_sun, 0.0F);
  const Rgb sky = albedo.cwiseProduct(scene.ambient.irradiance(point, normal)) +
                  0.5F * through.cwiseProduct(scene.ambient.irradiance(point, -normal));
  const Vector3f half_way = (scene.to_sun - direction).normalized();
  const float gloss = towards_sun > 0 ? 0.055F * std::pow(std::max(normal.dot(half_way), 0.0F), 18.0F) : 0;
  return tone(((lit.cwiseProduct(sun * sun_light) + sky) / pi + gloss * sun * sun_light) * scene.exposure);
}

// Where stems meet the ground: rings of bark within the lowest hundredth of the plant.
std::vector<Stem> find_stems(const Surface& surface, float lowest, float highest) {
  constexpr std::size_t enough = 32;
  const float below = lowest + 0.01F * (highest - lowest);
  std::vector<Stem> stems;
  std::size_t first = 0;
  const std::size_t count = std::min<std::size_t>(surface.first_leaf_vertex, surface.vertex_count());
  for (std::size_t v = 1; v <= count && stems.size() < enough; ++v) {
    if (v < count && surface.branch[v] == surface.branch[first] && surface.along[v] == surface.along[first])
      continue;
    Stem stem;
    bool low = v - first > 2;
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
  for (const auto* triangles : {&surface.bark_triangles, &surface.leaf_triangles}) {
    if (triangles->size() % 3 != 0) {
      throw InputError("surface to render", std::to_string(triangles->size()) + " indices", "3 per triangle");
    }
    for (const std::uint32_t index : *triangles) {
      if (index >= count) {
        throw InputError("surface to render", "index " + std::to_string(index),
                         "one below " + std::to_string(count));
      }
    }
  }
}

}  // namespace

Image render_surface(const Surface& surface, std::span<const Vector3f> positions,
                     std::span<const Vector3f> normals, const Camera& camera, const RenderOptions& options) {
  check(surface, positions, normals, camera, options);
  std::vector<std::uint32_t> triangles = surface.bark_triangles;
  triangles.insert(triangles.end(), surface.leaf_triangles.begin(), surface.leaf_triangles.end());

  // Where things are. The ground and the stems on it are those of the plant at rest: they do not move with
  // it.
  Vector3f low = Vector3f::Zero(), high = Vector3f::Zero();
  float lowest = 0, highest = 0;
  if (!positions.empty()) {
    low = high = positions[0];
    lowest = highest = surface.position[0].z();
  }
  for (const Vector3f& p : positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  for (const Vector3f& p : surface.position) {
    lowest = std::min(lowest, p.z());
    highest = std::max(highest, p.z());
  }
  std::vector<Stem> stems = find_stems(surface, lowest, highest);
  Vector2f centre = stems.empty() ? Vector2f((low + high).head<2>() / 2) : Vector2f(Vector2f::Zero());
  for (const Stem& stem : stems) centre += stem.centre / static_cast<float>(stems.size());
  const float ground = options.ground ? static_cast<float>(*options.ground) : lowest;
  const Vector3f extent = high - low;
  const Vec3 middle = ((low + high) / 2).cast<double>();
  const auto in_view = static_cast<float>(camera.half_height * (camera.eye - middle).norm());
  const float reach = std::max({extent.x(), extent.y(), 0.8F * extent.z(), in_view, 1e-3F});

  // Light.
  const double heading = std::atan2(-camera.forward.y(), -camera.forward.x()) + options.sun_azimuth;
  const double level = std::cos(options.sun_elevation);
  const Vector3f to_sun(static_cast<float>(level * std::cos(heading)),
                        static_cast<float>(level * std::sin(heading)),
                        static_cast<float>(std::sin(options.sun_elevation)));
  const SunView sun(positions, triangles, to_sun, options.shadow_map);
  const FogGrid fog = make_fog(positions, surface.bark_triangles, surface.leaf_triangles, low, high, 36);
  const Rgb leaf = linear_from_srgb(surface.leaf_color);
  const Rgb ground_radiance =
      ground_color.cwiseProduct(sun_light * to_sun.z() + pi * sky_horizon) / pi * 0.7F;
  const AmbientLight ambient(fog, {sky_zenith, sky_horizon, ground_radiance, leaf * 0.25F});
  const float disc = 7 * reach;
  const GroundLight ground_light(fog, centre, ground, 2.2F * reach);

  const auto to_float = [](const Vec3& v) { return Vector3f(v.cast<float>()); };
  const auto half_height = static_cast<float>(camera.half_height);
  const Scene scene{surface,
                    positions,
                    normals,
                    std::move(triangles),
                    surface.bark_triangles.size() / 3,
                    linear_from_srgb(surface.bark_color),
                    leaf,
                    to_float(camera.eye),
                    to_float(camera.right),
                    to_float(camera.up),
                    to_float(camera.forward),
                    half_height,
                    half_height * static_cast<float>(camera.aspect),
                    2 * half_height / static_cast<float>(options.height),
                    to_sun,
                    ground,
                    centre,
                    std::move(stems),
                    disc,
                    options.draw_ground,
                    static_cast<float>(options.exposure),
                    sun,
                    ambient,
                    ground_light};

  // What is seen where.
  std::vector<RasterVertex> vertices(positions.size());
  const double near = std::max(1e-4 * (camera.eye - middle).norm(), 1e-6);
  for (std::size_t v = 0; v < positions.size(); ++v) {
    const Vec3 offset = positions[v].cast<double>() - camera.eye;
    const double depth = offset.dot(camera.forward);
    vertices[v] = {static_cast<float>(offset.dot(camera.right) / (camera.half_height * camera.aspect)),
                   static_cast<float>(offset.dot(camera.up) / camera.half_height), static_cast<float>(depth),
                   static_cast<float>(depth)};
  }
  const int samples = options.samples;
  const VisibilityBuffer view = rasterise(vertices, scene.triangles, options.width * samples,
                                          options.height * samples, true, static_cast<float>(near));

  // Each triangle (and the background) is shaded once per pixel, in the middle of the samples that see it.
  Image image{options.width, options.height, {}};
  image.rgb.resize(3 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
  tbb::parallel_for(0, image.height, [&](int y) {
    struct Seen {
      std::uint32_t triangle;
      int count, x, y;
    };
    std::vector<Seen> seen;
    for (int x = 0; x < image.width; ++x) {
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
      const float turn =
          hash_to_unit(static_cast<std::uint32_t>(y) * 0x85ebca6bU + static_cast<std::uint32_t>(x));
      Rgb sum = Rgb::Zero();
      for (const Seen& s : seen) {
        const auto mean_of = [&](int total, int size) {
          return (static_cast<float>(total) / static_cast<float>(s.count) + 0.5F) / static_cast<float>(size);
        };
        const Vector3f direction = scene.ray(mean_of(s.x, view.width), mean_of(s.y, view.height));
        const Rgb color = s.triangle == no_triangle ? shade_ground(scene, direction, turn)
                                                    : shade_triangle(scene, s.triangle, direction, turn);
        sum += static_cast<float>(s.count) * color;
      }
      sum /= static_cast<float>(samples * samples);
      for (int c = 0; c < 3; ++c) image.pixel(x, y)[c] = srgb_byte(sum[c]);
    }
  });
  return image;
}

}  // namespace tremula
