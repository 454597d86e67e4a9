#include "tremula/io/swc.hpp"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include "complaint.hpp"
#include "io/input_files.hpp"
#include "trees.hpp"

namespace tremula {
namespace {

using test::count_of;
using test::read_text;
using test::TemporaryFolder;

ImportedSkeleton through_a_file(const Skeleton& skeleton) {
  const TemporaryFolder folder;
  write_swc(skeleton, folder / "tree.swc");
  return read_skeleton(folder / "tree.swc");
}

void expect_identical(const Skeleton& a, const Skeleton& b) {
  EXPECT_EQ(a.origin, b.origin);
  EXPECT_EQ(a.roots, b.roots);
  ASSERT_EQ(a.branch_count(), b.branch_count());
  for (std::size_t k = 0; k < a.branches.size(); ++k) {
    EXPECT_EQ(a.branches[k].start_node, b.branches[k].start_node) << k;
    EXPECT_EQ(a.branches[k].start, b.branches[k].start) << k;
    EXPECT_EQ(a.branches[k].end, b.branches[k].end) << k;
    EXPECT_EQ(a.branches[k].start_radius, b.branches[k].start_radius) << k;
    EXPECT_EQ(a.branches[k].end_radius, b.branches[k].end_radius) << k;
    EXPECT_EQ(a.branches[k].wall, b.branches[k].wall) << k;
  }
  ASSERT_EQ(a.leaves.size(), b.leaves.size());
  for (std::size_t k = 0; k < a.leaves.size(); ++k) {
    EXPECT_EQ(a.leaves[k].branch, b.leaves[k].branch) << k;
    EXPECT_EQ(a.leaves[k].position, b.leaves[k].position) << k;
    EXPECT_EQ(a.leaves[k].base, b.leaves[k].base) << k;
    EXPECT_EQ(a.leaves[k].is_ribbon, b.leaves[k].is_ribbon) << k;
    EXPECT_EQ(a.leaves[k].end_width, b.leaves[k].end_width) << k;
    EXPECT_EQ(a.leaves[k].axis, b.leaves[k].axis) << k;
    EXPECT_EQ(a.leaves[k].normal, b.leaves[k].normal) << k;
    EXPECT_EQ(a.leaves[k].length, b.leaves[k].length) << k;
    EXPECT_EQ(a.leaves[k].width, b.leaves[k].width) << k;
    EXPECT_EQ(a.leaves[k].area, b.leaves[k].area) << k;
    EXPECT_EQ(a.leaves[k].mass, b.leaves[k].mass) << k;
  }
}

// Everything a skeleton may hold: several roots, steps in radius, branches away from their node, leaves.
Skeleton wild_skeleton(std::uint64_t seed) {
  const auto draw = [&](std::size_t k, std::uint32_t what) {
    return uniform({seed, RandomStream::test, what, k});
  };
  Skeleton skeleton = test::random_tree(40, seed);
  skeleton.roots.push_back({1.5, 0.5, 2.25});
  for (Branch& branch : skeleton.branches) branch.start_node += branch.start_node > 0;
  for (std::size_t k = 1; k < skeleton.branches.size(); ++k) {
    Branch& branch = skeleton.branches[k];
    if (draw(k, 10) < 0.1) branch.start_node = 1;
    if (draw(k, 16) < 0.3) branch.wall = 0.05 + 0.9 * draw(k, 17);
    branch.start = skeleton.node_position(branch.start_node);
    if (draw(k, 11) < 0.3) branch.start += 0.1 * Vec3(draw(k, 12) - 0.5, draw(k, 13) - 0.5, draw(k, 14));
    const double radius =
        branch.start_node == 1 ? 0.05 : skeleton.branches[std::size_t(branch.start_node - 1)].end_radius;
    branch.start_radius = draw(k, 15) < 0.5 ? radius : radius * draw(k, 16);
  }
  skeleton.branches[0].start_node = 0;
  skeleton.branches[1].start_node = 1;
  for (std::size_t k = 0; k < 25; ++k) {
    Leaf leaf;
    leaf.branch = static_cast<int>(draw(k, 20) * skeleton.branch_count());
    leaf.position = draw(k, 21);
    leaf.base = Vec3(draw(k, 22), draw(k, 23), draw(k, 24));
    leaf.axis = Vec3(draw(k, 25), draw(k, 26), 1).normalized();
    leaf.normal = leaf.axis.cross(Vec3(1, draw(k, 27), -1)).normalized();
    leaf.length = 0.01 + draw(k, 28);
    leaf.width = 0.01 + draw(k, 29);
    leaf.area = 0.01 + draw(k, 30);
    leaf.mass = 1e-4 + draw(k, 31);
    skeleton.leaves.push_back(leaf);
  }
  return skeleton;
}

TEST(WriteSwc, IsReadBackToTheLastBit) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const Skeleton skeleton = wild_skeleton(seed);
    const ImportedSkeleton back = through_a_file(skeleton);
    EXPECT_EQ(back.format, "swc");
    EXPECT_TRUE(back.repairs.empty());
    expect_identical(skeleton, back.skeleton);
  }
}

