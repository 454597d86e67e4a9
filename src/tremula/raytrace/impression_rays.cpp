#include "tremula/raytrace/impression_rays.hpp"

#include "tremula/base/color.hpp"
#include "tremula/base/error.hpp"
#include "tremula/base/noise.hpp"
#include "tremula/render/patterns.hpp"
#include "tremula/wind/profile.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <tbb/parallel_for.h>

namespace tremula {
namespace {

using Eigen::Matrix3f;
using Eigen::Vector2f;
using Eigen::Vector3f;
using Eigen::Vector4f;

constexpr std::size_t most_quadrics = 64;  // of a tree, its trunk among them
constexpr float nearest = 2e-3F;           // so near to where a ray begins, it meets nothing [m]

// ---- What all copies have

struct Lobe {
  Vector3f centre;
  Matrix3f form;
  float level = 1, low = 0, high = 0;
  QuadricPaint paint;
  bool trunk = false;
};

struct Kind {
  ImpressionistTree tree;
  std::vector<Lobe> lobes;  // the trunk first
  TextureLevels levels;
  float leaf_size = 0.1F;      // [m]
  float first = 0, ninth = 1;  // deciles of the texture
  Rgb leaf, bark;              // linear
  TrunkCurve curve;
  Vector2f along, across;  // the wind, world axes
  ImpressionMotion motion;
  std::vector<Instance> instances;
};

// One copy at the time of a frame.
struct Copy {
  Vector3f position = Vector3f::Zero();
  float scale = 1, cosine = 1, sine = 0;
  Vector2f opens = Vector2f::Zero(), closes = Vector2f::Zero();  // the top, along and across [m]
  double time = 0;                                               // in the middle of the shutter [s]
  std::uint32_t number = 0;

  Vector3f in(const Vector3f& v) const {
    return {cosine * v.x() + sine * v.y(), cosine * v.y() - sine * v.x(), v.z()};
  }
  Vector3f out(const Vector3f& v) const {
    return {cosine * v.x() - sine * v.y(), sine * v.x() + cosine * v.y(), v.z()};
  }
};

struct Posed {
  std::shared_ptr<const Kind> kind;
  std::vector<Copy> copies;
  double shutter = 0;
};

Lobe lobe_of(const Quadric& quadric, std::size_t number, std::uint64_t seed) {
  Lobe lobe;
  lobe.centre = quadric.centre.cast<float>();
  lobe.form = quadric.form.cast<float>();
  lobe.level = static_cast<float>(quadric.level);
  const Eigen::AlignedBox3d box = bounds_of(quadric);
  lobe.low = static_cast<float>(box.min().z());
  lobe.high = static_cast<float>(box.max().z());
  lobe.paint = paint_of(quadric, number, seed);
  lobe.trunk = number == 0;
  return lobe;
}

Rgb linear(const Vector3f& srgb) {
  Rgb color;
  for (int i = 0; i < 3; ++i) color[i] = linear_from_srgb(std::clamp(srgb[i], 0.0F, 1.0F));
  return color;
}

// ---- A ray and a tree

// A ray in the axes of a copy, and how the trunk stands there when it comes.
struct LocalRay {
  Vector3f origin, direction;
  const TrunkCurve* curve = nullptr;
  Vector2f top;            // displacement, along and across
  Vector2f along, across;  // the wind in the axes of the copy

