#include <algorithm>
#include <filesystem>
#include <sstream>
#include <string>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/program.hpp"
#include "pictures.hpp"
#include "tremula/io/vdb.hpp"
#include "tremula/raytrace/raytrace.hpp"

#ifdef TREMULA_HAVE_OPENVDB
#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>
#endif

namespace tremula {
namespace {

using test::contents;
using test::Outcome;
using testing::HasSubstr;

class Volumes : public testing::Test {
 protected:
  void SetUp() override {
    if (!can_trace()) GTEST_SKIP() << "built without Embree";
  }

  // A picture of a field of 12 m x 12 m, looked down upon.
  Outcome draw(const std::string& volume, const std::string& flags = "-o a.png") const {
    test::write(folder / "s.toml",
                "[wind]\nwind_speed = 7\n[motion]\nperiod = 2\nfps = 5\n[ground]\nkind = \"soil\"\n"
                "[camera]\neye = [0, -14, 6]\nlook_at = [0, 0, 0]\n"
                "[[volumes]]\nlow = [-6, -6]\nhigh = [6, 6]\n" +
                    volume);
    return run(folder, "render s.toml --size 64x36 --samples 4 --no-denoise " + flags);
  }

  test::TemporaryFolder folder;
};

TEST_F(Volumes, AreGreenWhereTheyGrowAndMoveInTheWind) {
  ASSERT_EQ(draw("texel_size = 0.04\n", "-o %04d.png --frames 0-3:3").code, 0);
  const auto field = test::read_picture(folder / "0000.png").mean(28, 16, 8, 4);
  EXPECT_GT(field[1], field[2] + 20);
  EXPECT_NE(contents(folder / "0000.png"), contents(folder / "0003.png"));
}

TEST_F(Volumes, AreTheSameOnAnyNumberOfThreads) {
  ASSERT_EQ(draw("texel_size = 0.05\n", "--threads 1 -o a.png").code, 0);
  ASSERT_EQ(draw("texel_size = 0.05\n", "--threads 3 -o b.png").code, 0);
  EXPECT_EQ(contents(folder / "a.png"), contents(folder / "b.png"));
}

TEST_F(Volumes, ThatCannotBeAreRefusedWithTheirPlaceInOneLine) {
  for (const auto& [volume, complaint] :
       {std::pair<std::string, std::string>{"texel_size = 0.0001\n", "texel_size"},
        {"inside = [[[20, 20], [30, 20], [30, 30]]]\n", "nothing of the field is left"},
        {"species = \"rise\"\n", "rice"}}) {
    const Outcome outcome = draw(volume);
    EXPECT_EQ(outcome.code, 2) << volume;
    EXPECT_THAT(outcome.messages, HasSubstr(complaint));
    EXPECT_THAT(outcome.messages, HasSubstr("s.toml:1"));
    EXPECT_EQ(std::count(outcome.messages.begin(), outcome.messages.end(), '\n'), 1) << outcome.messages;
    EXPECT_FALSE(std::filesystem::exists(folder / "a.png"));
  }
}

// ---- As files

class VolumeFiles : public testing::Test {
 protected:
  void SetUp() override {
    test::write(folder / "s.toml",
                "[wind]\nwind_speed = 9\n[motion]\nperiod = 2\nfps = 5\n[ground]\nheight = 1\n"
                "[[objects]]\nsource = \"sapling\"\n"
                "[[volumes]]\nspecies = \"rice\"\nlow = [-1, -1]\nhigh = [1.5, 1]\ntexel_size = 0.04\n"
                "[[drift]]\nkind = \"snow\"\nlow = [0, 0, 0]\nhigh = [2, 2, 2]\n");
  }

  Outcome animate(const std::string& arguments) const { return run(folder, "animate " + arguments); }
  Outcome animate_rice(const std::string& arguments) const {
    return animate("s.toml --object rice " + arguments);
  }
  static bool can_write() { return has_vdb(); }

  test::TemporaryFolder folder;
};

TEST_F(VolumeFiles, AreOneForEveryFrameOfTheLoop) {
  if (!can_write()) GTEST_SKIP() << "built without OpenVDB";
  const Outcome outcome = animate_rice("-o rice/%04d.vdb --report r.json");
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  EXPECT_THAT(outcome.messages, HasSubstr("rice/0000.vdb to rice/0009.vdb: 10 files"));
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path / "rice")) {
    EXPECT_EQ(entry.path().extension(), ".vdb");
    ++count;
  }
  EXPECT_EQ(count, 10);
  EXPECT_TRUE(std::filesystem::exists(folder / "rice/0000.vdb"));
  EXPECT_TRUE(std::filesystem::exists(folder / "rice/0009.vdb"));
  EXPECT_THAT(contents(folder / "r.json"), HasSubstr("\"frames_written\": 10"));
}

TEST_F(VolumeFiles, OfTheFrameAfterTheLastAreThoseOfTheFirst) {
  if (!can_write()) GTEST_SKIP() << "built without OpenVDB";
  ASSERT_EQ(animate_rice("-o %04d.vdb --frames 0-10:5").code, 0);
  const std::string first = contents(folder / "0000.vdb");
  EXPECT_GT(first.size(), 1000);
  EXPECT_EQ(first, contents(folder / "0010.vdb"));
  EXPECT_NE(first, contents(folder / "0005.vdb"));
}