TEST(WriteSwc, KeepsTheOriginOfARecentredScan) {
  Skeleton skeleton = test::random_tree(5, 3);
  skeleton.origin = {500000.125, 4649776.5, 253.1};
  expect_identical(skeleton, through_a_file(skeleton).skeleton);
}

TEST(WriteSwc, IsReadBackWhereItStandsHoweverFarFromTheOrigin) {
  Skeleton skeleton = test::random_tree(5, 3);
  const Vec3 shift(1024, 0, 64);
  for (Vec3& root : skeleton.roots) root += shift;
  for (Branch& branch : skeleton.branches) {
    branch.start += shift;
    branch.end += shift;
  }
  skeleton.origin = {0, 2048, 0};
  const ImportedSkeleton back = through_a_file(skeleton);
  EXPECT_TRUE(back.repairs.empty());
  expect_identical(skeleton, back.skeleton);
}

TEST(WriteSwc, KeepsWhatAScanWouldBeMendedFor) {
  // Two branches in one place, one of a nanometre on a plant of metres, a start a hair from its node, a root
  // in the air, and one on which nothing stands.
  Skeleton skeleton = test::straight_stem(2, 1, 0.02, 0.01);
  skeleton.roots.push_back({3, 0, 1.75});
  skeleton.roots.push_back({9, 0, 0});
  for (Branch& branch : skeleton.branches) branch.start_node += 2 * (branch.start_node > 0);
  const auto add = [&](int node, const Vec3& start, const Vec3& end) {
    skeleton.branches.push_back({node, start, end, 0.01, 0.005});
  };
  const Vec3 tip = skeleton.branches.back().end;
  const int tip_node = skeleton.end_node(skeleton.branch_count() - 1);
  for (int i = 0; i < 3; ++i) add(tip_node, tip, tip + Vec3(1, 0, 0));
  add(tip_node, tip, tip + Vec3(1e-9, 0, 0));
  add(tip_node, tip + Vec3(1e-10, 0, 0), tip + Vec3(0, 1, 0));
  add(1, {3, 0, 1.75}, {3, 0, 2.5});
  const ImportedSkeleton back = through_a_file(skeleton);
  EXPECT_TRUE(back.repairs.empty());
  expect_identical(skeleton, back.skeleton);
}

// Another program reads samples only: every branch must be the piece between a sample and its parent, and all
// else must be no longer than the rigid links and radius steps that the skeleton has.
TEST(WriteSwc, IsPlainSwcToOtherPrograms) {
  const TemporaryFolder folder;
  const Skeleton skeleton = wild_skeleton(7);
  write_swc(skeleton, folder / "tree.swc");
  std::ifstream file(folder / "tree.swc");
  std::string line;
  struct Sample {
    int type = 0, parent = 0;
    Vec3 position = Vec3::Zero();
    double radius = 0;
  };
  std::vector<Sample> samples(1);  // ids count from 1
  while (std::getline(file, line)) {
    if (line.starts_with("#")) continue;
    std::istringstream columns(line);
    Sample s;
    int id;
    columns >> id >> s.type >> s.position[0] >> s.position[1] >> s.position[2] >> s.radius >> s.parent;
    ASSERT_TRUE(columns) << line;
    EXPECT_EQ(id, static_cast<int>(samples.size()));
    EXPECT_TRUE(s.parent == -1 || (s.parent >= 1 && s.parent < id));
    EXPECT_GT(s.radius, 0);
    samples.push_back(s);
  }
  std::size_t k = 0, roots = 0;
  for (const Sample& s : samples) {
    roots += s.type == 1;
    if (s.type != 2) continue;
    const Branch& branch = skeleton.branches.at(k++);
    EXPECT_EQ(s.position, branch.end);
    EXPECT_EQ(s.radius, branch.end_radius);
    EXPECT_EQ(samples[std::size_t(s.parent)].position, branch.start);
    EXPECT_EQ(samples[std::size_t(s.parent)].radius, branch.start_radius);
  }
  EXPECT_EQ(k, skeleton.branches.size());
  EXPECT_EQ(roots, skeleton.roots.size());
}

