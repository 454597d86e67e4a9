#include "tremula/deformation/drift_pose.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <tuple>
#include <vector>

#include <tbb/global_control.h>

#include "tremula/wind/point_wind.hpp"

namespace tremula {
namespace {

using Eigen::Vector3f;

constexpr TimeAxis loop_axis{.period = 5, .sample_count = 150};

std::shared_ptr<const DriftPaths> paths_of(const char* kind, double number_density, double lying_time = 0,
                                           double speed = 4) {
  Drift drift{
      .kind = drift_kind_named(kind), .low = {-6, -6, 0}, .high = {6, 6, 8}, .lying_time = lying_time};
  drift.kind.number_density = number_density;
  const Wind wind = turbulent_wind(mean_wind_over(terrain_named("grass"), speed), 0.2);
  return std::make_shared<const DriftPaths>(
      carry(gust_field(wind, loop_axis, plane_around(drift, 0)), drift));
}

Loop loop_of(const std::shared_ptr<const DriftPaths>& paths) {
  return make_loop(paths, {.name = "drift"}, look_of(paths->form));
}

struct Mesh {
  Vector3f middle;
  float extent;
};

std::vector<Mesh> meshes_at(const Loop& loop, double time) {
  const SurfaceDelta delta = loop.skin_at(time);
  EXPECT_EQ(delta.position.size(), loop.rest->vertex_count());
  const auto size = loop.rest->parts[0].pieces.size;
  std::vector<Mesh> meshes;
  for (std::size_t first = 0; first < delta.position.size(); first += size) {
    Vector3f low = Vector3f::Constant(1e9F), high = -low;
    for (std::size_t v = first; v < first + size; ++v) {
      const Vector3f place = loop.rest->position[v] + delta.position[v];
      EXPECT_TRUE(place.allFinite());
      EXPECT_NEAR((loop.rest->normal[v] + delta.normal[v]).norm(), 1, 1e-3);
      low = low.cwiseMin(place);
      high = high.cwiseMax(place);
    }
    meshes.push_back({0.5F * (low + high), (high - low).norm()});
  }
  return meshes;
}

constexpr float point = 2e-5F;  // [m] no mesh is as small, and no point as large

TEST(MakeLoopOfDrift, AtAllTimesTheMeshesAreThoseThatAreSeenWhereTheyAre) {
  const auto paths = paths_of("rain", 2, 0.5);
  const Loop loop = loop_of(paths);
  for (const double time : {0.0, 0.77, 2.5, 4.99}) {
    std::vector<Vector3f> expected, found;
    for (const DriftSight& one : drift_at(*paths, time)) expected.push_back(one.place);
    for (const Mesh& mesh : meshes_at(loop, time)) {
      if (mesh.extent > point) found.push_back(mesh.middle);
    }
    ASSERT_EQ(found.size(), expected.size());
    const auto by_place = [](const Vector3f& a, const Vector3f& b) {
      return std::tuple(std::lround(1e3F * a.x()), a.y()) < std::tuple(std::lround(1e3F * b.x()), b.y());
    };
    std::ranges::sort(expected, by_place);
    int near = 0;
    for (const Vector3f& place : found) {
      near +=
          std::ranges::any_of(expected, [&](const Vector3f& other) { return (place - other).norm() < 1e-4F; })
              ? 1
              : 0;
    }
    EXPECT_EQ(near, static_cast<int>(found.size()));
  }
}

TEST(MakeLoopOfDrift, ALoopLaterTheBitsAreTheSameForAllKinds) {
  for (const char* kind : {"snow", "rain", "leaves", "seeds"}) {
    const Loop loop = loop_of(paths_of(kind, 0.5, 1));
    for (const double time : {0.0, 1.3, 4.9}) {
      const SurfaceDelta now = loop.skin_at(time), later = loop.skin_at(time + loop.period);
      EXPECT_EQ(now.position, later.position);
      EXPECT_EQ(now.normal, later.normal);
    }
  }
}

// A mesh that is seen at either end of an open shutter is that of one path, and has moved no further than
// that may in the time.
TEST(MakeLoopOfDrift, NoMeshFliesFromWhereOneWentToWhereTheNextComes) {
  for (const char* kind : {"snow", "rain", "leaves", "seeds"}) {
    const Loop loop = loop_of(paths_of(kind, 1, 0.3));
    const double shutter = loop.period / loop.sample_count();
    const float most = 25 * static_cast<float>(shutter);
    int changes = 0;
    for (int i = 0; i < 60; ++i) {
      const double time = i * loop.period / 60;
      const std::vector<Mesh> open = meshes_at(loop, time - 0.5 * shutter);
      const std::vector<Mesh> shut = meshes_at(loop, time + 0.5 * shutter);
      for (std::size_t m = 0; m < open.size(); ++m) {
        const bool seen_first = open[m].extent > point, seen_last = shut[m].extent > point;
        changes += seen_first != seen_last ? 1 : 0;
        if (seen_first || seen_last) {
          EXPECT_LT((open[m].middle - shut[m].middle).norm(), most) << kind << time;
        }
      }
    }
    EXPECT_GT(changes, 50);
  }
}

TEST(ShareMeshes, TakesFewMoreMeshesThanAreSeenAtOnce) {
  for (const double pause : {0.02, 0.07}) {
    const auto paths = paths_of("rain", 4);
    std::vector<std::uint32_t> all(paths->paths.size());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::uint32_t>(i);
    const DriftStays stays = share_meshes(*paths, all, pause);
    double seen = 0, most = 0, sum = 0;
    for (int i = 0; i < 50; ++i) {
      seen = static_cast<double>(drift_at(*paths, 0.1 * i).size());
      most = std::max(most, seen);
      sum += seen / 50;
    }
    const double stay = sum * loop_axis.period / static_cast<double>(stays.stays.size());
    const auto meshes = static_cast<double>(stays.mesh_count());
    EXPECT_GE(meshes, most);
    EXPECT_LT(meshes, 1.1 * most * (1 + pause / stay));
  }
}

TEST(ShareMeshes, WhatIsSeenForLoopsGoesOnOnAnotherMesh) {
  DriftPaths paths;
  paths.loop = {.period = 2, .sample_count = 20};
  paths.off_line.assign(80, {0, 0, 0});
  DriftPath path;
  path.start = Vector3f(0, 0, 7);
  path.velocity = Vector3f(0, 0, -1);
  path.birth = 0.5F, path.air_time = 7, path.size = 0.01F, path.count = 80;
  paths.paths = {path};
  const DriftStays stays = share_meshes(paths, {0}, 0.2);
  for (const double time : {0.0, 0.35, 0.6, 1.1, 1.95}) {
    double expected = 0, found = 0;
    for (const DriftSight& one : drift_at(paths, time)) expected += static_cast<double>(one.age);
    for (const DriftStay& stay : stays.stays) {
      for (const double now : {time, time + 2}) {
        if (now >= static_cast<double>(stay.begin) && now < static_cast<double>(stay.end))
          found += now - static_cast<double>(stay.birth);
      }
    }
    EXPECT_NEAR(found, expected, 1e-5);
  }
}

TEST(MakeLoopOfDrift, InNoWindThereIsNoNumberThatIsNone) {
  for (const char* kind : {"snow", "rain", "leaves", "seeds"}) {
    Drift drift{.kind = drift_kind_named(kind), .low = {-6, -6, 0}, .high = {6, 6, 8}, .lying_time = 1};
    drift.kind.number_density = 0.5;
    TravellingField still;
    still.loop = loop_axis;
    still.mean = {Vec3::Zero()};
    still.values.resize(index_of(loop_axis.sample_count));
    const Loop loop = loop_of(std::make_shared<const DriftPaths>(carry(still, drift)));
    for (const double time : {0.0, 1.1, 3.3}) EXPECT_FALSE(meshes_at(loop, time).empty());
  }
}

TEST(MakeLoopOfDrift, TheBitsDoNotDependOnTheThreads) {
  const Loop loop = loop_of(paths_of("leaves", 2));
  const SurfaceDelta many = loop.skin_at(1.1);
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  const SurfaceDelta one = loop.skin_at(1.1);
  EXPECT_EQ(many.position, one.position);
  EXPECT_EQ(many.normal, one.normal);
}

TEST(MakeLoopOfDrift, ALeafThatHasLandedLiesFlat) {
  const auto paths = paths_of("leaves", 1, 3);
  const Loop loop = loop_of(paths);
  const SurfaceDelta delta = loop.skin_at(0.4);
  int lying = 0;
  const auto size = loop.rest->parts[0].pieces.size;
  for (std::size_t first = 0; first < delta.position.size(); first += size) {
    float low = 1e9F, high = -1e9F, extent = 0;
    for (std::size_t v = first; v < first + size; ++v) {
      const Vector3f place = loop.rest->position[v] + delta.position[v];
      low = std::min(low, place.z());
      high = std::max(high, place.z());
      extent = std::max(extent, (place - loop.rest->position[first] - delta.position[first]).norm());
    }
    if (extent > 0.01F && high < 0.03F) {
      ++lying;
      EXPECT_LT(high - low, 0.3F * extent);
    }
  }
  EXPECT_GT(lying, 20);
}

}  // namespace
}  // namespace tremula
