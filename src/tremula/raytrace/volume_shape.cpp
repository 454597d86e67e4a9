#include "tremula/raytrace/volume_shape.hpp"

#include "tremula/base/error.hpp"
#include "tremula/base/noise.hpp"
#include "tremula/base/number_text.hpp"
#include "tremula/raytrace/sampling.hpp"
#include "tremula/raytrace/scattering.hpp"
#include "tremula/render/patterns.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace tremula {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

// The numbers of one ray.
class Chance {
 public:
  explicit Chance(std::uint32_t seed) : seed_(seed) {}
  std::uint32_t bits() { return hash(seed_ += 0x9e3779b9U); }
  float unit() { return unit_of(bits()); }

 private:
  std::uint32_t seed_;
};

struct Way {
  float from = 0, to = 0;
};

// The part of a ray in a box; empty where `to` is not above `from`.
Way within(const Eigen::AlignedBox3f& box, const Vector3f& origin, const Vector3f& direction) {
  Way way{0, std::numeric_limits<float>::max()};
  for (int i = 0; i < 3; ++i) {
    if (direction[i] == 0) {
      if (origin[i] < box.min()[i] || origin[i] > box.max()[i]) return {0, 0};
      continue;
    }
    const float a = (box.min()[i] - origin[i]) / direction[i], b = (box.max()[i] - origin[i]) / direction[i];
    way.from = std::max(way.from, std::min(a, b));
    way.to = std::min(way.to, std::max(a, b));
  }
  return way;
}

Vector3f jittered(std::uint32_t bits) {  // within half a texel
  const auto third = [&](int shift) { return static_cast<float>((bits >> shift) & 1023U) / 1024 - 0.5F; };
  return {third(0), third(10), third(20)};
}

// The colour of a place in the field: patches that grew in better soil or ripened later.
Vector3f tint(const VolumeLook& look, const Vector2f& at) {
  if (!(look.patches > 0)) return Vector3f::Ones();
  const Vector2f place = at / look.patch_size;
  const float x = place.x() + 1000, y = place.y() + 1000;
  const float wide = noise(x, y, 0, 71), fine = noise(2.7F * x, 2.7F * y, 0, 72);
  const float bright = look.patches * (0.65F * wide + 0.35F * fine - 0.5F);
  const float warm = look.patches * (noise(0.7F * x, 0.7F * y, 0, 73) - 0.5F);
  return {1 + bright + 0.7F * warm, 1 + bright, 1 + bright - 0.7F * warm};
}

// One shape: the volume marched through from where the ray enters it.
class March {
 public:
  March(std::shared_ptr<const PosedVolume> volume, const VolumeLook& look, std::shared_ptr<const Gloss> coat)
      : shared_(std::move(volume)), volume_(*shared_), look_(look), coat_(std::move(coat)) {
    const std::vector<Texels>& levels = volume_.field->patches.front();
    for (const Texels& texels : levels) cells_.push_back(texels.cell.minCoeff());
  }

  bool operator()(const Vector3f& origin, const Vector3f& direction, float shutter, float farthest,
                  std::uint32_t random, RayShapeHit& hit) const {
    const Way way = within(volume_.bounds, origin, direction);
    const float end = std::min(way.to, farthest);
    if (!(end > way.from)) return false;
    Chance chance(random);
    float left = -std::log(1 - chance.unit());  // of optical depth, until something is met
    Vector2f guess = Vector2f::Zero();
    RestPlace rest;
    unbend(volume_, origin + way.from * direction, shutter, guess, rest);
    for (float t = way.from; t < end;) {
      const int level = level_at(t, chance.unit());
      const float step = std::min(cells_[static_cast<std::size_t>(level)], way.to - t);
      float next = t + step;
      // Where in the step is looked is by chance, so that no layers are seen.
      const std::uint32_t bits = chance.bits();
      const float here = t + step * unit_of(hash(bits));
      if (unbend(volume_, origin + here * direction, shutter, guess, rest)) {
        const TexelValue value = value_at(volume_, rest, level, jittered(bits));
        const float depth = value.density > 0 ? value.density * seen_share(value, direction) * step : 0;
        if (depth >= left) {
          hit.distance = t + step * left / depth;
          set(value, rest, direction, chance, hit);
          return hit.distance <= end;
        }
        left -= depth;
        if (value.density == 0) next = std::max(next, here + clearance_at(volume_, rest));
      }
      if (!(next > t)) break;  // farther away than numbers can tell
      t = next;
    }
    return false;
  }