TEST(WriteSwc, RefusesASkeletonThatItCouldNotReadBack) {
  const TemporaryFolder folder;
  Skeleton skeleton = test::random_tree(5, 3);
  skeleton.branches[2].end_radius = 0;
  EXPECT_THROW(write_swc(skeleton, folder / "tree.swc"), InputError);
  EXPECT_FALSE(std::filesystem::exists(folder / "tree.swc"));
}

TEST(ReadSwc, MakesAFrustumOfEverySampleButTheRoot) {
  const ImportedSkeleton imported = read_text(
      "# a comment\n"
      "1 1 0 0 0 0.5 -1\n"
      "2 3 0 0 2 0.25 1\n"
      "\n"
      "3 3 1 0 3 0.125 2\n"
      "7,3,-1,0,3,0.0625,2\n");
  EXPECT_EQ(imported.format, "swc");
  EXPECT_TRUE(imported.repairs.empty());
  Skeleton expected;
  expected.roots = {Vec3(0, 0, 0)};
  expected.branches = {{0, {0, 0, 0}, {0, 0, 2}, 0.5, 0.25},
                       {1, {0, 0, 2}, {1, 0, 3}, 0.25, 0.125},
                       {1, {0, 0, 2}, {-1, 0, 3}, 0.25, 0.0625}};
  expect_identical(imported.skeleton, expected);
}

TEST(ReadSwc, TakesWholeNumbersHoweverTheyAreWritten) {
  const ImportedSkeleton imported = read_text("1.0 1 0 0 0 0.5 -1.0\n+2e0 3 0 0 +2 .25 1.000\r\n");
  EXPECT_EQ(imported.skeleton.branch_count(), 1);
  EXPECT_EQ(imported.skeleton.branches[0].end_radius, 0.25);
}

TEST(ReadSwc, FindsParentsAmongIdsWithGaps) {
  const ImportedSkeleton imported =
      read_text("1 1 0 0 0 1 -1\n2 3 0 0 2 1 1\n4 3 0 0 3 1 2\n5 3 1 0 3 1 2\n7 3 0 0 4 1 4\n");
  ASSERT_EQ(imported.skeleton.branch_count(), 4);
  EXPECT_EQ(imported.skeleton.branches[3].start, Vec3(0, 0, 3));
  EXPECT_EQ(imported.skeleton.branches[3].start_node, imported.skeleton.end_node(1));
}

TEST(ReadSwc, KeepsRootsNearTheGroundAndJoinsHigherOnes) {
  // Three stems 10 m high; 5 % of that is the limit.
  const std::string tuft =
      "1 1 0 0 0    0.5 -1\n"
      "2 2 0 0 10   0.5 1\n"
      "3 1 1 0 0.49 0.5 -1\n"
      "4 2 1 0 5    0.5 3\n"
      "5 1 2 0 0.51 0.5 -1\n"
      "6 2 2 0 5    0.5 5\n";
  const ImportedSkeleton imported = read_text(tuft);
  EXPECT_EQ(imported.skeleton.roots, (std::vector<Vec3>{{0, 0, 0}, {1, 0, 0.49}}));
  EXPECT_EQ(count_of(imported, "joined_to_nearest"), 1u);
  EXPECT_EQ(test::message_of(imported, "joined_to_nearest"),
            "1 segment without parent joined to the nearest branch, at 1 m (line 6)");
  // The nearest to (2, 0, 0.51) is the second stem, whose lower end is the ground: so its tip carries the
  // third.
  EXPECT_EQ(imported.skeleton.branches[2].start, Vec3(2, 0, 0.51));
  EXPECT_EQ(imported.skeleton.branches[2].start_node, imported.skeleton.end_node(1));
}