TEST_F(VolumeFiles, OfOneFrameAreThatOfTheSequenceOnAnyNumberOfThreads) {
  if (!can_write()) GTEST_SKIP() << "built without OpenVDB";
  ASSERT_EQ(animate_rice("-o %04d.vdb --frames 3 --threads 3").code, 0);
  ASSERT_EQ(animate_rice("-o one.vdb --frames 3 --threads 1").code, 0);
  EXPECT_EQ(contents(folder / "0003.vdb"), contents(folder / "one.vdb"));
}

TEST_F(VolumeFiles, ThatAreThereStayWithResume) {
  if (!can_write()) GTEST_SKIP() << "built without OpenVDB";
  test::write(folder / "0001.vdb", "made before");
  ASSERT_EQ(animate_rice("-o %04d.vdb --frames 0-2 --resume").code, 0);
  EXPECT_EQ(contents(folder / "0001.vdb"), "made before");
  EXPECT_GT(contents(folder / "0002.vdb").size(), 1000);
}

TEST_F(VolumeFiles, ThatCannotBeAreRefusedInOneLine) {
  std::filesystem::create_symlink(folder / "s.toml", folder / "link.vdb");
  const std::size_t before = test::file_count(folder);
  for (const auto& [arguments, complaint] :
       {std::pair<std::string, std::string>{"s.toml --object rice -o a.glb", "which has no mesh"},
        {"s.toml --object rice -o a.glb", "rice/%04d.vdb"},
        {"s.toml --object rice", "no output"},
        {"s.toml --object ryce -o a.vdb", "did you mean rice"},
        {"s.toml --object sapling -o a.vdb", "one of the volumes of the scene"},
        {"s.toml -o a.vdb", "--object: not given"},
        {"sapling -o a.vdb", "which has a mesh"},
        {"sapling -o a.glb --texel-size 0.1", "--texel-size: given without a volume"},
        {"s.toml --object rice --modes 5 -o a.vdb", "--modes: given with rice"},
        {"s.toml --object rice --texel-size 0 -o a.vdb", "--texel-size: '0', wanted 1e-05 to 1000 m"}}) {
    const Outcome outcome = animate(arguments);
    EXPECT_EQ(outcome.code, 2) << arguments;
    EXPECT_THAT(outcome.messages, HasSubstr(complaint)) << arguments;
    EXPECT_EQ(std::count(outcome.messages.begin(), outcome.messages.end(), '\n'), 1) << outcome.messages;
  }
  EXPECT_EQ(test::file_count(folder), before);
}

TEST_F(VolumeFiles, AreRefusedByAProgramThatWasBuiltWithoutOpenVdb) {
  if (can_write()) GTEST_SKIP() << "built with OpenVDB";
  const Outcome outcome = animate_rice("-o a.vdb");
  EXPECT_NE(outcome.code, 0);
  EXPECT_THAT(outcome.messages, HasSubstr("built without OpenVDB (libopenvdb-dev)"));
}

TEST_F(VolumeFiles, OfWrongNamesFramesAndCellsAreRefusedInOneLine) {
  if (!can_write()) GTEST_SKIP() << "built without OpenVDB";
  std::filesystem::create_symlink(folder / "s.toml", folder / "link.vdb");
  const std::size_t before = test::file_count(folder);
  for (const auto& [arguments, complaint] :
       {std::pair<std::string, std::string>{"-o %d/%d.vdb", "one number of the frame"},
        {"-o a%x.vdb", "as in frames/%04d.vdb"},
        {"-o a.vdb --frames 0-3", "one frame for one file"},
        {"-o %04d.vdb --frames 11", "within 0-10"},
        {"-o a.vdb --resume", "given with one file"},
        {"-o %04d.vdb --texel-size 0.0005", "which makes a box of"},
        {"-o link.vdb", "would replace the input"},
        {"-o nowhere/a.vdb", "nowhere"}}) {
    const Outcome outcome = animate_rice(arguments);
    EXPECT_NE(outcome.code, 0) << arguments;
    EXPECT_THAT(outcome.messages, HasSubstr(complaint)) << arguments;
    EXPECT_EQ(std::count(outcome.messages.begin(), outcome.messages.end(), '\n'), 1) << outcome.messages;
  }
  EXPECT_EQ(test::file_count(folder), before);
}

#ifdef TREMULA_HAVE_OPENVDB

TEST_F(VolumeFiles, HoldTexelsOfTheCellAskedForWhereTheFieldIsAndLeanDownwind) {
  ASSERT_EQ(animate_rice("-o a.vdb --texel-size 0.06").code, 0);
  openvdb::initialize();
  openvdb::io::File file(folder / "a.vdb");
  file.open();
  const auto density = openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid("density"));
  const auto tangent = openvdb::gridPtrCast<openvdb::Vec3SGrid>(file.readGrid("tangent"));
  ASSERT_TRUE(density && tangent && file.readGrid("color"));
  EXPECT_NEAR(density->voxelSize().x(), 0.06, 1e-8);
  ASSERT_GT(density->activeVoxelCount(), 5000);
  double along = 0, of_all = 0;
  for (auto at = density->cbeginValueOn(); at; ++at) {
    const openvdb::Vec3d middle = density->indexToWorld(at.getCoord());
    EXPECT_TRUE(middle.x() > -2 && middle.x() < 2.5 && middle.y() > -2 && middle.y() < 2);
    ASSERT_TRUE(middle.z() > 1 && middle.z() < 2.2) << middle.z();
    const auto weight = static_cast<double>(*at);
    along += weight * static_cast<double>(tangent->tree().getValue(at.getCoord()).x());
    of_all += weight;
  }
  EXPECT_GT(along / of_all, 0.1);
}

#endif

}  // namespace
}  // namespace tremula
