#include "tremula/io/simpleforest.hpp"

#include <sstream>

#include "io/input_files.hpp"

namespace tremula {
namespace {

using test::data_folder;
using test::read_text;

const std::string header = "ID,parentID,startX,startY,startZ,endX,endY,endZ,radius\n";

TEST(ReadSimpleForest, GivesCylindersOfConstantRadius) {
  const ImportedSkeleton imported = read_text(header + "0,-1,0,0,0,0,0,2,0.5\n1,0,0,0,2,1,0,2,0.25\n");
  EXPECT_EQ(imported.format, "simpleforest-csv");
  EXPECT_TRUE(imported.repairs.empty());
  const Skeleton& skeleton = imported.skeleton;
  ASSERT_EQ(skeleton.branch_count(), 2);
  EXPECT_EQ(skeleton.roots, (std::vector<Vec3>{{0, 0, 0}}));
  EXPECT_EQ(skeleton.branches[1].start_node, 1);
  EXPECT_EQ(skeleton.branches[1].start, Vec3(0, 0, 2));
  EXPECT_EQ(skeleton.branches[1].end, Vec3(1, 0, 2));
  EXPECT_EQ(skeleton.branches[1].start_radius, 0.25);
  EXPECT_EQ(skeleton.branches[1].end_radius, 0.25);
}

TEST(ReadSimpleForest, FindsItsColumnsByName) {
  const Skeleton expected = read_text(header + "0,-1,0,0,0,0,0,2,0.5\n1,0,0,0,2,1,0,2,0.25\n").skeleton;
  for (const char* text : {
           "# written by hand\n\n radius ; parentID; ID ;endZ;endY;endX;startZ;startY;startX;FitType\r\n"
           "0.5;-1;0;2;0;0;0;0;0;SPHERE\r\n0.25;0;1;2;0;1;2;0;0;\r\n",
           "\"\",\"ID\",\"parentID\",\"startX\",\"startY\",\"startZ\",\"endX\",\"endY\",\"endZ\",\"radius\"\n"
           "\"1\",0,-1,0,0,0,0,0,2,0.5\n\"2\",1,0,0,0,2,1,0,2,0.25",
       }) {
    const Skeleton skeleton = read_text(text).skeleton;
    ASSERT_EQ(skeleton.branch_count(), 2);
    EXPECT_EQ(skeleton.branches[1].end, expected.branches[1].end);
    EXPECT_EQ(skeleton.branches[1].start_radius, expected.branches[1].start_radius);
    EXPECT_EQ(skeleton.branches[1].start_node, expected.branches[1].start_node);
  }
}

TEST(ReadSimpleForest, TakesIdsInAnyOrderAndWithGaps) {
  const ImportedSkeleton imported =
      read_text(header + "900,40,0,0,2,1,0,2,0.25\n-7,900,1,0,2,2,0,2,0.125\n40,-1,0,0,0,0,0,2,0.5\n");
  ASSERT_EQ(imported.skeleton.branch_count(), 3);
  EXPECT_EQ(imported.skeleton.branches[0].start_radius, 0.5);
  EXPECT_EQ(imported.skeleton.branches[1].start_radius, 0.25);
  EXPECT_EQ(imported.skeleton.branches[2].start_radius, 0.125);
  EXPECT_EQ(test::count_of(imported, "reordered"), 1u);
}

TEST(ReadSimpleForest, KeepsEveryCylinderOfARealFileInItsPlace) {
  TREMULA_NEED_DATA("qsm/rtwig_sapling_simpleforest.csv");
  const std::filesystem::path path = data_folder() / "qsm/rtwig_sapling_simpleforest.csv";
  const ImportedSkeleton imported = read_skeleton(path.string());
  EXPECT_EQ(imported.repairs.size(), 1u);
  EXPECT_EQ(test::count_of(imported, "recentred"), imported.skeleton.branches.size());
  EXPECT_EQ(imported.skeleton.roots, (std::vector<Vec3>{{0, 0, 0}}));
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  std::size_t k = 0;
  while (std::getline(file, line)) {
    for (char& c : line) c = c == ',' ? ' ' : c;
    std::istringstream columns(line);
    int id, parent;
    Vec3 start, end;
    double radius, length;
    columns >> id >> parent >> start[0] >> start[1] >> start[2] >> end[0] >> end[1] >> end[2] >> radius >>
        length;
    const Branch& branch = imported.skeleton.branches.at(k);
    EXPECT_LE((branch.start + imported.skeleton.origin - start).norm(), 1e-9);
    EXPECT_LE((branch.end + imported.skeleton.origin - end).norm(), 1e-9);
    EXPECT_NEAR(branch.length(), length, 3e-6);  // six decimals of coordinates
    EXPECT_EQ(branch.start_radius, radius);
    ++k;
  }
  EXPECT_EQ(k, imported.skeleton.branches.size());
}

}  // namespace
}  // namespace tremula