TEST(ReadSwc, ReadsEveryDialectAsThePlainFile) {
  const Skeleton expected = read_text("1 1 0 0 0 0.5 -1\n2 3 0 0 2 0.25 1\n3 3 1 0 3 0.125 2\n").skeleton;
  for (const char* text : {
           "1 1 0 0 0 0.5 -1 # the foot\n2 3 0 0 2 0.25 1\n3 3 1 0 3 0.125 2 #tip\n",
           "id,type,x,y,z,radius,parent\n1,1,0,0,0,0.5,-1\n2,3,0,0,2,0.25,1\n3,3,1,0,3,0.125,2\n",
           "\"n\" \"parent\" \"radius\" \"z\" \"y\" \"x\"\n1 -1 0.5 0 0 0\n2 1 0.25 2 0 0\n3 2 0.125 3 0 1\n",
           "1 1 0 0 0 0.5 0\n2 3 0 0 2 0.25 1\n3 3 1 0 3 0.125 2\n",
           "1 1 0 0 0 0.5 -1 7\n2 3 0 0 2 0.25 1 7\n3 3 1 0 3 0.125 2 7\n",
           "##n,type,x,y,z,radius,parent,seg_id,level,mode,timestamp,teraflyindex\n"
           "1 1 0 0 0 0.5 -1 0 0 0 0 0\n2 3 0 0 2 0.25 1 0 0 0 0 0\n3 3 1 0 3 0.125 2 0 0 0 0 0\n",
       }) {
    const ImportedSkeleton imported = read_text(text);
    EXPECT_EQ(imported.format, "swc");
    EXPECT_TRUE(imported.repairs.empty());
    expect_identical(imported.skeleton, expected);
  }
}

TEST(ReadSwc, TakesAParentOfZeroForASampleWhereThereIsOne) {
  const ImportedSkeleton imported = read_text("0 1 0 0 0 0.5 -1\n1 3 0 0 2 0.25 0\n2 3 0 0 3 0.25 1\n");
  EXPECT_EQ(imported.skeleton.root_count(), 1);
  EXPECT_EQ(imported.skeleton.branch_count(), 2);
}

TEST(ReadSwc, RefusesAnotherUnitForAFileOfItsOwn) {
  EXPECT_EQ(test::complaint_of([] {
              read_skeleton("# tremula skeleton\n1 1 0 0 0 1 -1\n2 2 0 0 2 1 1\n", "oak.swc", {.unit = 1e-3});
            }),
            "oak.swc: a file of tremula, which is in metres, wanted no other unit");
}

TEST(ReadSwc, DropsRootsThatCarryNothing) {
  const ImportedSkeleton imported = read_text("1 1 0 0 0 1 -1\n2 1 5 0 0 1 -1\n3 3 0 0 2 1 1\n");
  EXPECT_EQ(imported.skeleton.root_count(), 1);
  EXPECT_EQ(test::message_of(imported, "dropped_lone_root"), "1 root without branches dropped");
}

TEST(ReadSwc, LetsAZeroLengthSegmentStepTheRadius) {
  const ImportedSkeleton imported =
      read_text("1 1 0 0 0 1 -1\n2 3 0 0 2 1 1\n3 3 0 0 2 0.5 2\n4 3 0 0 3 0.25 3\n");
  ASSERT_EQ(imported.skeleton.branch_count(), 2);
  EXPECT_EQ(imported.skeleton.branches[1].start_radius, 0.5);
  EXPECT_EQ(imported.skeleton.branches[1].start_node, 1);
  EXPECT_EQ(count_of(imported, "collapsed_zero_length"), 1u);
}

TEST(ReadSwc, TakesTypesAndCommentsOfItsOwnOnlyInItsOwnFiles) {
  const std::string samples = "1 1 0 0 0 1 -1\n2 2 0 0 2 1 1\n3 16 0 0 2.5 0.5 2\n4 2 0 0 3 0.25 3\n";
  const Skeleton plain = read_text("# origin 1 2 3\n# leaf area index 4\n" + samples).skeleton;
  EXPECT_EQ(plain.branch_count(), 3);
  EXPECT_EQ(plain.origin, Vec3(0, 0, 0));
  const Skeleton ours = read_text("# tremula skeleton\n# origin 1 2 3\n" + samples).skeleton;
  ASSERT_EQ(ours.branch_count(), 2);
  EXPECT_EQ(ours.origin, Vec3(1, 2, 3));
  EXPECT_EQ(ours.branches[1].start_node, 1);
  EXPECT_EQ(ours.branches[1].start, Vec3(0, 0, 2.5));
  EXPECT_EQ(ours.branches[1].start_radius, 0.5);
}

