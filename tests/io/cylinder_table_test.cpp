#include "tremula/io/cylinder_table.hpp"

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

// ---- other programs' tables
// ----------------------------------------------------------------------------------------------

// A stem of two cylinders and a branch, as each program writes it.
const std::string named =
    "radius,length,start.x,start.y,start.z,axis.x,axis.y,axis.z,parent,extension\n"
    "0.05,1,0,0,0,0,0,1,0,2\n0.04,1,0,0,1,0,0,1,1,0\n0.02,0.5,0,0,1,1,0,0,1,0\n";

void expect_small_tree(const ImportedSkeleton& imported, const std::string& format) {
  EXPECT_EQ(imported.format, format);
  EXPECT_TRUE(imported.repairs.empty());
  const Skeleton expected = read_text(named).skeleton;
  ASSERT_EQ(imported.skeleton.branch_count(), 3) << format;
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(imported.skeleton.branches[k].start_node, expected.branches[k].start_node) << format;
    EXPECT_EQ(imported.skeleton.branches[k].start, expected.branches[k].start) << format;
    EXPECT_EQ(imported.skeleton.branches[k].end, expected.branches[k].end) << format;
    EXPECT_EQ(imported.skeleton.branches[k].start_radius, expected.branches[k].start_radius) << format;
  }
}

TEST(ReadCylinderTable, ReadsByNameWhateverTheOrderAndTheQuotes) {
  const Skeleton skeleton = read_text(named).skeleton;
  EXPECT_EQ(skeleton.branches[1].end, Vec3(0, 0, 2));
  EXPECT_EQ(skeleton.branches[2].end, Vec3(0.5, 0, 1));
  EXPECT_EQ(skeleton.branches[2].start_node, 1);
  for (const char* text : {
           // columns swapped; a note that is no number
           "note,extension,parent,axis.z,axis.y,axis.x,start.z,start.y,start.x,length,radius\n"
           "trunk,2,0,1,0,0,0,0,0,1,0.05\n,0,1,1,0,0,1,0,0,1,0.04\nNA,0,1,0,0,1,1,0,0,0.5,0.02\n",
           // write.csv of R, with its row names
           "\"\",\"radius\",\"length\",\"start.1\",\"start.2\",\"start.3\",\"axis.1\",\"axis.2\",\"axis.3\","
           "\"parent\"\n"
           "\"1\",0.05,1,0,0,0,0,0,1,0\n\"2\",0.04,1,0,0,1,0,0,1,1\n\"3\",0.02,0.5,0,0,1,1,0,0,1\n",
           // write.table of R: the row names have no name
           "\"radius\" \"length\" \"start.x\" \"start.y\" \"start.z\" \"axis.x\" \"axis.y\" \"axis.z\" "
           "\"parent\"\n"
           "\"1\" 0.05 1 0 0 0 0 0 1 0\n\"2\" 0.04 1 0 0 1 0 0 1 1\n\"3\" 0.02 0.5 0 0 1 1 0 0 1\n",
           // TreeQSM's own names
           "radius (m)\tlength (m)\tstart_point\taxis_direction\tparent\textension\n"
           "0.05\t1\t0\t0\t0\t0\t0\t1\t0\t2\n0.04\t1\t0\t0\t1\t0\t0\t1\t1\t0\n"
           "0.02\t0.5\t0\t0\t1\t1\t0\t0\t1\t0\n",
       }) {
    expect_small_tree(read_text(text), "treeqsm-text");
  }
}

TEST(ReadCylinderTable, ReadsTheTablesOfOtherPrograms) {
  expect_small_tree(read_text("startX,startY,startZ,endX,endY,endZ,cyl_ID,parent_ID,extension_ID,radius_cyl\n"
                              "0,0,0,0,0,1,1,0,2,0.05\n0,0,1,0,0,2,2,1,0,0.04\n0,0,1,0.5,0,1,3,1,0,0.02\n"),
                    "archi-table");
  expect_small_tree(read_text("start_x,start_y,start_z,axis_x,axis_y,axis_z,end_x,end_y,end_z,id,parent,"
                              "radius,raw_radius,length\n"
                              "0,0,0,0,0,1,0,0,1,1,0,0.05,0.1,1\n0,0,1,0,0,1,0,0,2,2,1,0.04,0.1,1\n"
                              "0,0,1,1,0,0,0.5,0,1,3,1,0.02,0.1,0.5\n"),
                    "rtwig-table");
  // From the node of the row towards its parent's; the foot (node 7) has no row.
  expect_small_tree(read_text(",p1,p2,sx,sy,sz,ax,ay,az,radius,length\n"
                              "0,8,7,0,0,1,0,0,-1,0.05,1\n1,9,8,0,0,2,0,0,-1,0.04,1\n"
                              "2,12,8,0.5,0,1,-1,0,0,0.02,0.5\n"),
                    "treegraph-table");
}