 private:
  int level_at(float distance, float random) const {
    const float footprint = look_.pixel * distance;
    if (footprint <= cells_.front()) return 0;
    const float level = std::log2(footprint / cells_.front()) + random;
    return std::min(static_cast<int>(level), static_cast<int>(cells_.size()) - 1);
  }

  void set(const TexelValue& value, const RestPlace& rest, const Vector3f& direction, Chance& chance,
           RayShapeHit& hit) const {
    const float a = chance.unit(), b = chance.unit();
    hit.normal = visible_normal(value, direction, {a, b});
    hit.reflected = value.color.cwiseProduct(tint(look_, rest.at)).cwiseMin(1.0F).cwiseMax(0.0F);
    hit.transmitted = Vector3f::Zero();
    hit.gloss = coat_.get();
    if (!(look_.translucent > 0)) return;
    hit.transmitted = look_.translucent * light_through_leaf(hit.reflected);
    const float most = (hit.reflected + hit.transmitted).maxCoeff();
    if (most > 1) {
      hit.reflected /= most;
      hit.transmitted /= most;
    }
  }

  std::shared_ptr<const PosedVolume> shared_;
  const PosedVolume& volume_;
  VolumeLook look_;
  std::shared_ptr<const Gloss> coat_;
  std::vector<float> cells_;  // edges of the texels of every level [m]
};

}  // namespace

Vector3f visible_normal(const TexelValue& value, const Vector3f& direction, const Vector2f& random) {
  const LocalAxes axes(-direction);  // x, y and z: k, j and i of the paper
  const Vector3f t = axes.in(value.axis);
  const float q = 2 / (2 + value.spread), less = q * (1 - value.spread);  // S = q - less t t^T
  const float jj = q - less * t.y() * t.y(), ii = q - less * t.z() * t.z();
  const float kj = -less * t.x() * t.y(), ki = -less * t.x() * t.z(), ji = -less * t.y() * t.z();
  const float determinant = std::max(0.0F, q * q * (q - less)), minor = std::max(0.0F, jj * ii - ji * ji);
  const float root_i = std::sqrt(std::max(ii, 1e-12F)), root_minor = std::sqrt(std::max(minor, 1e-12F));
  const float radius = std::sqrt(random.x()), turn = 2 * std::numbers::pi_v<float> * random.y();
  const float u = radius * std::cos(turn), v = radius * std::sin(turn),
              w = std::sqrt(std::max(0.0F, 1 - u * u - v * v));
  const Vector3f of_k(std::sqrt(determinant) / root_minor, 0, 0);
  const Vector3f of_j(-(ki * ji - kj * ii) / (root_i * root_minor), root_minor / root_i, 0);
  const Vector3f of_i(ki / root_i, ji / root_i, ii / root_i);
  const Vector3f normal = u * of_k + v * of_j + w * of_i;
  const float length = normal.norm();
  if (!(length > 1e-9F)) return -direction;
  return axes.out(normal / length);
}

RayShape volume_shape(std::shared_ptr<const VolumeField> field, const VolumeLook& look, std::string name) {
  const VolumeGround ground = prepare_volume(std::move(field));
  RayShape shape;
  shape.name = std::move(name);
  shape.reach = pose_volume(ground, 0).bounds;
  if (look.roughness && !(*look.roughness >= 0 && *look.roughness <= 1))
    throw InputError("roughness of the strands", number_text(static_cast<double>(*look.roughness)), "0 to 1");
  const auto coat = look.roughness ? std::make_shared<const Gloss>(*look.roughness) : nullptr;
  shape.pose = [ground, look, coat](double time, double shutter) {
    const auto posed = std::make_shared<const PosedVolume>(pose_volume(ground, time, shutter));
    return std::vector<PosedRayShape>{{posed->bounds, March(posed, look, coat)}};
  };
  return shape;
}

}  // namespace tremula
