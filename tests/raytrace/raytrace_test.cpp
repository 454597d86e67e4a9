#include "tremula/raytrace/raytrace.hpp"

#include "raytrace/simple_scenes.hpp"

#include "tremula/base/error.hpp"
#include "tremula/raytrace/grass.hpp"
#include "tremula/raytrace/posed_scene.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <map>

#include <tbb/global_control.h>

namespace tremula {
namespace {

using namespace simple;
using Eigen::Vector3f;

TraceScene wood() {
  TraceScene scene;
  const auto loop = loop_of(cloud("leaf", 0.3F, 300), [](double t) {
    return Vector3f(0.2F * static_cast<float>(std::sin(std::numbers::pi * t)), 0, 0);
  });
  loop->instances.clear();
  for (int i = 0; i < 9; ++i) {
    loop->instances.push_back({.position = {2.5 * (i % 3), 2.5 * (i / 3), 1.2},
                               .turn = 0.7 * i,
                               .scale = 1 - 0.05 * i,
                               .time_shift = 0.11 * i});
  }
  scene.loops = {loop};
  scene.poses_per_loop = 4;
  return scene;
}

const Camera over_wood = look({-6, -2, 4}, {2, 2, 0.5}, 0.5);

TEST(Tracer, GivesTheSameBytesOnAnyNumberOfThreads) {
  const TraceOptions options{.width = 48, .height = 40, .samples = 4, .shutter = 0.05};
  std::vector<LinearImage> seen;
  for (const std::size_t threads : {1U, 2U, 7U}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    seen.push_back(picture(wood(), over_wood, options, 0.3).light);
  }
  EXPECT_EQ(seen[0].rgb, seen[1].rgb);
  EXPECT_EQ(seen[0].rgb, seen[2].rgb);
}

TEST(Tracer, TakesOtherSamplesWithAnotherSeedAndAgreesWithThem) {
  TraceOptions options{.width = 32, .height = 32, .samples = 64};
  const TracedImage one = picture(wood(), over_wood, options);
  options.seed = 2;
  const TracedImage two = picture(wood(), over_wood, options);
  EXPECT_NE(one.light.rgb, two.light.rgb);
  EXPECT_LT((mean_of(one.light) - mean_of(two.light)).norm(), 0.02 * mean_of(one.light).norm());
}

TEST(Tracer, ShowsCopiesAsItShowsAsManyMeshes) {
  TraceScene scene = wood();
  scene.poses_per_loop = 100;
  TraceScene apart = scene;
  apart.loops.clear();
  for (const Instance& copy : scene.loops[0]->instances) {
    Loop loop = *scene.loops[0];
    loop.instances = {copy};
    apart.loops.push_back(std::make_shared<const Loop>(loop));
  }
  const TraceOptions options{.width = 40, .height = 40, .samples = 64, .shutter = 0.1};
  const TracedImage together = picture(scene, over_wood, options, 0.4),
                    alone = picture(apart, over_wood, options, 0.4);
  EXPECT_LT(difference(together.albedo, alone.albedo), 2e-4);
  EXPECT_LT(difference(together.light, alone.light), 0.01 * mean_of(alone.light).mean());
}

TEST(Tracer, TurnsTheNormalsOfACopyThatIsAloneAsThoseOfManyCopies) {
  const auto still = [](double) { return Vector3f(0, 0, 0); };
  const auto alone = loop_of(sphere("timber", 0.5F, 1), still),
             beside = loop_of(sphere("timber", 0.5F, 1), still);
  const Instance turned{.position = {0, 0, 2}, .turn = 2.1};
  alone->instances = {turned};
  beside->instances = {turned, {.position = {500, 0, 2}}};
  const Camera camera = look({-5, 0, 2}, {0, 0, 2}, 0.3);
  const TraceOptions options{.width = 24, .height = 24, .samples = 32};
  const TracedImage one = picture(in_uniform_sky({alone}), camera, options),
                    both = picture(in_uniform_sky({beside}), camera, options);
  EXPECT_LT(difference(one.normal, both.normal), 1e-3);
  EXPECT_LT(difference(one.light, both.light), 1e-3);
}

TEST(Tracer, TintsTheGroundAsItIsAtTheTimeOfThePicture) {
  TraceScene scene = in_uniform_sky({loop_of(sphere("timber", 0.5F, 1))});
  scene.ground = {.kind = GroundKind::plain, .height = -2};
  scene.ground.tint = [](const Eigen::Vector2f& place, double time) {
    return Eigen::Vector4f(place.x() > 0 ? 0.3F : 0.1F, 0.1F * static_cast<float>(time), 0.2F, 1);
  };
  for (const double time : {1.0, 4.0}) {
    const TracedImage seen =
        picture(scene, look({0.1, 0, 9}, {0, 0, -2}, 0.8), {.width = 16, .height = 16, .samples = 4}, time);
    for (const auto& [x, y] : {std::pair{0, 0}, std::pair{15, 15}, std::pair{0, 15}, std::pair{15, 0}}) {
      const auto* albedo = seen.albedo.pixel(x, y);
      EXPECT_NEAR(albedo[1], 0.1 * time, 1e-5);
      EXPECT_TRUE(std::abs(albedo[0] - 0.3F) < 1e-5F || std::abs(albedo[0] - 0.1F) < 1e-5F);
    }
    EXPECT_NE(seen.albedo.pixel(0, 0)[0] + seen.albedo.pixel(15, 0)[0] + seen.albedo.pixel(0, 15)[0],
              3 * seen.albedo.pixel(15, 15)[0]);
  }
}

TEST(Tracer, BlursMotionAsTheMeanOfManySharpFramesDoes) {
  Surface board = surface_of("timber", 0.2F, false);
  add_quad(board, {0, -0.5F, -0.5F}, {0, 1, 0}, {0, 0, 1});
  const auto swing = [](double t) {
    return Vector3f(0, static_cast<float>(std::sin(std::numbers::pi * t)), 0.3F * static_cast<float>(t));
  };
  const TraceScene scene = in_uniform_sky({loop_of(board, swing)});
  const Camera camera = look({-5, 0, 0}, Vec3::Zero(), 0.4);
  const double shutter = 0.4, time = 0.25;
  const LinearImage blurred =
      picture(scene, camera, {.width = 24, .height = 24, .samples = 1024, .shutter = shutter}, time).light;
  LinearImage mean = blurred;
  std::fill(mean.rgb.begin(), mean.rgb.end(), 0.0F);
  constexpr int frames = 64;
  const Tracer tracer(scene);
  for (int i = 0; i < frames; ++i) {
    const double at = time + shutter * ((i + 0.5) / frames - 0.5);
    const TracedImage sharp =
        tracer.trace([&](double) { return camera; }, at, {.width = 24, .height = 24, .samples = 64});
    for (std::size_t k = 0; k < mean.rgb.size(); ++k) mean.rgb[k] += sharp.light.rgb[k] / frames;
  }
  EXPECT_LT(difference(blurred, mean), 0.004);
  const LinearImage still = picture(scene, camera, {.width = 24, .height = 24, .samples = 64}, time).light;
  EXPECT_GT(difference(blurred, still), 0.012) << "nothing was blurred";
}

TEST(Tracer, BlursTheMotionOfTheCamera) {
  Surface board = surface_of("timber", 0, false);
  add_quad(board, {0, 0, -5}, {0, 10, 0}, {0, 0, 10});  // dark where y > 0
  const auto moving = [](double t) { return look({-5, t, 0}, {0, t, 0}, 0.4); };
  const TracedImage seen = Tracer(in_uniform_sky({loop_of(board)}))
                               .trace(moving, 0, {.width = 16, .height = 16, .samples = 256, .shutter = 2});
  // The edge is seen between 1 m left and 1 m right of the middle, of 2 m: a ramp over half the picture.
  EXPECT_NEAR(seen.light.pixel(8, 8)[0], 0.5, 0.07);
  for (const int x : {5, 10})
    EXPECT_TRUE(seen.light.pixel(x, 8)[0] > 0.1F && seen.light.pixel(x, 8)[0] < 0.9F);
  EXPECT_NEAR(seen.light.pixel(1, 8)[0] + seen.light.pixel(14, 8)[0], 1, 1e-3);
}

// The edge of a dark half plane through a lens: a point of the picture sees the lens cut by a line, so that
// the light that is on the wrong side is 4 R / (3 pi) pixels for a circle of confusion of radius R.
double wrong_side(double distance, const Lens& lens) {
  Surface board = surface_of("timber", 0, false);
  const auto far = static_cast<float>(distance);
  add_quad(board, {far, 0, -50}, {0, 50, 0}, {0, 0, 100});
  constexpr int width = 64;
  const TracedImage seen =
      picture(in_uniform_sky({loop_of(board)}), look(Vec3::Zero(), {1, 0, 0}, 0.1, width / 4.0),
              {.width = width, .height = 4, .samples = 4096, .lens = lens});
  double sum = 0;
  for (int x = 0; x < width; ++x) {
    const auto light = static_cast<double>(seen.light.pixel(x, 2)[0]);
    sum += x < width / 2 ? light : 1 - light;
  }
  return std::min(sum, width - sum);
}

TEST(Lens, IsSharpInItsFocusAndBlursByItsCircleOfConfusionElsewhere) {
  const double pinhole = wrong_side(4, {});
  EXPECT_LT(pinhole, 0.25) << "the filter's own width";
  const Lens lens{.radius = 0.2, .focus_distance = 4};
  EXPECT_NEAR(wrong_side(4, lens), pinhole, 0.01);
  const double pixels = 4 / (2 * 0.1);  // a unit of the picture at distance 1
  for (const double distance : {2.0, 12.0}) {
    const double circle = lens.radius * std::abs(1 / lens.focus_distance - 1 / distance) * pixels;
    EXPECT_NEAR(wrong_side(distance, lens), 4 * circle / (3 * std::numbers::pi), 0.13) << distance;
  }
}

TEST(Tracer, TellsADenoiserWhatIsSeenFirst) {
  Surface board = surface_of("timber", 0.25F, false);
  add_quad(board, {1, 1, -5}, {0, -6, 0}, {0, 0, 10});  // towards -x, and no farther left than 1 m
  const TracedImage seen = picture(in_uniform_sky({loop_of(board)}), look(Vec3::Zero(), {1, 0, 0}, 2),
                                   {.width = 16, .height = 16, .samples = 4});
  const auto rgb = [](const LinearImage& image, int x) {
    return Vector3f(Eigen::Map<const Vector3f>(image.pixel(x, 8)));
  };
  EXPECT_LT((rgb(seen.albedo, 12) - Vector3f::Constant(0.25F)).norm(), 1e-3F);
  EXPECT_LT((rgb(seen.normal, 12) - Vector3f(-1, 0, 0)).norm(), 1e-3F);
  EXPECT_EQ(rgb(seen.albedo, 1), Vector3f(1, 1, 1));
  EXPECT_EQ(rgb(seen.normal, 1), Vector3f(0, 0, 0));
}

TEST(Tracer, SeesTheSkyAloneWithoutBounces) {
  Surface board = surface_of("timber", 0.9F, false);
  add_quad(board, {1, 50, -50}, {0, -100, 0}, {0, 0, 100});
  const TraceScene scene = in_uniform_sky({loop_of(board)});
  const auto seen = [&](double x) {
    return mean_of(
        picture(scene, look(Vec3::Zero(), {x, 0, 0}), {.width = 4, .height = 4, .samples = 4, .bounces = 0})
            .light)[0];
  };
  EXPECT_EQ(seen(1), 0);
  EXPECT_EQ(seen(-1), 1);
}

TEST(Tracer, CountsAndTellsHowFarItIsAndStopsWhenThatThrows) {
  const Tracer tracer(wood());
  TraceCounts counts;
  std::vector<double> told;
  const auto camera = [](double) { return over_wood; };
  const TraceOptions options{.width = 64, .height = 32, .samples = 1};
  tracer.trace(
      camera, 0, options, [&](double share) { told.push_back(share); }, &counts);
  EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
  EXPECT_EQ(told.back(), 1);
  EXPECT_GE(counts.rays, 64U * 32U);
  EXPECT_EQ(counts.instances, 9U);
  EXPECT_EQ(counts.triangles, 9 * wood().loops[0]->rest->parts[0].triangles.size() / 3);
  struct Stop {};
  EXPECT_THROW(tracer.trace(camera, 0, options, [](double) { throw Stop(); }), Stop);
}

TEST(Tracer, HoldsFewerPosesOfALoopWhereTheyWouldBeTooMuch) {
  TraceScene scene = wood();
  Loop loop = *scene.loops[0];
  for (std::size_t i = 0; i < 9; ++i) loop.instances[i].time_shift = loop.period * static_cast<double>(i) / 9;
  scene.loops = {std::make_shared<const Loop>(std::move(loop))};
  const auto poses_of = [](const TraceScene& traced) {
    TraceCounts counts;
    Tracer(traced).trace([](double) { return over_wood; }, 0, {.width = 8, .height = 8, .samples = 1}, {},
                         &counts);
    return counts.poses;
  };
  EXPECT_EQ(poses_of(scene), 4U);
  const double triangles = static_cast<double>(scene.loops[0]->rest->parts[0].triangles.size()) / 3;
  scene.posed_triangles = 3.5 * triangles;
  EXPECT_EQ(poses_of(scene), 3U);
  scene.posed_triangles = 1;
  EXPECT_EQ(poses_of(scene), 2U) << "or nothing would move against anything else";
}

TEST(Tracer, RefusesWhatItCannotTrace) {
  const auto fails = [](const std::string& with, TraceScene scene, const TraceOptions& options,
                        const Camera& camera = over_wood) {
    try {
      picture(scene, camera, options);
      ADD_FAILURE() << "accepted; wanted " << with;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr(with));
    }
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  fails("width of the picture: 0, wanted 1 to 16384", wood(), {.width = 0});
  fails("height of the picture: 16385, wanted", wood(), {.height = 16385});
  fails("samples of a pixel: 0, wanted 1 to 65536", wood(), {.samples = 0});
  fails("bounces of light: 65, wanted 0 to 64", wood(), {.bounces = 65});
  fails("shutter: nan, wanted", wood(), {.shutter = nan});
  fails("radius of the lens: -1.0", wood(), {.lens = {.radius = -1}});
  fails("distance of focus: 0.0", wood(), {.lens = {.focus_distance = 0}});
  fails("camera: height of the eye: -1.0", wood(), {}, look({-5, 0, -1}, Vec3::Zero()));
  fails("camera: a number that is not finite", wood(), {}, look({nan, 0, 1}, Vec3::Zero()));
  TraceScene scene = wood();
  scene.poses_per_loop = 0;
  fails("poses of a loop: 0, wanted 1 to 4096", scene, {});
  scene = wood();
  scene.haze.extinction[1] = -1;
  fails("extinction of the haze", scene, {});
  scene = wood();
  scene.ground.color[2] = 2;
  fails("colour of the ground", scene, {});
  scene = wood();
  scene.ground.grass_height = 1.5;
  fails("height of the grass: 1.5", scene, {});
  scene = in_uniform_sky({nullptr});
  fails("loops of the scene", scene, {});
  scene = in_uniform_sky({loop_of(Surface{})});
  fails("no vertices", scene, {});
  Surface odd = cloud("leaf", 0.5F, 10);
  odd.parts[0].triangles[4] = 100000;
  scene = in_uniform_sky({loop_of(odd)});
  fails("a corner at vertex 100000", scene, {});
}

TEST(Poses, KeepTimeShiftsWhileTheyAreFewAndElseRoundThemToPartsOfThePeriod) {
  const auto loop = loop_of(cloud("leaf", 0.5F, 10));  // a period of 2 s
  loop->instances.clear();
  for (const double shift : {0.3, -0.26, 0.3, 1.99, 5.1}) loop->instances.push_back({.time_shift = shift});
  const LoopShape exact = shape_of(loop, 4);
  EXPECT_EQ(exact.shifts.size(), 4U);
  for (std::size_t i = 0; i < loop->instances.size(); ++i)
    EXPECT_EQ(exact.shifts[exact.pose_of_copy[i]], loop->instances[i].time_shift);
  const LoopShape rounded = shape_of(loop, 3);
  EXPECT_LE(rounded.shifts.size(), 3U);
  for (std::size_t i = 0; i < loop->instances.size(); ++i) {
    const double off =
        std::remainder(rounded.shifts[rounded.pose_of_copy[i]] - loop->instances[i].time_shift, 2.0);
    EXPECT_LE(std::abs(off), 2.0 / 3 / 2 + 1e-12);
  }
}

// Tiles of two cameras that see the same ground.
TEST(Grass, StandsWhereItStoodWhenTheCameraMoves) {
  const GroundLook ground{.kind = GroundKind::grass, .grass_height = 0.1};
  const auto tiles = grass_tiles(ground.grass_height);
  const auto turns = [&](const Camera& camera) {
    std::map<std::pair<double, double>, double> found;
    for (const LoopShape& shape : grass_before(camera, ground, tiles)) {
      for (const Instance& each : shape.loop->instances)
        EXPECT_TRUE(found.emplace(std::pair(each.position.x(), each.position.y()), each.turn).second);
    }
    return found;
  };
  const auto here = turns(look({0, 0, 1.5}, {5, 0, 1})), there = turns(look({0.7, 2, 1.5}, {5, 3, 1}));
  int both = 0;
  for (const auto& [place, turn] : here) {
    const auto same = there.find(place);
    if (same == there.end()) continue;
    EXPECT_EQ(same->second, turn);
    ++both;
  }
  EXPECT_GT(both, 500);
}

TEST(Grass, IsOfAboutTheColourOfTheGroundItStandsOn) {
  TraceScene scene = in_uniform_sky({});
  scene.ground.kind = GroundKind::grass;
  const Camera camera = look({0, 0, 1.6}, {6, 0, 0}, 0.2, 2);
  const TraceOptions options{.width = 48, .height = 24, .samples = 64};
  const Eigen::Vector3d flat = mean_of(picture(scene, camera, options).albedo);
  scene.ground.grass_height = 0.12;
  TraceCounts counts;
  const TracedImage seen = Tracer(scene).trace([&](double) { return camera; }, 0, options, {}, &counts);
  EXPECT_GT(counts.instances, 100U);
  const Eigen::Vector3d blades = mean_of(seen.light);
  EXPECT_GT(blades.minCoeff() / flat.minCoeff(), 0.5);
  EXPECT_LT(blades[1], 1.3 * flat[1]);
  EXPECT_GT(blades[1], blades[0]);
  EXPECT_GT(blades[0], blades[2]);
}

TEST(Ground, IsSeenFromAboveAloneAndHidesWhatIsBelow) {
  TraceScene scene = in_uniform_sky({loop_of(sphere("timber", 0, 0.5F))});  // half of it below
  scene.ground = {.kind = GroundKind::plain, .color = {1, 1, 1}};
  const TracedImage seen =
      picture(scene, look({0, 0, 5}, Vec3::Zero(), 0.3), {.width = 32, .height = 32, .samples = 64});
  scene.loops = {loop_of(sphere("timber", 0, 0.5F))};
  EXPECT_LT(seen.light.pixel(16, 16)[0], 0.01);
  EXPECT_GT(seen.light.pixel(0, 0)[0], 0.9);
  EXPECT_LT(seen.light.pixel(0, 0)[0], 1);
}

}  // namespace
}  // namespace tremula
