#include "tremula/raytrace/path.hpp"

#include "tremula/base/noise.hpp"
#include "tremula/raytrace/ground_look.hpp"
#include "tremula/raytrace/scattering.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tremula {
namespace {

using Eigen::Vector3f;

constexpr float far_away = std::numeric_limits<float>::max();
constexpr int sky_asked = 1;            // so many spots of a path ask the sky for a bright direction
constexpr int roulette_from = 3;        // spots of a path that always go on
constexpr float flat_footprint = 1e6F;  // of what is seen by way of others: patterns faded to their mean

// A spot that scatters light: of a surface or of the ground.
struct Vertex {
  Scattering scattering;
  Vector3f front, behind;  // where rays begin that leave towards the eye's side, or away from it
};

float ground_distance(const GroundLook& ground, const Ray& ray) {
  if (ground.kind == GroundKind::none || !(ray.direction.z() < 0)) return far_away;
  const float above = ray.origin.z() - static_cast<float>(ground.height);
  return above > 0 ? -above / ray.direction.z() : far_away;
}

// So far from a surface that rounding does not put a ray's origin on its other side.
float clearance(const Vector3f& point) { return 1e-6F + 2e-6F * point.cwiseAbs().maxCoeff(); }

// No two copies have the same colour.
Rgb tinted(const Rgb& color, std::uint32_t copy) {
  const float bright = 0.88F + 0.24F * hash_to_unit(3 * copy + 0x51ed27U);
  const float warm = hash_to_unit(3 * copy + 0x51ed28U) - 0.5F;
  return bright * color.cwiseProduct(Rgb(1 + 0.3F * warm, 1, 1 - 0.2F * warm));
}

// Leaves in the sun are paler than their colour in the shade of others, and let more light through than they
// reflect.
void scatter_as_leaf(const PathSettings& settings, const Spot& spot, bool from_behind, Scattering& to) {
  constexpr float paler = 0.08F, through = 1.3F, most = 0.98F;
  Rgb color = settings.scene.copy_count() > 1 ? tinted(spot.part->color, spot.copy) : spot.part->color;
  color += paler * (Rgb::Constant(color.mean()) - color);
  to.reflected = leaf_pattern(color, spot.uv, spot.piece, from_behind);
  to.transmitted = through * light_through_leaf(to.reflected);
  const float largest = (to.reflected + to.transmitted).maxCoeff();
  if (largest > most) {
    to.reflected *= most / largest;
    to.transmitted *= most / largest;
  }
}

// Blades of grass have the colours of the green ground they stand on, which fade into each other far away; on
// any other, their own.
void scatter_as_blade(const GroundLook& ground, const Spot& spot, bool from_behind, Scattering& to) {
  constexpr float patches = 0.4F;  // [m] what is finer the blades do themselves
  const bool on_grass = ground.kind == GroundKind::grass;
  const Rgb color =
      on_grass ? ground_pattern(ground, spot.point.head<2>(), patches).albedo : spot.part->color;
  to.reflected = leaf_pattern(color, spot.uv, spot.piece, from_behind).cwiseMin(0.45F);
  to.transmitted = light_through_leaf(to.reflected);
}

void scatter_as_cloth(const Rgb& color, Scattering& to) {
  constexpr float through = 0.3F;
  to.reflected = (1 - through) * color;
  to.transmitted = through * color;
}

Vertex vertex_of(const PathSettings& settings, const Spot& spot, const Vector3f& to_eye, float footprint) {
  Vertex vertex;
  Scattering& to = vertex.scattering;
  const PartLook& part = *spot.part;
  const bool from_behind = spot.plane.dot(to_eye) < 0;
  to.plane = from_behind ? Vector3f(-spot.plane) : spot.plane;
  Vector3f normal = from_behind ? Vector3f(-spot.normal) : spot.normal;
  to.reflected = part.color;
  to.gloss = part.gloss.get();
  switch (part.kind) {
    case PartLook::Kind::leaf:
      scatter_as_leaf(settings, spot, from_behind, to);
      break;
    case PartLook::Kind::blade:
      scatter_as_blade(settings.ground, spot, from_behind, to);
      break;
    case PartLook::Kind::cloth:
      scatter_as_cloth(part.color, to);
      break;
    case PartLook::Kind::bark: {
      const TextureFrame frame = texture_frame(spot.ab, spot.ac, spot.uv_ab, spot.uv_ac);
      const PatternSpot bark = bark_pattern(part.color, spot.uv, normal, frame, footprint * frame.per_metre);
      to.reflected = bark.albedo.cwiseMin(1.0F);
      normal = bark.normal;
      break;
    }
    case PartLook::Kind::dull:
      break;
  }
  to.normal = facing(normal, to_eye);
  const float away = clearance(spot.point);
  vertex.front = (from_behind ? spot.point : spot.lifted) + away * to.plane;
  vertex.behind = spot.point - away * to.plane;
  return vertex;
}

Vertex vertex_of(const GroundLook& ground, const Vector3f& point, const Vector3f& to_eye, float footprint) {
  Vertex vertex;
  Scattering& to = vertex.scattering;
  const PatternSpot pattern = ground_pattern(ground, point.head<2>(), footprint);
  to.plane = Vector3f::UnitZ();
  to.reflected = pattern.albedo.cwiseMin(1.0F);
  to.normal = facing(pattern.normal, to_eye);
  vertex.front = vertex.behind = point;
  vertex.front.z() = static_cast<float>(ground.height) + clearance(point);
  return vertex;
}

Vertex vertex_of(const Ray& ray, const RayShapeHit& hit) {
  Vertex vertex;
  Scattering& to = vertex.scattering;
  const Vector3f to_eye = -ray.direction, point = ray.origin + hit.distance * ray.direction;
  to.plane = hit.normal.dot(to_eye) < 0 ? Vector3f(-hit.normal) : hit.normal;
  to.normal = facing(to.plane, to_eye);
  const float most = (hit.reflected + hit.transmitted).maxCoeff(), scale = most > 1 ? 1 / most : 1;
  to.reflected = scale * hit.reflected;
  to.transmitted = scale * hit.transmitted;
  to.gloss = hit.gloss;
  const float away = clearance(point);
  vertex.front = point + away * to.plane;
  vertex.behind = point - away * to.plane;
  return vertex;
}

float power_share(float mine, float other) { return mine * mine / (mine * mine + other * other); }

class Path {
 public:
  Path(const PathSettings& settings, Ray ray, Sampler& sampler, std::uint64_t& rays)
      : settings_(settings), ray_(ray), sampler_(sampler), rays_(rays) {}

