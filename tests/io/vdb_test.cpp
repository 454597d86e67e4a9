#include "tremula/io/vdb.hpp"

#include "tremula/base/error.hpp"
#include "tremula/deformation/volume.hpp"

#include <cmath>
#include <memory>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "complaint.hpp"

#ifdef TREMULA_HAVE_OPENVDB
#include <sstream>

#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>
#endif

namespace tremula {
namespace {

Texels two_of_a_box() {
  Texels texels{.count = {3, 2, 4},
                .cell = {0.1F, 0.2F, 0.05F},
                .repeats = false,
                .density_step = 0.001F,
                .values = std::vector<Texel>(24)};
  const TexelValue value{
      .density = 12, .axis = Eigen::Vector3f(0.6F, 0, 0.8F), .spread = 0.2F, .color = {0.25F, 0.5F, 0.04F}};
  texels.values[texels.index(2, 1, 3)] = texel_of(value, texels.density_step);
  texels.values[texels.index(0, 0, 0)] = texel_of({.density = 3}, texels.density_step);
  return texels;
}

TEST(EncodeVdb, SaysSoWhereItWasBuiltWithoutOpenVdb) {
  if (has_vdb()) GTEST_SKIP() << "built with OpenVDB";
  EXPECT_THAT(test::complaint_of<Error>([] { encode_vdb(two_of_a_box()); }),
              testing::HasSubstr("libopenvdb-dev"));
}

TEST(EncodeVdb, RefusesATextureWithoutAllItsTexels) {
  if (!has_vdb()) GTEST_SKIP() << "built without OpenVDB";
  Texels texels = two_of_a_box();
  texels.values.pop_back();
  EXPECT_THAT(test::complaint_of([&] { encode_vdb(texels); }), testing::HasSubstr("23, wanted 24"));
}

#ifdef TREMULA_HAVE_OPENVDB
// Or all that need it would be skipped.
TEST(HasVdb, FindsTheModuleOfABuildThatHasOpenVdb) { EXPECT_TRUE(has_vdb()); }

TEST(EncodeVdb, IsReadByOpenVdbWithValuesAtTheirPlaces) {
  const Texels texels = two_of_a_box();
  std::istringstream stream(encode_vdb(texels, {5, 6, 7}));
  openvdb::initialize();
  const openvdb::GridPtrVecPtr grids = openvdb::io::Stream(stream, false).getGrids();
  ASSERT_EQ(grids->size(), 3);
  for (const auto& grid : *grids) {
    EXPECT_EQ(grid->activeVoxelCount(), 2) << grid->getName();
    const openvdb::Vec3d middle = grid->indexToWorld(openvdb::Coord(2, 1, 3));
    EXPECT_NEAR(middle.x(), 5.25, 1e-6);
    EXPECT_NEAR(middle.y(), 6.3, 1e-6);
    EXPECT_NEAR(middle.z(), 7.175, 1e-6);
  }
  const openvdb::Coord at(2, 1, 3);
  const auto density = openvdb::gridPtrCast<openvdb::FloatGrid>(openvdb::findGridByName(*grids, "density"));
  EXPECT_NEAR(density->tree().getValue(at), 12, 1e-3F);
  const auto tangent = openvdb::gridPtrCast<openvdb::Vec3SGrid>(openvdb::findGridByName(*grids, "tangent"));
  EXPECT_NEAR(tangent->tree().getValue(at).z(), 0.8F, 0.01F);
  const auto color = openvdb::gridPtrCast<openvdb::Vec3SGrid>(openvdb::findGridByName(*grids, "color"));
  EXPECT_NEAR(color->tree().getValue(at).y(), 0.5F, 0.005F);
}

// A field that is the same everywhere but for how it bends.
PosedVolume swaying_field() {
  Texels texels{.count = {4, 4, 8}, .cell = {0.1F, 0.1F, 0.1F}, .density_step = 0.001F, .values = {}};
  const TexelValue value{
      .density = 20, .axis = Eigen::Vector3f(0.28F, 0, 0.96F), .spread = 0.2F, .color = {0.2F, 0.5F, 0.1F}};
  texels.values.assign(128, texel_of(value, texels.density_step));
  auto field = std::make_shared<VolumeField>();
  field->patches = {{texels}};
  field->low = {-2, -2};
  field->high = {2, 2};
  field->height = 0.8;
  field->sway = [](const Eigen::Vector2d& at, double time) -> Eigen::Vector2d {
    return {0.2 + 0.1 * std::sin(at.x() + time), 0.05 * std::cos(at.y())};
  };
  field->most_sway = 0.4;
  return pose_volume(prepare_volume(field), 0.7);
}

TEST(EncodeVdb, HoldsWhatThePosedFieldHasAtThePlaceOfATexel) {
  const PosedVolume posed = swaying_field();
  constexpr double cell = 0.07;
  const Eigen::Vector3d low(-1, -1, 0);
  std::istringstream stream(encode_vdb(resample(posed, low, {28, 28, 10}, cell), low));
  openvdb::initialize();
  const openvdb::GridPtrVecPtr grids = openvdb::io::Stream(stream, false).getGrids();
  const auto density = openvdb::gridPtrCast<openvdb::FloatGrid>(openvdb::findGridByName(*grids, "density"));
  const auto tangent = openvdb::gridPtrCast<openvdb::Vec3SGrid>(openvdb::findGridByName(*grids, "tangent"));
  int looked_at = 0;
  for (auto voxel = density->cbeginValueOn(); voxel; ++voxel) {
    const openvdb::Vec3d middle = density->indexToWorld(voxel.getCoord());
    const Eigen::Vector3f place = Eigen::Vector3d(middle.x(), middle.y(), middle.z()).cast<float>();
    Eigen::Vector2f guess(0, 0);
    RestPlace rest;
    bool within = true;
    for (int i = 0; i < 20; ++i) within = unbend(posed, place, 0.5F, guess, rest);
    if (!within || rest.s > 0.97F) continue;  // the edge of a texel may be on either side
    const TexelValue value = value_at(posed, rest, 0);
    EXPECT_NEAR(*voxel, value.density, 0.003F * value.density);
    const openvdb::Vec3s axis = tangent->tree().getValue(voxel.getCoord());
    EXPECT_GT(std::abs(axis.dot({value.axis.x(), value.axis.y(), value.axis.z()})),
              0.9995F);  // two bytes of the octahedron
    ++looked_at;
  }
  EXPECT_GT(looked_at, 6000);
}

TEST(EncodeVdb, GivesTheSameBytesForTheSameTexture) {
  EXPECT_EQ(encode_vdb(two_of_a_box()), encode_vdb(two_of_a_box()));
}

#endif

}  // namespace
}  // namespace tremula
