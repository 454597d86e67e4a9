#include "tremula/deformation/grass_pose.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

#include <tbb/global_control.h>

#include "tremula/base/error.hpp"
#include "tremula/wind/point_wind.hpp"

namespace tremula {
namespace {

using Eigen::Vector3f;

TravellingField gusts_of(double speed, int samples = 256, double height = 0.5) {
  const Wind wind(turbulent_wind({.speed = speed, .heading = 20}, 0.3));
  const std::vector<Vec3> corners = {Vec3(-3, -3, 0), Vec3(3, 3, 0), Vec3(-3, 3, 0), Vec3(3, -3, 0)};
  return gust_field(wind, TimeAxis{10, samples}, plane_across(corners, 20, 0.5, {height}));
}

Meadow patch(const char* species, double side = 1) {
  return sow(grass_species_named(species), {.low = {-side / 2, -side / 2}, .high = {side / 2, side / 2}});
}

struct Skin {
  std::vector<Vector3f> positions, normals;
  Skin(const GrassInWind& grass, double time) : positions(grass.all_vertices), normals(grass.all_vertices) {
    pose_grass(grass, time, positions, normals);
  }
};

// The middle line of a flat blade, from its pairs of vertices.
std::vector<Vec3> middle_of(const GrassInWind& grass, std::size_t blade,
                            const std::vector<Vector3f>& positions) {
  std::vector<Vec3> middle;
  const std::uint32_t first = grass.first_vertex[blade];
  const int pieces = grass.meadow.species.kinds[grass.meadow.kind[blade]].pieces;
  for (int joint = 0; joint < pieces; ++joint) {
    const auto at = first + 2 * static_cast<std::uint32_t>(joint);
    middle.emplace_back(0.5 * (positions[at] + positions[at + 1]).cast<double>());
  }
  middle.emplace_back(positions[first + 2 * static_cast<std::uint32_t>(pieces)].cast<double>());
  return middle;
}

TEST(PoseGrass, KeepsTheLengthOfEveryBladeInAGale) {
  const GrassInWind grass = put_in_wind(patch("meadow"), gusts_of(25));
  double most_sway = 0;
  for (const double time : {0.0, 3.1, 7.77}) {
    const Skin skin(grass, time);
    for (std::size_t i = 0; i < grass.blade_count(); ++i) {
      if (grass.meadow.kind[i] != 0) continue;
      const std::vector<Vec3> middle = middle_of(grass, i, skin.positions);
      double length = 0;
      for (std::size_t j = 1; j < middle.size(); ++j) length += (middle[j] - middle[j - 1]).norm();
      EXPECT_NEAR(length, static_cast<double>(grass.meadow.length[i]), 1e-5);
      most_sway = std::max(most_sway, angles_of(grass, i, time).norm());
    }
  }
  EXPECT_GT(most_sway, 2);
}

// The table and its interpolation against the rod itself.
TEST(PoseGrass, BendsBladesAsTheirHeavyRodsDo) {
  const TravellingField gusts = gusts_of(9);
  const GrassInWind grass = put_in_wind(patch("meadow"), gusts);
  const double height = grass.meadow.height, time = 4.2;
  const BladeResponse nominal =
      blade_response(grass.meadow.species, 0, 1, height, statistics_at(gusts, height));
  const Skin skin(grass, time);
  int compared = 0;
  for (std::size_t i = 0; i < grass.blade_count() && compared < 40; i += 37) {
    if (grass.meadow.kind[i] != 0) continue;
    ++compared;
    const Eigen::Vector2d angles =
        in_axes_of_blade(static_cast<double>(grass.meadow.azimuth[i]), angles_of(grass, i, time));
    const RodDrag drag{angles.norm() * nominal.load.along, angles.norm() * nominal.load.tip,
                       nominal.load.decay};
    const Eigen::Matrix3Xd bent =
        bend_rod(nominal.rod, trajectory(grass.meadow.species.kinds[0], grass.meadow.trajectory[i], 20), drag,
                 Vec3(angles.x(), angles.y(), 0) / angles.norm());
    // In three straight pieces, which are longer from end to end than the arcs they stand for.
    Vec3 tip = Vec3::Zero();
    const std::vector<double> joints = joints_of(grass.meadow.species.kinds[0]);
    for (std::size_t j = 1; j < joints.size(); ++j) {
      const auto first = std::lround(20 * joints[j - 1]), count = std::lround(20 * joints[j]) - first;
      tip += (joints[j] - joints[j - 1]) * bent.middleCols(first, count).rowwise().sum().normalized();
    }
    tip.head<2>() = in_axes_of_blade(-static_cast<double>(grass.meadow.azimuth[i]), tip.head<2>());
    const std::vector<Vec3> middle = middle_of(grass, i, skin.positions);
    const Vec3 drawn = (middle.back() - middle.front()) / static_cast<double>(grass.meadow.length[i]);
    EXPECT_LT((drawn - tip).norm(), 0.03) << angles.transpose();
  }
  EXPECT_GT(compared, 20);
}

TEST(PoseGrass, LeansWithTheWindAndMoreInMoreWind) {
  double before = -1;
  for (const double speed : {0.5, 5.0, 15.0}) {
    const GrassInWind grass = put_in_wind(patch("wheat"), gusts_of(speed, 256, 0.75));
    Eigen::Vector2d lean = Eigen::Vector2d::Zero();
    for (std::size_t i = 0; i < grass.blade_count(); ++i) {
      for (int p = 0; p < 20; ++p) lean += angles_of(grass, i, 0.5 * p) / 20;
    }
    lean /= static_cast<double>(grass.blade_count());
    EXPECT_GT(lean.norm(), before);
    before = lean.norm();
    if (speed > 1) {
      EXPECT_NEAR(std::atan2(lean.y(), lean.x()), 20 * 3.14159265 / 180, 0.3);
    }
  }
}

TEST(PoseGrass, IsTheSameAfterALoopAndOnOneThread) {
  const GrassInWind grass = put_in_wind(patch("rice"), gusts_of(8));
  const auto bytes_at = [&](double time) {
    const Skin skin(grass, time);
    std::string bytes(24 * skin.positions.size(), '\0');
    std::memcpy(bytes.data(), skin.positions.data(), bytes.size() / 2);
    std::memcpy(bytes.data() + bytes.size() / 2, skin.normals.data(), bytes.size() / 2);
    return bytes;
  };
  for (int p = 0; p < 256; p += 51) EXPECT_EQ(bytes_at(10.0 * p / 256), bytes_at(10.0 * p / 256 + 10));
  const std::string many = bytes_at(2.3);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(many, bytes_at(2.3));
}

Meadow without_first_plant(const Meadow& all) {
  std::size_t first = 1;
  while (all.attached[first] >= 0) ++first;
  Meadow rest;
  rest.species = all.species;
  rest.height = all.height;
  const auto drop = [&](const auto& from, auto& to) {
    to.assign(from.begin() + static_cast<std::ptrdiff_t>(first), from.end());
  };
  drop(all.x, rest.x), drop(all.y, rest.y), drop(all.z, rest.z);
  drop(all.length, rest.length), drop(all.width, rest.width);
  drop(all.azimuth, rest.azimuth), drop(all.facing, rest.facing), drop(all.attached, rest.attached);
  drop(all.kind, rest.kind), drop(all.trajectory, rest.trajectory);
  drop(all.frequency_class, rest.frequency_class);
  return rest;
}

// Blades are posed many at a time: who else is among them, and what else is asked for, changes no bit.
TEST(PoseGrass, PutsABladeWhereItGoesWhoeverElseIsThere) {
  for (const char* species : {"lawn", "meadow", "wheat"}) {
    SCOPED_TRACE(species);
    const TravellingField gusts = gusts_of(9, 64);
    const Meadow meadow = patch(species, 0.4), fewer = without_first_plant(meadow);
    const GrassInWind all = put_in_wind(meadow, gusts), rest = put_in_wind(fewer, gusts);
    const Skin of_all(all, 3.7), of_rest(rest, 3.7);
    std::vector<Vector3f> places_alone(rest.all_vertices);
    pose_grass(rest, 3.7, places_alone, {});
    const std::size_t dropped = all.blade_count() - rest.blade_count();
    ASSERT_GT(rest.blade_count(), 40U);
    for (std::size_t i = 0; i < rest.blade_count(); ++i) {
      const std::uint32_t count = all.vertex_count[rest.meadow.kind[i]];
      for (std::uint32_t v = 0; v < count; ++v) {
        const std::size_t here = rest.first_vertex[i] + v, there = all.first_vertex[i + dropped] + v;
        ASSERT_EQ(of_rest.positions[here], of_all.positions[there]) << "blade " << i;
        ASSERT_EQ(of_rest.normals[here], of_all.normals[there]) << "blade " << i;
        ASSERT_EQ(places_alone[here], of_rest.positions[here]) << "blade " << i;
      }
    }
  }
}

TEST(PoseGrass, IntegratedBladeByBladeIsThatOfTheField) {
  const TravellingField gusts = gusts_of(6);
  const GrassInWind field = put_in_wind(patch("meadow", 0.5), gusts),
                    in_time = put_in_wind(patch("meadow", 0.5), gusts, GrassMotion::in_time);
  double off = 0, size = 0;
  for (int p = 0; p < 256; p += 5) {
    const double time = 10.0 * p / 256;
    for (std::size_t i = 0; i < field.blade_count(); i += 11) {
      const Eigen::Vector2d mean = Eigen::Vector2d::Zero();
      off += (angles_of(field, i, time) - angles_of(in_time, i, time)).squaredNorm();
      size += (angles_of(in_time, i, time) - mean).squaredNorm();
    }
  }
  EXPECT_LT(std::sqrt(off / size), 0.03);
}

TEST(PoseGrass, HasUnitNormalsAcrossTheBlade) {
  const GrassInWind grass = put_in_wind(patch("reed"), gusts_of(12, 256, 2));
  const Skin skin(grass, 6.5);
  for (std::size_t v = 0; v < skin.positions.size(); ++v) {
    ASSERT_TRUE(skin.positions[v].allFinite());
    ASSERT_NEAR(skin.normals[v].norm(), 1, 1e-5);
  }
}

TEST(PoseGrass, KeepsWhatAStemCarriesOnIt) {
  const GrassInWind grass = put_in_wind(patch("wheat"), gusts_of(15, 256, 0.75));
  const Skin skin(grass, 5);
  std::size_t ears = 0;
  for (std::size_t i = 1; i < grass.blade_count(); ++i) {
    if (grass.meadow.kind[i] != 1 || grass.meadow.kind[i - 1] != 0) continue;
    ++ears;
    Vector3f tip = Vector3f::Zero(), base = Vector3f::Zero();
    for (std::uint32_t k = 0; k < 3; ++k) tip += skin.positions[grass.first_vertex[i - 1] + 12 + k] / 3;
    for (std::uint32_t k = 0; k < 5; ++k) base += skin.positions[grass.first_vertex[i] + k] / 5;
    ASSERT_LT((tip - base).norm(), 1e-5F);
  }
  EXPECT_GT(ears, 100U);
}

// What travels with the wind does so over the meadow: a blade further downwind is later by d/U.
TEST(PoseGrass, SendsWavesDownwind) {
  const TravellingField gusts = gusts_of(6, 500);
  const GrassInWind grass = put_in_wind(patch("lawn", 6), gusts);
  const double heading = 20 * 3.14159265358979 / 180;
  std::size_t from = 0, to = 0;
  const Eigen::Vector2d along(std::cos(heading), std::sin(heading));
  double best = 1e9;
  for (std::size_t i = 0; i < grass.blade_count(); ++i) {
    const double off = (Eigen::Vector2d(grass.meadow.x[i], grass.meadow.y[i]) - 2 * along).norm();
    if (grass.meadow.frequency_class[i] == 1 && off < best) best = off, to = i;
  }
  best = 1e9;
  for (std::size_t i = 0; i < grass.blade_count(); ++i) {
    const double off = (Eigen::Vector2d(grass.meadow.x[i], grass.meadow.y[i]) + 2 * along).norm();
    if (grass.meadow.frequency_class[i] == 1 && off < best) best = off, from = i;
  }
  int lag_of_best = -1;
  double most = -1;
  for (int lag = 0; lag < 250; ++lag) {
    double sum = 0;
    for (int p = 0; p < 500; ++p) {
      sum += angles_of(grass, from, p * 0.02).norm() * angles_of(grass, to, (p + lag) * 0.02).norm();
    }
    if (sum > most) most = sum, lag_of_best = lag;
  }
  EXPECT_NEAR(lag_of_best * 0.02, 4.0 / 6, 0.06);
}

TEST(MakeGrassLoop, HasASkinThatCanBeDrawnAndShapesThatAddUpToIt) {
  const Loop loop = make_grass_loop(patch("meadow", 0.5), gusts_of(8), {.name = "patch"});
  const Surface& rest = *loop.rest;
  ASSERT_GT(rest.parts.size(), 0U);
  for (const SurfacePart& part : rest.parts) {
    for (const std::uint32_t corner : part.triangles) ASSERT_LT(corner, rest.vertex_count());
  }
  ASSERT_GT(loop.coordinates.cols(), 1);
  const int sample = 77;
  const SurfaceDelta delta = loop.skin_at(loop.period * sample / loop.sample_count());
  std::vector<Vector3f> sum(rest.vertex_count(), Vector3f::Zero());
  for (Eigen::Index c = 0; c < loop.coordinates.cols(); ++c) {
    const SurfaceDelta shape = loop.shape_of_skin(c, loop.coordinates(sample, c));
    for (std::size_t v = 0; v < sum.size(); ++v) sum[v] += shape.position[v];
  }
  double off = 0, size = 0;
  for (std::size_t v = 0; v < sum.size(); ++v) {
    off += static_cast<double>((sum[v] - delta.position[v]).squaredNorm());
    size += static_cast<double>(delta.position[v].squaredNorm());
  }
  EXPECT_LT(std::sqrt(off / size), 0.2);
}

TEST(GrassSurface, HasTrianglesThatFaceAsTheirNormalsDo) {
  for (const GrassSpecies& species : grass_species()) {
    const GrassInWind grass =
        put_in_wind(sow(species, {.low = {0, 0}, .high = {0.5, 0.5}}), gusts_of(4, 64, species.height));
    const Surface surface = grass_surface(grass);
    std::size_t wrong = 0, all = 0;
    for (const SurfacePart& part : surface.parts) {
      for (std::size_t t = 0; t < part.triangles.size(); t += 3, ++all) {
        const std::uint32_t* at = &part.triangles[t];
        const Vector3f plane = (surface.position[at[1]] - surface.position[at[0]])
                                   .cross(surface.position[at[2]] - surface.position[at[0]]);
        if (plane.dot(surface.normal[at[0]] + surface.normal[at[1]] + surface.normal[at[2]]) < 0) ++wrong;
      }
    }
    // But for the flat ends of ears, whose corners have the normals of the sides.
    EXPECT_LT(static_cast<double>(wrong), 0.06 * static_cast<double>(all)) << species.name;
  }
}

TEST(PoseGrass, RefusesPlacesThatDoNotFit) {
  const GrassInWind grass = put_in_wind(patch("lawn", 0.3), gusts_of(4, 64));
  std::vector<Vector3f> few(3);
  EXPECT_THROW(pose_grass(grass, 0, few, {}), InputError);
  std::vector<Vector3f> all(grass.all_vertices);
  EXPECT_THROW(pose_grass(grass, NAN, all, {}), InputError);
}

}  // namespace
}  // namespace tremula