  Vector3f at(float t) const { return origin + t * direction; }
  // Where the level at this height stands, and how that goes with height: x and y.
  void shift_at(float height, Vector2f& shift, Vector2f& slope) const {
    shift.setZero();
    slope.setZero();
    if (!curve->moves()) return;
    Vector4f value, rise;
    curve->at(height, value, rise);
    const Vector2f u = value.head<2>() + value.tail<2>().cwiseProduct(top);
    const Vector2f v = rise.head<2>() + rise.tail<2>().cwiseProduct(top);
    shift = u.x() * along + u.y() * across;
    slope = v.x() * along + v.y() * across;
  }
};

// Where a ray meets a quadric, that stands upright: its two distances, rising.
bool meet(const Lobe& lobe, const Vector3f& from, const Vector3f& direction, std::array<float, 2>& at) {
  // From where the ray is near, so that nothing cancels.
  const float nearby = -from.dot(direction) / direction.squaredNorm();
  const Vector3f near_by = from + nearby * direction;
  const Vector3f of_direction = lobe.form * direction;
  const float a = direction.dot(of_direction), b = near_by.dot(of_direction),
              c = near_by.dot(lobe.form * near_by) - lobe.level;
  const float rest = b * b - a * c;
  if (!(rest >= 0)) return false;
  const float far_root = -(b + std::copysign(std::sqrt(rest), b));
  float first = far_root / a, second = far_root != 0 ? c / far_root : first;
  if (first > second) std::swap(first, second);
  at = {nearby + first, nearby + second};
  return true;
}

// A place on a lobe that a ray meets: where, and where that is while nothing moves.
struct Meeting {
  float distance = 0;
  std::uint16_t lobe = 0, leaves = 0;
};

// Level by level everything is shifted: straight lines become curves, which Newton's method straightens about
// the height where they meet the quadric.
void meet_swayed(const LocalRay& ray, const Lobe& lobe, std::uint16_t number, float farthest,
                 std::array<Meeting, 2 * most_quadrics>& found, std::size_t& count) {
  const Vector3f middle(lobe.centre.x(), lobe.centre.y(), 0);
  const auto meet_about = [&](float height, std::array<float, 2>& at) {
    Vector2f shift, slope;
    ray.shift_at(height, shift, slope);
    Vector3f from = ray.origin - lobe.centre, direction = ray.direction;
    from.head<2>() -= shift + slope * (ray.origin.z() - height);
    direction.head<2>() -= slope * ray.direction.z();
    return meet(lobe, from, direction, at);
  };
  const float level = ray.direction.head<2>().squaredNorm();
  float height = lobe.centre.z();
  if (level > 1e-9F) {
    Vector2f shift, slope;
    ray.shift_at(std::clamp(lobe.centre.z(), lobe.low, lobe.high), shift, slope);
    const Vector2f to = middle.head<2>() + shift - ray.origin.head<2>();
    height = ray.origin.z() + to.dot(ray.direction.head<2>()) / level * ray.direction.z();
  }
  std::array<float, 2> first{};
  if (!meet_about(std::clamp(height, lobe.low, lobe.high), first)) return;
  for (std::size_t side = 0; side < 2; ++side) {
    std::array<float, 2> at = first;
    bool met = true;
    for (int i = 0; i < 2 && met && ray.curve->moves(); ++i)
      met = meet_about(std::clamp(ray.at(at[side]).z(), lobe.low, lobe.high), at);
    if (!met || !(at[side] > nearest && at[side] < farthest)) continue;
    const float z = ray.at(at[side]).z(), slack = 1e-5F * (1 + std::abs(z));
    if (z < lobe.low - slack || z > lobe.high + slack) continue;
    found[count++] = {at[side], number, static_cast<std::uint16_t>(side)};
  }
}

struct Place {
  Vector3f normal;   // outwards, unit, as the crown stands
  Vector3f resting;  // from the lobe's centre, where that is while nothing moves
  Vector3f upright;  // the normal there, unit
  float middle = 1;  // Gardner's: 1 amid the outline of the lobe, 0 on it
};

Place place_of(const LocalRay& ray, const Lobe& lobe, float distance) {
  Vector2f shift, slope;
  const Vector3f point = ray.at(distance);
  ray.shift_at(point.z(), shift, slope);
  Place place;
  place.resting = point - lobe.centre;
  place.resting.head<2>() -= shift;
  Vector3f direction = ray.direction;
  direction.head<2>() -= slope * direction.z();
  const Vector3f gradient = lobe.form * place.resting;
  place.upright = gradient.normalized();
  place.normal = gradient;
  place.normal.z() -= slope.dot(gradient.head<2>());
  place.normal.normalize();
  // Where the quadric is a sphere: the square of how far it turns towards the eye.
  const Vector3f on_sphere = lobe.paint.sign.cwiseProduct(lobe.paint.root * place.resting),
                 along = lobe.paint.root * direction;
  const float size = on_sphere.squaredNorm() * along.squaredNorm();
  const float cosine = on_sphere.dot(along);
  place.middle = size > 0 ? std::min(cosine * cosine / size, 1.0F) : 1;
  return place;
}

Vector3f texture_place(const Lobe& lobe, const Copy& copy, const Vector3f& resting) {
  return lobe.paint.turn * resting + lobe.paint.offset + Vector3f::Constant(texture_shift(copy.number));
}

// By how much the texture has moved, in the axes of the copy and along the crown's surface (F section 5.3:
// "to make the visual motion smooth, the vibration is projected onto the tangent plane of the envelope").
Vector3f trembling(const Kind& kind, const Copy& copy, const Vector3f& point, const Vector3f& normal,
                   double time) {
  if (!kind.motion.tremble) return Vector3f::Zero();
  const Vector3f world = copy.position + copy.scale * copy.out(point);
  const Vector3f local = local_value_at(*kind.motion.tremble, world.cast<double>(), time);
  Vector3f moved;
  moved << local.x() * kind.along + local.y() * kind.across, local.z();
  moved = copy.in(moved);
  return moved - moved.dot(normal) * normal;
}

void look_as_bark(const Kind& kind, const Place& place, RayShapeHit& hit) {
  const float angle = std::atan2(place.resting.y(), place.resting.x());
  const float furrow = noise(angle * 4.1F, place.resting.z() * 1.7F, 0, 7U) +
                       0.5F * noise(angle * 11, place.resting.z() * 5, 0, 8U);
  hit.normal = place.normal;
  hit.reflected = (0.5F + 0.6F * furrow) * kind.bark;
  hit.transmitted.setZero();
}

// Leaves are cells of space about points that are strewn in a lattice: the texture decides of each as a
// whole, and each is turned in its own way.
struct LeafCell {
  Vector3f middle;
  std::uint32_t number = 0;
};

LeafCell leaf_cell(const Vector3f& at, float size) {
  constexpr float strewn = 0.7F;
  const Vector3f place = at / size, low = (place - Vector3f::Constant(0.5F)).array().floor();
  LeafCell nearest_cell;
  float least = std::numeric_limits<float>::max();
  for (int i = 0; i < 8; ++i) {
    const Vector3f corner =
        low + Vector3f(static_cast<float>(i & 1), static_cast<float>(i >> 1 & 1), static_cast<float>(i >> 2));
    const auto whole = [&](int k) {
      return static_cast<std::uint32_t>(static_cast<std::int32_t>(corner[k]));
    };
    const std::uint32_t number = hash(whole(0) * 73856093U ^ whole(1) * 19349663U ^ whole(2) * 83492791U);
    const Vector3f middle =
        corner + Vector3f(0.5F + strewn * (static_cast<float>(number & 1023U) / 1023 - 0.5F),
                          0.5F + strewn * (static_cast<float>(number >> 10 & 1023U) / 1023 - 0.5F),
                          0.5F + strewn * (static_cast<float>(number >> 20 & 1023U) / 1023 - 0.5F));
    const float apart = (middle - place).squaredNorm();
    if (apart < least) least = apart, nearest_cell = {size * middle, number};
  }
  return nearest_cell;
}

// Gardner shades with the texture.
void look_as_leaves(const Kind& kind, const Copy& copy, const Place& place, const LeafCell& leaf, float value,
                    RayShapeHit& hit) {
  constexpr float turned = 0.9F;  // leaves against the envelope
  const float z = 2 * hash_to_unit(leaf.number + 1) - 1, r = std::sqrt(1 - z * z);
  const float angle = 2 * std::numbers::pi_v<float> * hash_to_unit(leaf.number + 2);
  hit.normal = (place.normal + turned * Vector3f(r * std::cos(angle), r * std::sin(angle), z)).normalized();
  const float bright = std::clamp((value - kind.first) / (kind.ninth - kind.first), 0.0F, 1.3F);
  const float of_copy = 0.85F + 0.3F * hash_to_unit(3 * copy.number + 0x51ed27U);
  const float of_leaf = 0.8F + 0.4F * hash_to_unit(leaf.number + 3);
  const float warm =
      hash_to_unit(3 * copy.number + 0x51ed28U) - 0.5F + 0.4F * (hash_to_unit(leaf.number + 4) - 0.5F);
  const Rgb color = (of_copy * of_leaf * (0.6F + 0.5F * bright) * kind.leaf)
                        .cwiseProduct(Rgb(1 + 0.3F * warm, 1, 1 - 0.2F * warm));
  hit.reflected = color.cwiseMin(0.5F);
  hit.transmitted = light_through_leaf(hit.reflected).cwiseMin(0.45F);
}

bool hit_copy(const Posed& posed, const Copy& copy, const Vector3f& origin, const Vector3f& direction,
              float shutter, float farthest, std::uint32_t random, RayShapeHit& hit) {
  const Kind& kind = *posed.kind;
  LocalRay ray{copy.in(origin - copy.position) / copy.scale,
               copy.in(direction),
               &kind.curve,
               copy.opens + shutter * (copy.closes - copy.opens),
               {},
               {}};
  const auto turned = [&](const Vector2f& v) { return copy.in({v.x(), v.y(), 0}).head<2>().eval(); };
  ray.along = turned(kind.along);
  ray.across = turned(kind.across);
  std::array<Meeting, 2 * most_quadrics> found;
  std::size_t count = 0;
  for (std::size_t i = 0; i < kind.lobes.size(); ++i)
    meet_swayed(ray, kind.lobes[i], static_cast<std::uint16_t>(i), farthest / copy.scale, found, count);
  std::sort(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(count),
            [](const Meeting& a, const Meeting& b) {
              return a.distance < b.distance || (a.distance == b.distance && a.lobe < b.lobe);
            });
  const double time = copy.time + posed.shutter * (static_cast<double>(shutter) - 0.5);
  for (std::size_t i = 0; i < count; ++i) {
    const Meeting& meeting = found[i];
    const Lobe& lobe = kind.lobes[meeting.lobe];
    const Place place = place_of(ray, lobe, meeting.distance);
    hit.distance = meeting.distance * copy.scale;
    if (lobe.trunk) {
      look_as_bark(kind, place, hit);
      hit.normal = copy.out(hit.normal);
      return true;
    }
    const Vector3f moved = trembling(kind, copy, ray.at(meeting.distance), place.upright, time);
    const Vector3f at = texture_place(lobe, copy, place.resting) - lobe.paint.turn * moved;
    const LeafCell leaf = leaf_cell(at, kind.leaf_size);
    const float value = value_at(kind.tree.texture, leaf.middle);
    const float opacity = opacity_at(kind.levels, kind.tree.cover, value, place.middle);
    const std::uint32_t own = 2U * meeting.lobe + meeting.leaves;
    if (!(hash_to_unit(random + 0x9e3779b9U * own) < opacity)) continue;
    look_as_leaves(kind, copy, place, leaf, value, hit);
    hit.normal = copy.out(hit.normal);
    return true;
  }
  return false;
}

// ---- Poses

// The same bits at t and at t + T.
double within_period(double time, double period) {
  if (!(period > 0)) return time;
  constexpr double steps = 0x1p40;
  double share = std::fmod(std::round(time / period * steps) / steps, 1.0);
  if (share < 0) share += 1;
  return share * period;
}

// What a top at (along, across) makes of the box of a lobe, in the axes of the copy.
void extend_by(Eigen::AlignedBox3f& box, const Kind& kind, const Copy& copy, const Lobe& lobe,
               const Eigen::AlignedBox3f& resting, const Vector2f& top) {
  LocalRay stand{{}, {}, &kind.curve, top, {}, {}};
  const auto turned = [&](const Vector2f& v) { return copy.in({v.x(), v.y(), 0}).head<2>().eval(); };
  stand.along = turned(kind.along);
  stand.across = turned(kind.across);
  constexpr int levels = 8;
  for (int i = 0; i <= levels; ++i) {
    const float z = lobe.low + (lobe.high - lobe.low) * static_cast<float>(i) / levels;
    Vector2f shift, slope;
    stand.shift_at(z, shift, slope);
    for (int corner = 0; corner < 4; ++corner) {
      Vector3f at(corner % 2 ? resting.max().x() : resting.min().x(),
                  corner / 2 ? resting.max().y() : resting.min().y(), z);
      at.head<2>() += shift;
      box.extend(copy.position + copy.scale * copy.out(at));
    }
  }
}

Eigen::AlignedBox3f bounds_of(const Kind& kind, const std::vector<Eigen::AlignedBox3f>& resting,
                              const Copy& copy, std::initializer_list<Vector2f> tops) {
  Eigen::AlignedBox3f box;
  for (const Vector2f& top : tops) {
    for (std::size_t i = 0; i < kind.lobes.size(); ++i)
      extend_by(box, kind, copy, kind.lobes[i], resting[i], top);
  }
  const Vector3f slack = Vector3f::Constant(0.01F * copy.scale + 1e-6F * box.max().cwiseAbs().maxCoeff());
  return {box.min() - slack, box.max() + slack};
}

Copy copy_of(const Kind& kind, std::size_t number, double time, double shutter) {
  const Instance& instance = kind.instances[number];
  Copy copy;
  copy.position = instance.position.cast<float>();
  copy.scale = static_cast<float>(instance.scale);
  copy.cosine = static_cast<float>(std::cos(instance.turn));
  copy.sine = static_cast<float>(std::sin(instance.turn));
  copy.number = static_cast<std::uint32_t>(number);
  const TravellingField* field = kind.motion.sway ? kind.motion.sway.get() : kind.motion.tremble.get();
  copy.time = within_period(time + instance.time_shift, field ? field->loop.period : 0);
  if (!kind.motion.sway) return copy;
  const Vec3 foot = instance.position;
  copy.opens = local_value_at(*kind.motion.sway, foot, copy.time - shutter / 2).head<2>();
  copy.closes = local_value_at(*kind.motion.sway, foot, copy.time + shutter / 2).head<2>();
  return copy;
}

}  // namespace

std::shared_ptr<const RayShape> impression_shape(const ImpressionistTree& tree,
                                                 std::vector<Instance> instances,
                                                 const ImpressionMotion& motion) {
  check_tree(tree);
  check_instances(instances);
  check_motion(motion);
  if (tree.crown.size() >= most_quadrics)
    throw InputError("crown of '" + tree.name + "'", std::to_string(tree.crown.size()) + " quadrics",
                     "at most " + std::to_string(most_quadrics - 1));
  auto kind = std::make_shared<Kind>();
  kind->tree = tree;
  kind->motion = motion;
  kind->curve = trunk_curve(motion);
  kind->along = heading_direction(motion.heading).head<2>().cast<float>();
  kind->across = {-kind->along.y(), kind->along.x()};
  kind->levels = levels_of(tree.texture);
  kind->first = threshold_for(kind->levels, 0.9F);
  kind->ninth = threshold_for(kind->levels, 0.1F);
  kind->leaf_size = static_cast<float>(tree.leaf_size);
  kind->leaf = linear(tree.leaf_color);
  kind->bark = linear(tree.bark_color);
  kind->instances = std::move(instances);
  const std::vector<Quadric> quadrics = quadrics_of(tree);
  std::vector<Eigen::AlignedBox3f> resting;
  for (std::size_t i = 0; i < quadrics.size(); ++i) {
    kind->lobes.push_back(lobe_of(quadrics[i], i, tree.seed));
    resting.push_back(tremula::bounds_of(quadrics[i]).cast<float>());
  }

  auto shape = std::make_shared<RayShape>();
  shape->name = tree.name;
  // As far as the field ever moves any top.
  Vector2f most = Vector2f::Zero();
  if (motion.sway) {
    for (const auto& value : motion.sway->values)
      most = most.cwiseMax(Vector2f(std::abs(value[0]), std::abs(value[1])));
  }
  for (std::size_t i = 0; i < kind->instances.size(); ++i) {
    const Copy copy = copy_of(*kind, i, 0, 0);
    shape->reach.extend(bounds_of(
        *kind, resting, copy, {most, -most, Vector2f(most.x(), -most.y()), Vector2f(-most.x(), most.y())}));
  }
  shape->pose = [kind = std::shared_ptr<const Kind>(std::move(kind)), resting = std::move(resting)](
                    double time, double shutter) {
    auto posed = std::make_shared<Posed>();
    posed->kind = kind;
    posed->shutter = shutter;
    posed->copies.resize(kind->instances.size());
    std::vector<PosedRayShape> all(kind->instances.size());
    tbb::parallel_for(std::size_t{0}, all.size(), [&](std::size_t i) {
      Copy& copy = posed->copies[i];
      copy = copy_of(*kind, i, time, shutter);
      all[i].bounds = bounds_of(*kind, resting, copy, {copy.opens, copy.closes});
      all[i].hit = [posed, i](const Vector3f& origin, const Vector3f& direction, float open, float farthest,
                              std::uint32_t random, RayShapeHit& hit) {
        return hit_copy(*posed, posed->copies[i], origin, direction, open, farthest, random, hit);
      };
    });
    return all;
  };
  return shape;
}

}  // namespace tremula
