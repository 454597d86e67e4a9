#include "tremula/io/vdb.hpp"

#include "tremula/base/error.hpp"

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

TEST(EncodeVdb, GivesTheSameBytesForTheSameTexture) {
  EXPECT_EQ(encode_vdb(two_of_a_box()), encode_vdb(two_of_a_box()));
}

#endif

}  // namespace
}  // namespace tremula