  PathSample follow() {
    for (int depth = 0;; ++depth) {
      const float ground = ground_distance(settings_.ground, ray_);
      const bool last = depth == settings_.bounces;
      if (last && depth > 0) {  // only the sky counts
        if (ground == far_away && !blocked(ray_, far_away)) add(sky_share(depth));
        break;
      }
      const Hit hit = closest(ground);
      if (!hit && ground == far_away) {
        add(sky_share(depth));
        if (depth == 0) add(settings_.far_light.disc(ray_.direction));
        break;
      }
      const float distance = hit ? hit.distance : ground;
      if (settings_.far_light.hazy() && depth == 0) dim(distance);
      const Vector3f to_eye = -ray_.direction;
      const Vertex vertex = meet(hit, distance, to_eye, depth);
      if (depth == 0) {
        sample_.albedo = (vertex.scattering.reflected + vertex.scattering.transmitted).cwiseMin(1.0F);
        sample_.normal = vertex.scattering.normal;
      }
      if (last) break;
      ask_sun(vertex, to_eye);
      if (depth < sky_asked && settings_.far_light.sampled()) ask_sky(vertex, to_eye);
      if (!go_on(vertex, to_eye, depth)) break;
    }
    return sample_;
  }

 private:
  Hit closest(float farthest) {
    ++rays_;
    ray_.random = sampler_.ticket();
    if (settings_.shot) settings_.shot->push_back({ray_, farthest, false});
    return settings_.scene.closest(ray_, farthest);
  }
  bool blocked(Ray ray, float farthest) {
    ++rays_;
    ray.random = sampler_.ticket();
    if (settings_.shot) settings_.shot->push_back({ray, farthest, true});
    return settings_.scene.blocked(ray, farthest);
  }
  void add(const Rgb& light) {
    const Rgb more = through_.cwiseProduct(light);
    if (more.allFinite()) sample_.light += more;
  }

