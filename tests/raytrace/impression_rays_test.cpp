#include "tremula/raytrace/impression_rays.hpp"

#include "raytrace/simple_scenes.hpp"

#include "tremula/base/error.hpp"
#include "tremula/base/noise.hpp"
#include "tremula/numerics/random.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <tbb/global_control.h>

namespace tremula {
namespace {

using namespace simple;
using Eigen::Vector2d;
using Eigen::Vector3f;

constexpr float very_far = 1e6F;

double drawn(int of, int i) {
  return uniform({.seed = 21, .bin = static_cast<std::uint32_t>(of), .place = static_cast<std::uint64_t>(i)});
}

// A field that is the same everywhere and goes as sin(2 pi t/T) along and half of it across.
std::shared_ptr<const TravellingField> rocking(float most, double speed = 5) {
  auto field = std::make_shared<TravellingField>();
  field->loop = {.period = 4, .sample_count = 64};
  field->speed = speed;
  field->mean = {Vec3::Zero()};
  for (int p = 0; p < field->loop.sample_count; ++p) {
    const float value = most * static_cast<float>(std::sin(2 * std::numbers::pi * p / 64));
    field->values.push_back({value, 0.5F * value, 0, 0});
  }
  return field;
}

std::shared_ptr<const TravellingField> always(const Vector3f& value) {
  auto field = std::make_shared<TravellingField>();
  field->loop = {.period = 4, .sample_count = 1};
  field->mean = {Vec3::Zero()};
  field->values = {{value.x(), value.y(), value.z(), 0}};
  return field;
}

// The trunk bends as a parabola.
ImpressionMotion bending(const ImpressionistTree& tree, std::shared_ptr<const TravellingField> sway) {
  ImpressionMotion motion;
  motion.heading = 25;
  for (int i = 0; i <= 10; ++i) {
    const double share = i / 10.0;
    motion.heights.push_back(tree.trunk_height * share);
    motion.lean.emplace_back(0.3 * share * share, 0);
    motion.share.emplace_back(share * share, share * share);
  }
  motion.sway = std::move(sway);
  return motion;
}

ImpressionistTree opaque(ImpressionistTree tree) {
  tree.cover = {.middle = 1, .edge = 1, .softness = 1e-6F};
  return tree;
}

ImpressionistTree ball() {
  ImpressionistTree tree = impressionist_tree("round", 6);
  tree.crown = {ellipsoid({0, 0, 4}, {2, 1.5, 1})};
  return opaque(tree);
}

PosedRayShape posed(const ImpressionistTree& tree, const ImpressionMotion& motion = {}, double time = 0,
                    const Instance& instance = {}) {
  return impression_shape(tree, {instance}, motion)->pose(time, 0)[0];
}

TEST(ImpressionShape, ThatStandsStillIsMetWhereItsEllipsoidIs) {
  const PosedRayShape shape = posed(ball(), {}, 0, {.position = {10, 20, 0}, .turn = 0.5, .scale = 2});
  const Vector3f centre(10, 20, 8), direction = Vector3f(-1, 0.4F, 0.2F).normalized();
  RayShapeHit hit;
  ASSERT_TRUE(shape.hit(centre - 30 * direction, direction, 0, very_far, 1, hit));
  const Eigen::Vector3d local = Eigen::AngleAxisd(-0.5, Vec3::UnitZ()) * direction.cast<double>();
  const double reach = 2 / std::sqrt(local.cwiseQuotient(Vec3(2, 1.5, 1)).squaredNorm());
  EXPECT_NEAR(hit.distance, 30 - reach, 1e-4);
  EXPECT_FALSE(shape.hit(centre - 30 * direction, direction, 0, hit.distance - 0.01F, 1, hit));
  EXPECT_FALSE(shape.hit(centre - 30 * direction, -direction, 0, very_far, 1, hit));
}

// Marched along the ray: the first place that is inside of any quadric, shifted as its level is.
TEST(ImpressionShape, ThatBendsIsMetWhereMarchingMeetsItsShiftedLevels) {
  const ImpressionistTree tree = opaque(impressionist_tree("oak", 9, 8));
  const ImpressionMotion motion = bending(tree, rocking(1.5F));
  const double time = 1;  // a quarter: the top is at (1.8, 0.75)
  const PosedRayShape shape = posed(tree, motion, time);
  std::vector<Quadric> all = tree.crown;
  all.push_back(tapered_column(tree.trunk_height, tree.base_radius, tree.top_radius));
  const double heading = 25 * std::numbers::pi / 180;
  const auto inside = [&](const Vec3& point) {
    const double share = point.z() / tree.trunk_height;
    const double bent = share < 1 ? share * share : 2 * share - 1;
    const Vector2d top = bent * Vector2d(1.8, 0.75);
    Vec3 rest = point;
    rest.x() -= std::cos(heading) * top.x() - std::sin(heading) * top.y();
    rest.y() -= std::sin(heading) * top.x() + std::cos(heading) * top.y();
    return std::ranges::any_of(all, [&](const Quadric& q) { return is_inside(q, rest); });
  };
  int met = 0, wrong = 0;
  constexpr int rays = 400;
  for (int i = 0; i < rays; ++i) {
    const Vec3 to(6 * drawn(0, i) - 2, 8 * drawn(1, i) - 4, 10 * drawn(2, i));
    const Vec3 from = to + 25 * Vec3(drawn(3, i) - 0.5, drawn(4, i) - 0.5, drawn(5, i) - 0.3).normalized();
    const Vec3 direction = (to - from).normalized();
    RayShapeHit hit;
    const bool found = shape.hit(from.cast<float>(), direction.cast<float>(), 0, very_far, 1, hit);
    double marched = -1;
    for (double t = 0; t < 45 && marched < 0; t += 0.01) {
      if (inside(from + t * direction)) marched = t;
    }
    met += found;
    const double apart = found && marched >= 0 ? std::abs(static_cast<double>(hit.distance) - marched) : 9;
    if (found != (marched >= 0) || (found && apart > 0.03)) ++wrong;
    const Vec3 at = from + static_cast<double>(hit.distance) * direction;
    EXPECT_TRUE(!found || shape.bounds.contains(at.cast<float>()));
  }
  EXPECT_GT(met, rays / 4);
  EXPECT_LT(wrong, rays / 50) << "beside grazing rays";
}

// The page draws corners where place_in_wind says; rays meet the surface there.
TEST(ImpressionShape, IsMetWhereThePlaceOfARestingPlaceIs) {
  ImpressionistTree tree = ball();
  const ImpressionMotion motion = bending(tree, rocking(0.6F));
  const TrunkCurve curve = trunk_curve(motion);
  const Instance at{.position = {3, -2, 1}, .turn = 1.1, .scale = 2, .time_shift = 0.25};
  const double time = 1.4;
  const PosedRayShape shape = posed(tree, motion, time, at);
  for (int i = 0; i < 40; ++i) {
    const double z = 1.8 * drawn(7, i) - 0.9, angle = 2 * std::numbers::pi * drawn(8, i);
    const double r = std::sqrt(1 - z * z);
    const Vec3 on(2 * r * std::cos(angle), 1.5 * r * std::sin(angle), z);
    const Vec3 place = place_in_wind(motion, curve, at, Vec3(0, 0, 4) + on, time);
    Vec3 outwards = at.rotation() * Vec3(on.x() / 4, on.y() / 2.25, 0);
    outwards.normalize();
    RayShapeHit hit;
    ASSERT_TRUE(
        shape.hit((place + 10 * outwards).cast<float>(), (-outwards).cast<float>(), 0, very_far, 1, hit));
    EXPECT_NEAR(hit.distance, 10, 2e-3) << i;
  }
}

TEST(ImpressionShape, MovesItsSilhouetteByTheTrunksDisplacementAtItsHeight) {
  const ImpressionistTree tree = ball();
  ImpressionMotion motion = bending(tree, nullptr);
  motion.heading = 90;
  const double shift = 0.3 * std::pow(4 / tree.trunk_height, 2);
  const auto edge = [&](const PosedRayShape& shape) {  // along y, at the height of the middle
    double low = 0, high = 5;
    RayShapeHit hit;
    for (int i = 0; i < 40; ++i) {
      const double y = (low + high) / 2;
      const bool met = shape.hit({-20, static_cast<float>(y), 4}, Vector3f::UnitX(), 0, very_far, 1, hit);
      (met ? low : high) = y;
    }
    return low;
  };
  EXPECT_NEAR(edge(posed(tree)), 1.5, 1e-3);
  EXPECT_NEAR(edge(posed(tree, motion)), 1.5 + shift, 2e-3);
}

TEST(ImpressionShape, IsCoveredAsMuchAsItsNumbersSayAmidAndAtItsEdge) {
  ImpressionistTree tree = ball();
  tree.crown = {ellipsoid({0, 0, 4}, {2, 2, 2})};
  tree.trunk_height = 0.1;
  tree.texture = {.octaves = 5, .wavelength = 0.4};
  tree.cover = {.middle = 0.8F, .edge = 0.3F, .softness = 0.02F};
  const PosedRayShape shape = posed(tree);
  const auto share_met = [&](double radius) {  // of the front, before the leaves behind
    int met = 0;
    constexpr int rays = 4000;
    for (int i = 0; i < rays; ++i) {
      // Another line of sight each: a patch of one crown is no fair sample of space.
      const double angle = 2 * std::numbers::pi * drawn(0, i), about = 2 * std::numbers::pi * drawn(1, i);
      const Vec3 direction(std::cos(angle), std::sin(angle), 0), side(-direction.y(), direction.x(), 0);
      const Vec3 out = radius * (std::cos(about) * side + std::sin(about) * Vec3::UnitZ());
      const Vec3 from = Vec3(0, 0, 4) - 10 * direction + out;
      RayShapeHit hit;
      met += shape.hit(from.cast<float>(), direction.cast<float>(), 0, 10,
                       hash(static_cast<std::uint32_t>(i)), hit);
    }
    return met / static_cast<double>(rays);
  };
  EXPECT_NEAR(share_met(0.01), 0.8, 0.06);
  EXPECT_NEAR(share_met(1.99), 0.3, 0.06);
}

TEST(ImpressionShape, ClosesItsLoopBitForBitAndMovesWithinIt) {
  const ImpressionistTree tree = impressionist_tree("round", 6);
  ImpressionMotion motion = bending(tree, rocking(0.8F));
  motion.tremble = rocking(0.2F);
  TraceScene scene;
  scene.ray_shapes = {
      impression_shape(tree, {{.position = {0, 0, 0}}, {.position = {7, 3, 0}, .turn = 1}}, motion)};
  const Tracer tracer(scene);
  const auto at = [&](double time) {
    const Camera camera = look({-15, -10, 4}, {2, 1, 3}, 0.3);
    return tracer
        .trace([&](double) { return camera; }, time,
               {.width = 32, .height = 32, .samples = 2, .shutter = 0.02})
        .light;
  };
  const LinearImage first = at(0.7);
  EXPECT_EQ(first.rgb, at(0.7 + 4).rgb);
  EXPECT_EQ(first.rgb, at(0.7 - 8).rgb);
  EXPECT_GT(difference(first, at(2.1)), 0.01 * mean_of(first).mean());
}

TEST(ImpressionShape, TremblesAlongItsEnvelopeAndNotOutOfIt) {
  ImpressionistTree tree = ball();
  tree.crown = {ellipsoid({0, 0, 4}, {2, 2, 2})};
  tree.cover = {.middle = 0.5F, .edge = 0.5F, .softness = 1e-6F};
  const auto colors = [&](std::shared_ptr<const TravellingField> field) {
    ImpressionMotion motion;
    motion.tremble = std::move(field);
    const PosedRayShape shape = posed(tree, motion);
    std::vector<float> seen;
    for (int i = 0; i < 200; ++i) {  // from above: the normal is up
      RayShapeHit hit;
      const float x = 0.001F * static_cast<float>(i);
      const bool met = shape.hit({x, 0, 20}, -Vector3f::UnitZ(), 0, 15, 1, hit);
      seen.push_back(met ? hit.reflected.x() : 0);
    }
    return seen;
  };
  const std::vector<float> still = colors(nullptr), up = colors(always({0, 0, 0.3F})),
                           along = colors(always({0.05F, 0, 0}));
  double from_up = 0, from_along = 0, from_shifted = 0;
  for (std::size_t i = 0; i < 150; ++i) {
    from_up += static_cast<double>(std::abs(up[i] - still[i]));
    from_along += static_cast<double>(std::abs(along[i] - still[i]));
    from_shifted += static_cast<double>(std::abs(along[i + 50] - still[i]));  // 5 cm on
  }
  EXPECT_GT(from_along, 1);
  EXPECT_LT(from_up, 0.3 * from_along);
  EXPECT_LT(from_shifted, 0.3 * from_along);
}

TEST(ImpressionShape, ReachesAsFarAsItIsEverSeen) {
  const ImpressionistTree tree = impressionist_tree("poplar", 15);
  const auto shape =
      impression_shape(tree, {{.position = {3, 0, 0}}, {.position = {-40, 9, 1}}}, bending(tree, rocking(1)));
  for (int i = 0; i < 16; ++i) {
    for (const PosedRayShape& one : shape->pose(0.25 * i, 0.1))
      EXPECT_TRUE(shape->reach.contains(one.bounds));
  }
}

TEST(ImpressionShape, ThatIsNoneIsRefused) {
  const ImpressionistTree tree = impressionist_tree("round", 6);
  EXPECT_THROW(impression_shape(tree, {}), InputError);
  EXPECT_THROW(impression_shape(tree, {{.scale = 0}}), InputError);
  ImpressionistTree flat = tree;
  flat.crown[1].low = flat.crown[1].high = 2;
  EXPECT_THROW(impression_shape(flat, {{}}), InputError);
  ImpressionMotion without_trunk;
  without_trunk.sway = rocking(1);
  EXPECT_THROW(impression_shape(tree, {{}}, without_trunk), InputError);
  ImpressionMotion short_lean = bending(tree, nullptr);
  short_lean.lean.pop_back();
  EXPECT_THROW(impression_shape(tree, {{}}, short_lean), InputError);
}

}  // namespace
}  // namespace tremula