TEST(WriteSwc, KeepsRibbonsBesideLeaves) {
  Skeleton skeleton = test::straight_stem(2, 1, 0.01, 0.01);
  Leaf leaf{.branch = 1, .position = 0.5, .length = 0.5, .width = 0.1, .area = 0.04, .mass = 0.02};
  skeleton.leaves = {leaf, leaf};
  skeleton.leaves[1].is_ribbon = true;
  skeleton.leaves[1].end_width = 0.06;
  expect_identical(skeleton, through_a_file(skeleton).skeleton);
}

TEST(WriteSwc, KeepsTheColorsOfAPlant) {
  const test::TemporaryFolder folder;
  const std::string path = folder / "colored.swc";
  const Skeleton stem = test::straight_stem(2, 1, 0.02, 0.01);
  write_swc(stem, path, {.bark = Eigen::Vector3f(0.9F, 0.85F, 0.8F), .leaf = Eigen::Vector3f(0.3F, 0.5F, 0)});
  const PlantColors colors = read_skeleton(path).colors;
  EXPECT_EQ(colors.bark, Eigen::Vector3f(0.9F, 0.85F, 0.8F));
  EXPECT_EQ(colors.leaf, Eigen::Vector3f(0.3F, 0.5F, 0));
  write_swc(stem, path);
  EXPECT_FALSE(read_skeleton(path).colors.bark.has_value());
}

TEST(ReadSwc, RefusesAColorChannelAboveOne) {
  EXPECT_EQ(test::complaint_about_bytes(
                "# tremula\n# bark_color 0.5 1.5 0\n1 1 0 0 0 0.1 -1\n2 2 0 0 1 0.1 1\n", "a.swc"),
            "a.swc:2: green is 1.5, wanted 0 to 1");
}

TEST(WriteSwc, RefusesAColorThatIsNotFinite) {
  const PlantColors colors{.bark = Eigen::Vector3f(0.1F, std::numeric_limits<float>::quiet_NaN(), 0.1F)};
  EXPECT_THROW(encode_swc(test::random_tree(4, 2), colors), Error);
}

TEST(ReadSwc, TakesTheWallsOfTubesFromAColumnInTheUnitOfTheRadius) {
  const Skeleton skeleton =
      read_text("id,x,y,z,radius,parent,wall\n1,0,0,0,0.04,-1,0\n2,0,0,1,0.04,1,0.01\n3,0,0,2,0.02,2,\n")
          .skeleton;
  ASSERT_EQ(skeleton.branch_count(), 2);
  EXPECT_DOUBLE_EQ(skeleton.branches[0].wall, 0.25);
  EXPECT_EQ(skeleton.branches[1].wall, 1);
}

TEST(ReadSwc, RefusesAWallThickerThanTheRadius) {
  EXPECT_THAT(test::complaint_of(
                  [] { read_text("id,x,y,z,radius,parent,wall\n1,0,0,0,0.04,-1,0\n2,0,0,1,0.04,1,0.05\n"); }),
              testing::HasSubstr(":3: wall is 0.05, wanted a thickness of 1e-12 to the radius, 0.04, or 0"));
  EXPECT_THAT(test::complaint_of(
                  [] { read_text("# tremula skeleton\n1 1 0 0 0 0.1 -1\n2 2 0 0 1 0.1 1\n# wall 2 1.5\n"); }),
              testing::HasSubstr(":4: wall is 1.5, wanted above 0, and no thicker than the radius"));
  EXPECT_THAT(test::complaint_of(
                  [] { read_text("# tremula skeleton\n1 1 0 0 0 0.1 -1\n2 2 0 0 1 0.1 1\n# wall 7 0.5\n"); }),
              testing::HasSubstr(":4: wall sample is 7, wanted the id of a sample that ends a branch"));
}

}  // namespace
}  // namespace tremula