  Vertex meet(const Hit& hit, float distance, const Vector3f& to_eye, int depth) const {
    const float across = distance * settings_.pixel;
    if (hit.of_shape) return vertex_of(ray_, hit.shape);
    if (hit) {
      const Spot spot = settings_.scene.spot(ray_, hit);
      return vertex_of(settings_, spot, to_eye, depth == 0 ? across : flat_footprint);
    }
    const Vector3f point = ray_.origin + distance * ray_.direction;
    // A pixel is longer on the ground than wide; samples average what is between.
    constexpr float longest = 6;
    const float stretched = across * std::min(1 / std::max(to_eye.z(), 1e-3F), longest);
    return vertex_of(settings_.ground, point, to_eye,
                     depth == 0 ? std::sqrt(across * stretched) : flat_footprint);
  }

  // The air between here and the eye.
  void dim(float distance) {
    const Rgb passed = settings_.far_light.passed(distance);
    add((Rgb::Ones() - passed).cwiseProduct(settings_.far_light.haze(ray_.direction)));
    through_ = through_.cwiseProduct(passed);
  }

  // What of the sky's light this ray answers for, beside the one that asked the sky.
  Rgb sky_share(int depth) const {
    const Rgb light = settings_.far_light.sky(ray_.direction);
    if (depth == 0 || depth > sky_asked || !settings_.far_light.sampled()) return light;
    return power_share(density_, settings_.far_light.sky_density(ray_.direction)) * light;
  }

  bool sees(const Vertex& vertex, const Vector3f& direction) {
    const bool behind = direction.dot(vertex.scattering.plane) < 0;
    const Ray ray{behind ? vertex.behind : vertex.front, direction, ray_.time};
    return ground_distance(settings_.ground, ray) == far_away && !blocked(ray, far_away);
  }

  void ask_sun(const Vertex& vertex, const Vector3f& to_eye) {
    const FarLight& from = settings_.far_light;
    if (!from.has_sun()) return;
    const Vector3f to_sun = from.to_sun(sampler_.pair());
    float density = 0;
    const Rgb value = scattered(vertex.scattering, to_eye, to_sun, density);
    if (value.maxCoeff() > 0 && sees(vertex, to_sun)) add(value.cwiseProduct(from.sun_at(vertex.front)));
  }

  void ask_sky(const Vertex& vertex, const Vector3f& to_eye) {
    const FarLight& from = settings_.far_light;
    float density = 0, of_scattering = 0;
    const Vector3f direction = from.sample_sky(sampler_.pair(), density);
    if (!(density > 0)) return;
    const Rgb value = scattered(vertex.scattering, to_eye, direction, of_scattering);
    if (!(value.maxCoeff() > 0) || !sees(vertex, direction)) return;
    add(power_share(density, of_scattering) / density * value.cwiseProduct(from.sky(direction)));
  }

  bool go_on(const Vertex& vertex, const Vector3f& to_eye, int depth) {
    const float choice = sampler_.one();
    const Vector3f direction = scatter(vertex.scattering, to_eye, choice, sampler_.pair());
    const Rgb value = scattered(vertex.scattering, to_eye, direction, density_);
    if (!(density_ > 0)) return false;
    through_ = through_.cwiseProduct(value / density_);
    if (depth + 1 >= roulette_from) {
      const float stays = std::min(through_.maxCoeff(), 0.95F);
      if (!(sampler_.one() < stays)) return false;
      through_ /= stays;
    }
    if (!(through_.maxCoeff() > 0)) return false;
    ray_.origin = direction.dot(vertex.scattering.plane) < 0 ? vertex.behind : vertex.front;
    ray_.direction = direction;
    return true;
  }

  const PathSettings& settings_;
  Ray ray_;
  Sampler& sampler_;
  std::uint64_t& rays_;
  PathSample sample_;
  Rgb through_ = Rgb::Ones();
  float density_ = 0;  // with which ray_ was taken
};

}  // namespace

PathSample follow(const PathSettings& settings, Ray ray, Sampler& sampler, std::uint64_t& rays) {
  return Path(settings, ray, sampler, rays).follow();
}

}  // namespace tremula