TEST(ReadRaycloudTree, ReadsTheFirstTreeOfAFile) {
  const ImportedSkeleton imported = read_text(
      "# Tree file\nheight,x,y,z,radius,parent_id,red\n"
      "2,0,0,0,0.1,-1,7, 0,0,1,0.05,0,7, 0,0,2,0.04,1,7, 0.5,0,1,0.02,1,7\n"
      "2,5,0,0,0.1,-1,7, 5,0,1,0.05,0,7\n");
  EXPECT_EQ(imported.format, "raycloud-tree");
  EXPECT_EQ(test::count_of(imported, "first_of_several"), 1u);
  ASSERT_EQ(imported.skeleton.branch_count(), 3);
  EXPECT_EQ(imported.skeleton.branches[2].start, Vec3(0, 0, 1));
  EXPECT_EQ(imported.skeleton.branches[2].end, Vec3(0.5, 0, 1));
  EXPECT_EQ(imported.skeleton.branches[2].start_node, imported.skeleton.end_node(0));
  EXPECT_EQ(imported.skeleton.branches[1].start_radius, 0.04);
  EXPECT_EQ(test::complaint_about_bytes("x,y,z,radius\n0,0,0,0.2\n", "trunks"),
            "trunks:1: a header without parent_id: trunks only, wanted a tree with its branches (rayextract "
            "trees)");
}

TEST(ReadCylinderTable, KeepsTheParentsOfAFilteredTableThatHasIds) {
  // Rows 2 and 4 were taken out; nothing named them.
  const char* with_ids =
      "id,parent,start_x,start_y,start_z,end_x,end_y,end_z,radius\n"
      "1,0,0,0,0,0,0,1,0.05\n3,1,0,0,1,0,0,2,0.04\n5,3,0,0,2,0,0,3,0.03\n";
  const char* with_row_names =
      "\"\",\"parent\",\"start_x\",\"start_y\",\"start_z\",\"end_x\",\"end_y\",\"end_z\",\"radius\"\n"
      "\"1\",0,0,0,0,0,0,1,0.05\n\"3\",1,0,0,1,0,0,2,0.04\n\"5\",3,0,0,2,0,0,3,0.03\n";
  for (const char* text : {with_ids, with_row_names}) {
    const ImportedSkeleton imported = read_text(text);
    ASSERT_EQ(imported.skeleton.branch_count(), 3);
    EXPECT_EQ(imported.skeleton.branches[2].start_node, imported.skeleton.end_node(1));
  }
}

TEST(ReadCylinderTable, CountsRowsWhereTheirNamesAreNoIds) {
  const std::string first_row =
      "\"\",\"parent\",\"start_x\",\"start_y\",\"start_z\",\"end_x\",\"end_y\",\"end_z\",\"radius\"\n";
  for (const char* name : {"2y", "1e300", "-1e300", "1e999", "nan", "2.5"}) {
    const std::string text = first_row + "\"1\",0,0,0,0,0,0,1,0.05\n\"" + name +
                             "\",1,0,0,1,0,0,2,0.04\n\"7\",2,0,0,2,0,0,3,0.03\n";
    const ImportedSkeleton imported = read_text(text.c_str());
    ASSERT_EQ(imported.skeleton.branch_count(), 3) << name;
    EXPECT_EQ(imported.skeleton.branches[2].start_node, imported.skeleton.end_node(1)) << name;
  }
}

TEST(ReadCylinderTable, NamesAColumnInPrintableLettersWhateverItIsCalled) {
  const std::string complaint = test::complaint_about_bytes(
      "radius,start\xFFX,startY,startZ,endX,endY,endZ,parent\n0.1,p,0,0,0,0,1,-1\n", "tree");
  EXPECT_EQ(complaint, "tree:2: start?X is p, wanted a number");
}

TEST(ReadCylinderTable, SaysThatRowsAreMissing) {
  const std::string text =
      "id,parent,start_x,start_y,start_z,end_x,end_y,end_z,radius\n"
      "1,0,0,0,0,0,0,1,0.05\n3,2,0,0,1.05,0,0,2,0.04\n";
  EXPECT_EQ(test::complaint_about_bytes(text, "tree"),
            "tree:3: parent is 2, and no row has that id (were rows taken out?), wanted -1 or the id of a "
            "cylinder in this file, or --allow-gaps to join what it carried");
  const ImportedSkeleton imported = read_skeleton(text, "tree", {.allow_gaps = true});
  EXPECT_EQ(imported.skeleton.branches[1].start_node, imported.skeleton.end_node(0));
  EXPECT_EQ(test::message_of(imported, "joined_to_nearest"),
            "1 segment without parent joined to the nearest branch, at 0.05 m (line 3)");
}

TEST(ReadSimpleForest, TakesAColumnOfWallsForTubes) {
  const Skeleton skeleton =
      read_text(
          "ID,parentID,startX,startY,startZ,endX,endY,endZ,radius,wall\n0,-1,0,0,0,0,0,2,0.5,0.125\n"
          "1,0,0,0,2,1,0,2,0.25,NA\n")
          .skeleton;
  ASSERT_EQ(skeleton.branch_count(), 2);
  EXPECT_DOUBLE_EQ(skeleton.branches[0].wall, 0.25);
  EXPECT_EQ(skeleton.branches[1].wall, 1);
}

}  // namespace
}  // namespace tremula
