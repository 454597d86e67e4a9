#include "tremula/render/render.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "trees.hpp"
#include "tremula/base/error.hpp"

namespace tremula {
namespace {

using Eigen::Vector3f;

// Appends a rectangle of bark, or of leaf, with its middle, half its sides, and the normal of sides x and y.
void add_rectangle(Surface& surface, bool leaf, const Vector3f& middle, const Vector3f& x,
                   const Vector3f& y) {
  const auto first = static_cast<std::uint32_t>(surface.vertex_count());
  const Vector3f normal = x.cross(y).normalized();
  for (const auto& [s, t] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
    surface.position.emplace_back(middle + float(s) * x + float(t) * y);
    surface.normal.push_back(normal);
    surface.texture.emplace_back((s + 1) * 0.5F, (t + 1) * 0.5F);
    surface.branch.push_back(0);
    surface.along.push_back(0);
  }
  if (surface.parts.empty()) {
    const SurfaceOptions materials;
    surface.parts = {{materials.tube, {}}, {materials.leaf, {}}};
  }
  if (leaf) surface.parts[1].pieces = {.first_vertex = first, .size = 4, .count = 1};
  auto& triangles = surface.parts[leaf ? 1 : 0].triangles;
  triangles.insert(triangles.end(), {first, first + 1, first + 2, first, first + 2, first + 3});
}

Image render(const Surface& surface, const Camera& camera, const RenderOptions& options) {
  return render_surface(surface, surface.position, surface.normal, camera, options);
}

double brightness(const Image& image, const Camera& camera, const Vec3& point) {
  const auto seen = project(camera, point);
  const std::uint8_t* pixel = image.pixel(int(seen->x() * image.width), int(seen->y() * image.height));
  return pixel[0] + pixel[1] + pixel[2];
}

Surface tree_surface() {
  Skeleton skeleton = test::random_tree(120, 3);
  for (int k = 20; k < 120; ++k) {
    Leaf leaf;
    leaf.branch = k;
    leaf.base = skeleton.branches[std::size_t(k)].end;
    leaf.length = 0.12;
    leaf.width = 0.07;
    skeleton.leaves.push_back(leaf);
  }
  return mesh_surface(skeleton);
}

TEST(RenderSurface, CoversTheProjectedAreaOfARectangle) {
  Surface surface;
  add_rectangle(surface, false, {0, 0, 0}, {0, 1, 0}, {0, 0, 1});  // faces +x
  Camera camera;
  camera.eye = Vec3(4, 0, 0);
  camera.forward = -Vec3::UnitX();
  camera.right = Vec3::UnitY();
  camera.half_height = 0.5;
  const RenderOptions options{.width = 200, .height = 200, .draw_ground = false};
  const Image with = render(surface, camera, options);
  const Image without = render({}, camera, options);
  int changed = 0;
  for (int y = 0; y < 200; ++y) {
    for (int x = 0; x < 200; ++x) {
      const bool inside = x >= 50 && x < 150 && y >= 50 && y < 150;  // 1 m of 2 m to either side at 4 m
      const bool differs = !std::equal(with.pixel(x, y), with.pixel(x, y) + 3, without.pixel(x, y));
      if (differs) ++changed;
      EXPECT_EQ(differs, inside) << x << ' ' << y;
    }
  }
  EXPECT_EQ(changed, 100 * 100);
}

TEST(RenderSurface, HalfCoveredPixelsAreMixedInLinearLight) {
  Surface surface;
  add_rectangle(surface, false, {0, 0, 0}, {0, 1.01F, 0}, {0, 0, 1});  // its edges halve columns 49 and 150
  Camera camera;
  camera.eye = Vec3(4, 0, 0);
  camera.forward = -Vec3::UnitX();
  camera.right = Vec3::UnitY();
  camera.half_height = 0.5;
  const Image image =
      render(surface, camera, {.width = 200, .height = 200, .samples = 4, .draw_ground = false});
  const auto mean_of_column = [&](int x) {
    double sum = 0;
    for (int y = 60; y < 140; ++y) sum += std::pow((image.pixel(x, y)[2] / 255.0 + 0.055) / 1.055, 2.4) / 80;
    return sum;
  };
  const double sky = mean_of_column(48), bark = mean_of_column(51);
  EXPECT_GT(sky, 3 * bark);
  EXPECT_NEAR(mean_of_column(49), (sky + bark) / 2, 0.02 * sky);
  EXPECT_NEAR(mean_of_column(150), (sky + bark) / 2, 0.02 * sky);
}

TEST(RenderSurface, TheNearerThingHidesTheFarther) {
  for (const bool leaf_is_near : {true, false}) {
    Surface surface;
    add_rectangle(surface, false, {leaf_is_near ? 0.0F : 1.0F, 0, 1}, {0, 1, 0}, {0, 0, 1});
    add_rectangle(surface, true, {leaf_is_near ? 1.0F : 0.0F, 0, 1}, {0, 1, 0}, {0, 0, 1});
    const Camera camera = frame_extent({0, -1, 0}, {1, 1, 2}, 0, 0, 1);
    const Image image = render(surface, camera, {.width = 60, .height = 60});
    const std::uint8_t* middle = image.pixel(30, 30);
    EXPECT_EQ(middle[1] > middle[0], leaf_is_near);  // leaves are green, bark is brown
  }
}

TEST(RenderSurface, AThingCastsItsShadowWhereTheSunPutsIt) {
  const RenderOptions options{
      .width = 200, .height = 200, .sun_azimuth = 1.2, .sun_elevation = 0.9, .ground = 0};
  const Camera camera = frame_extent({-3, -3, 0}, {3, 3, 2}, 0, 0.6, 1);
  const Vec3 to_sun(std::cos(0.9) * std::cos(1.2), std::cos(0.9) * std::sin(1.2), std::sin(0.9));
  const Vec3 at(0.3, -0.2, 1.5);
  const Vec3 shadow = at - to_sun * at.z() / to_sun.z();
  Surface surface;
  add_rectangle(surface, false, at.cast<float>(), {0.3F, 0, 0}, {0, 0.3F, 0});
  const Image with = render(surface, camera, options);
  const Image without = render({}, camera, options);
  EXPECT_LT(brightness(with, camera, shadow), 0.8 * brightness(without, camera, shadow));
  // A metre beside there is none.
  for (const Vec3& beside : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(-1, 0, 0), Vec3(0, -1, 0)}) {
    EXPECT_GT(brightness(with, camera, shadow + beside), 0.9 * brightness(without, camera, shadow + beside));
  }
}

TEST(RenderSurface, AStemDarkensTheGroundAtItsFoot) {
  const Skeleton skeleton = test::straight_stem(1, 3, 0.1, 0.1);
  const Surface surface = mesh_surface(skeleton);
  const Camera camera = frame_extent({-1, -1, 0}, {1, 1, 0.5}, 0, 0.5, 1);
  // Sun overhead: no shadow, only less sky.
  const Image image =
      render(surface, camera, {.width = 300, .height = 300, .sun_elevation = std::numbers::pi / 2});
  double near = 0, far = 0;
  for (int i = 0; i < 8; ++i) {
    const double angle = -1.0 + 0.28 * i;  // the side towards the camera
    near += brightness(image, camera, {0.12 * std::cos(angle), 0.12 * std::sin(angle), 0});
    far += brightness(image, camera, {0.6 * std::cos(angle), 0.6 * std::sin(angle), 0});
  }
  EXPECT_LT(near, 0.95 * far);
}

TEST(RenderSurface, NothingIsDrawnIntoAPartOfAnotherName) {
  const Camera camera = frame_extent({-0.1, -1, 0}, {0.1, 1, 2}, 0, 0, 1);
  const auto picture = [&](const char* name, float stretch) {
    Surface surface;
    add_rectangle(surface, false, {0, 0, 1}, {0, 1, 0}, {0, 0, 1});
    surface.parts[0].material.name = name;
    surface.parts[0].material.color = {0.2F, 0.3F, 0.7F};
    for (Eigen::Vector2f& place : surface.texture) place *= stretch;
    return render(surface, camera, {.width = 60, .height = 60}).rgb;
  };
  EXPECT_EQ(picture("cloth", 1), picture("cloth", 3));
  EXPECT_NE(picture("bark", 1), picture("bark", 3));
  EXPECT_NE(picture("bark", 1), picture("cloth", 1));
  const std::vector<std::uint8_t> cloth = picture("cloth", 1);
  const std::size_t middle = 3 * (30 * 60 + 30);
  EXPECT_GT(cloth[middle + 2], cloth[middle]);  // blue, as its material says
}

TEST(RenderSurface, LeavesGlowYellowerAgainstTheSun) {
  Surface surface;
  add_rectangle(surface, true, {0, 0, 1}, {0, 1, 0}, {0, 0, 1});
  const Camera camera = frame_extent({-0.1, -1, 0}, {0.1, 1, 2}, 0, 0.1, 1);
  const auto color = [&](double sun_azimuth) {
    const Image image = render(surface, camera,
                               {.width = 60, .height = 60, .sun_azimuth = sun_azimuth, .sun_elevation = 0.4});
    const std::uint8_t* pixel = image.pixel(20, 30);
    return Vector3f(pixel[0], pixel[1], pixel[2]);
  };
  const Vector3f front = color(0), back = color(std::numbers::pi), edge = color(std::numbers::pi / 2);
  EXPECT_GT(back.y(), 1.3F * edge.y());  // the light comes through
  EXPECT_LT(back.z() / back.y(), front.z() / front.y());
}

TEST(RenderSurface, ALeafIsLitOnTheSideThatIsSeen) {
  const Camera camera = frame_extent({-0.1, -1, 0}, {0.1, 1, 2}, 0, 0.1, 1);
  const auto color = [&](float turn) {  // of a leaf with the sun behind the camera
    Surface surface;
    add_rectangle(surface, true, {0, 0, 1}, {0, turn, 0}, {0, 0, 1});
    const Image image =
        render(surface, camera, {.width = 60, .height = 60, .sun_azimuth = 0, .sun_elevation = 0.4});
    const std::uint8_t* pixel = image.pixel(20, 30);
    return Vector3f(pixel[0], pixel[1], pixel[2]);
  };
  const Vector3f upper = color(1), lower = color(-1);
  EXPECT_GE(lower.z() / lower.y(), upper.z() / upper.y());  // paler: not the yellow of light from behind
  EXPECT_GT(lower.y(), 0.8F * upper.y());
}

TEST(RenderSurface, NoTwoLeavesAreQuiteAlike) {
  Skeleton skeleton = test::straight_stem(1, 1, 0.01, 0.01);
  for (int i = 0; i < 2; ++i) {
    Leaf leaf;
    leaf.base = Vec3(0, 0.6 * i - 0.4, 0.5);
    leaf.axis = Vec3(0, 0, 1);
    leaf.normal = Vec3(1, 0, 0);
    leaf.length = leaf.width = 0.4;
    skeleton.leaves.push_back(leaf);
  }
  const Surface surface = mesh_surface(skeleton);
  const Camera camera = frame_extent({0, -1, 0}, {0, 1, 1.5}, 0, 0, 1);
  const Image image = render(surface, camera, {.width = 200, .height = 200});
  const double first = brightness(image, camera, {0.02, -0.3, 0.6});
  const double second = brightness(image, camera, {0.02, 0.3, 0.6});
  EXPECT_GT(std::abs(first - second), 3);
}

TEST(RenderSurface, DrawsThePositionsItIsGivenNotThoseAtRest) {
  const Surface surface = tree_surface();
  const Camera camera = frame_points(surface.position, 0.5, 0.1, 1);
  const RenderOptions options{.width = 80, .height = 80};
  std::vector<Vector3f> moved = surface.position;
  for (Vector3f& p : moved) p.x() += 0.1F * p.z();
  EXPECT_NE(render(surface, camera, options).rgb,
            render_surface(surface, moved, surface.normal, camera, options).rgb);
  EXPECT_EQ(render(surface, camera, options).rgb,
            render_surface(surface, surface.position, surface.normal, camera, options).rgb);
}

TEST(RenderSurface, IsTheSameOnAnyNumberOfThreads) {
  const Surface surface = tree_surface();
  const Camera camera = frame_points(surface.position, 0.5, 0.1, 1.5);
  std::vector<std::vector<std::uint8_t>> pictures;
  for (const std::size_t threads : {1, 2, 5}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    pictures.push_back(render(surface, camera, {.width = 180, .height = 120}).rgb);
  }
  EXPECT_EQ(pictures[1], pictures[0]);
  EXPECT_EQ(pictures[2], pictures[0]);
}

TEST(RenderSurface, AnEmptySurfaceShowsSkyAndGround) {
  const Camera camera = frame_extent({-1, -1, 0}, {1, 1, 2}, 0, 0.1, 1);
  const Image image = render({}, camera, {.width = 50, .height = 50});
  const std::uint8_t* sky = image.pixel(25, 2);
  const std::uint8_t* ground = image.pixel(25, 47);
  EXPECT_GT(sky[2], sky[0]);
  EXPECT_GT(ground[1], ground[2]);
}

TEST(RenderSurface, WhatIsBehindTheCameraDoesNotShow) {
  Surface surface;
  add_rectangle(surface, false, {9, 0, 0}, {0, 1, 0}, {0, 0, 1});
  Camera camera;
  camera.eye = Vec3(4, 0, 0);
  camera.forward = -Vec3::UnitX();
  camera.right = Vec3::UnitY();
  const RenderOptions options{.width = 40, .height = 40, .draw_ground = false};
  EXPECT_EQ(render(surface, camera, options).rgb, render({}, camera, options).rgb);
}

TEST(RenderSurface, ACameraInsideTheTreeStillGivesAPicture) {
  const Surface surface = tree_surface();
  Camera camera;
  camera.eye = Vec3(0, 0, 1);
  EXPECT_EQ(render(surface, camera, {.width = 40, .height = 40}).rgb.size(), 4800U);
}

TEST(RenderSurface, DegenerateTrianglesAndNormalsGiveAPicture) {
  Surface surface;
  add_rectangle(surface, false, {0, 0, 1}, {0, 0, 0}, {0, 0, 1});  // no area
  add_rectangle(surface, false, {0, 0, 1}, {0, 1e-20F, 0}, {0, 0, 1e-20F});
  add_rectangle(surface, false, {0, 0, 1}, {0, 1, 0}, {0, 0, 1});
  surface.texture.assign(surface.vertex_count(), {0.5F, 3e37F});
  surface.normal.assign(surface.vertex_count(), Vector3f::Zero());
  const Camera camera = frame_extent({0, -1, 0}, {0, 1, 2}, 0, 0, 1);
  EXPECT_EQ(render(surface, camera, {.width = 40, .height = 40}).rgb.size(), 4800U);
}

TEST(RenderSurface, MoreExposureIsBrighter) {
  const Surface surface = tree_surface();
  const Camera camera = frame_points(surface.position, 0.5, 0.1, 1);
  const auto sum = [&](double exposure) {
    double total = 0;
    for (const auto c : render(surface, camera, {.width = 60, .height = 60, .exposure = exposure}).rgb)
      total += c;
    return total;
  };
  EXPECT_LT(sum(0.5), sum(1));
  EXPECT_LT(sum(1), sum(2));
}

std::string error_of(const Surface& surface, const std::vector<Vector3f>& positions,
                     const std::vector<Vector3f>& normals,
                     const RenderOptions& options = {.width = 20, .height = 20}) {
  try {
    render_surface(surface, positions, normals, frame_extent({0, 0, 0}, {1, 1, 1}, 0, 0, 1), options);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(RenderSurface, RefusesWhatIsNotASurface) {
  Surface surface;
  add_rectangle(surface, false, {0, 0, 1}, {0, 1, 0}, {0, 0, 1});
  EXPECT_EQ(error_of(surface, surface.position, surface.normal), "no error");
  std::vector<Vector3f> broken = surface.position;
  broken[2].y() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(error_of(surface, broken, surface.normal),
            "surface to render: vertex 2: a number that is not finite or above 1e7 m, wanted finite numbers");
  EXPECT_NE(error_of(surface, surface.position, broken), "no error");
  broken[2].y() = 1e30F;
  EXPECT_NE(error_of(surface, broken, surface.normal), "no error");
  broken.pop_back();
  EXPECT_EQ(error_of(surface, broken, surface.normal),
            "surface to render: 3 positions, 4 normals and 4 texture coordinates, wanted 4 each");
  surface.parts[1].triangles = {0, 1, 4};
  EXPECT_EQ(error_of(surface, surface.position, surface.normal),
            "surface to render: index 4, wanted one below 4");
  surface.parts[1].triangles = {0, 1};
  EXPECT_EQ(error_of(surface, surface.position, surface.normal),
            "surface to render: 2 indices, wanted 3 per triangle");
}

TEST(RenderSurface, RefusesOptionsOutOfRange) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const RenderOptions& options :
       {RenderOptions{.width = 0}, RenderOptions{.height = 100000}, RenderOptions{.samples = 0},
        RenderOptions{.samples = 9}, RenderOptions{.shadow_map = 1}, RenderOptions{.sun_azimuth = nan},
        RenderOptions{.sun_elevation = -0.1}, RenderOptions{.exposure = 0}, RenderOptions{.ground = nan},
        RenderOptions{.width = 300, .height = 200}}) {
    EXPECT_NE(error_of({}, {}, {}, options), "no error");
  }
}

}  // namespace
}  // namespace tremula
