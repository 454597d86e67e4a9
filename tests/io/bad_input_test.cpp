// What is no plant is refused with one line: the file, the place in it, the value found, the value wanted.
#include <cstring>
#include <functional>
#include <limits>
#include <ostream>

#include "io/input_files.hpp"

namespace tremula {
namespace {

using test::complaint_about;
using test::small_table;
using test::TemporaryFolder;

// ---- text
// --------------------------------------------------------------------------------------------------------

struct BadText {
  const char* name;  // also the test's: Rejects…
  std::string text;
  std::string complaint;
};

std::ostream& operator<<(std::ostream& out, const BadText& bad) { return out << bad.name; }

class TextFile : public testing::TestWithParam<BadText> {};

TEST_P(TextFile, IsRejectedBecauseOf) {
  EXPECT_EQ(test::complaint_about_bytes(GetParam().text, "tree"), GetParam().complaint);
}

std::string name_of(const testing::TestParamInfo<BadText>& info) { return info.param.name; }

const std::string wanted_tables =
    "wanted SWC (7 columns), TreeQSM (15 or 17) or a table of cylinders with a line of names above it";
const std::vector<BadText> bad_anywhere = {
    {"Emptiness", "", "tree: an empty file, wanted a plant"},
    {"NothingButComments", "# nothing\n\n   \n#here\n",
     "tree: nothing but blank lines and comments, wanted a plant"},
    {"AnotherTable", "# x\n1 2 3\n",
     "tree:2: 3 columns beginning with 1 (a point cloud is no tree model yet), " + wanted_tables},
    {"Prose", "hello\n", "tree:1: 1 column beginning with hello, " + wanted_tables},
    {"AVeryLongLineOfGarbage", std::string(100000, '\x01'),
     "tree:1: 1 column beginning with ????????????????????????????????????????..., " + wanted_tables},
    {"BinaryData", std::string("1 1 0 0 0 1 -1\n\0", 16),
     "tree: binary data, wanted SWC, TreeQSM or SimpleForest text, or a MATLAB file"},
};

const std::vector<BadText> bad_swc = {
    {"AMissingColumn", "1 1 0 0 0 1 -1\n2 3 0 0 2 1\n",
     "tree:2: 6 columns, wanted the 7 of SWC: id type x y z radius parent"},
    {"AnExtraColumn", "1 1 0 0 0 1 -1\n\n2 3 0 0 2 1 1 9\n",
     "tree:3: 8 columns, wanted the 7 of SWC: id type x y z radius parent"},
    {"AWordForANumber", "1 1 0 0 0 1 -1\n2 3 0 zero 2 1 1\n", "tree:2: y is zero, wanted a number"},
    {"TrailingLettersInANumber", "1 1 0 0 0 1 -1\n2 3 0 0 2m 1 1\n", "tree:2: z is 2m, wanted a number"},
    {"ADecimalComma", "1 1 0 0 0 1 -1\n2 3 0 0 2,5 1 1\n",
     "tree:2: 8 columns, wanted the 7 of SWC: id type x y z radius parent"},
    {"NaN", "1 1 0 0 0 1 -1\n2 3 nan 0 2 1 1\n", "tree:2: x is nan, wanted a finite number"},
    {"Infinity", "1 1 0 0 0 1 -1\n2 3 0 0 -inf 1 1\n", "tree:2: z is -inf, wanted a finite number"},
    {"AnOverflow", "1 1 0 0 0 1 -1\n2 3 0 0 1e999 1 1\n", "tree:2: z is 1e999, wanted a finite number"},
    {"ACoordinateOutInSpace", "1 1 0 0 0 1 -1\n2 3 0 0 2e9 1 1\n", "tree:2: z is 2e9, wanted at most 1e+09"},
    {"ARadiusOfZero", "1 1 0 0 0 1 -1\n2 3 0 0 2 0 1\n", "tree:2: radius is 0, wanted a number above 0"},
    {"ANegativeRadius", "1 1 0 0 0 -0.5 -1\n2 3 0 0 2 1 1\n",
     "tree:1: radius is -0.5, wanted a number above 0"},
    {"ARadiusThatUnderflows", "1 1 0 0 0 1 -1\n2 3 0 0 2 1e-999 1\n",
     "tree:2: radius is 1e-999, wanted a number above 0"},
    {"ARadiusBelowAnAtom", "1 1 0 0 0 1 -1\n2 3 0 0 2 1e-80 1\n",
     "tree:2: radius is 1e-80, wanted at least 1e-12"},
    {"AFractionForAnId", "1.5 1 0 0 0 1 -1\n", "tree:1: id is 1.5, wanted a whole number"},
    {"AnIdBeyondAllIntegers", "1e30 1 0 0 0 1 -1\n", "tree:1: id is 1e30, wanted a whole number"},
    {"AnIdTwice", "1 1 0 0 0 1 -1\n2 3 0 0 2 1 1\n2 3 1 0 2 1 1\n",
     "tree:3: id is 2 as on line 2, wanted one that stands once"},
    {"AParentThatIsNotThere", "1 1 0 0 0 1 -1\n2 3 0 0 2 1 7\n",
     "tree:2: parent is 7, wanted -1 or the id of a sample in this file"},
    {"ItsOwnParent", "1 1 0 0 0 1 -1\n2 3 0 0 2 1 2\n",
     "tree:2: parents go round in a circle (2 > 2), wanted parents that lead to a root"},
    {"ACycleAmongParents", "1 1 0 0 0 1 -1\n2 3 0 0 2 1 4\n3 3 0 0 3 1 2\n4 3 0 0 4 1 3\n",
     "tree:2: parents go round in a circle (2 > 4 > 3 > 2), wanted parents that lead to a root"},
    {"NoRootAtAll", "1 3 0 0 0 1 2\n2 3 0 0 2 1 1\n",
     "tree:1: parents go round in a circle (1 > 2 > 1), wanted parents that lead to a root"},
    {"ARootAlone", "1 1 0 0 0 1 -1\n", "tree: no branch, wanted at least one"},
    {"APointForAPlant", "1 1 3 4 5 1 -1\n2 3 3 4 5 1 1\n",
     "tree: the whole plant measures 0 m, wanted at least 1e-06 m"},
    {"CoordinatesThatHaveLostTheLengths", "1 1 0 0 999999999 1 -1\n2 3 0 0 999999999.0000019 1 1\n",
     "tree: coordinates up to 1e+09 m are known to 2.22045e-07 m only, with branches of "
     "1.90735e-06 m on average, wanted coordinates nearer to the origin or in higher precision"},
};

const std::string ours = "# tremula skeleton\n1 1 0 0 0 1 -1\n2 2 0 0 2 1 1\n";
const std::vector<BadText> bad_own_swc = {
    {"AnOriginOfTwoNumbers", ours + "# origin 1 2\n", "tree:4: 2 values after '# origin', wanted 3: x y z"},
    {"AnOriginThatIsNotFinite", ours + "# origin 1 2 nan\n",
     "tree:4: origin z is nan, wanted a finite number"},
    {"ALeafWithAMissingNumber", ours + "# leaf 2 1 0 0 2 1 0 0 0 0 1 0.1 0.1 0.1\n",
     "tree:4: 14 values after '# leaf', wanted 15: sample position base axis normal length width area mass"},
    {"ALeafOnNoSample", ours + "# leaf 9 1 0 0 2 1 0 0 0 0 1 0.1 0.1 0.1 0.1\n",
     "tree:4: leaf sample is 9, wanted the id of a sample that ends a branch"},
    {"ALeafOnARoot", ours + "# leaf 1 1 0 0 2 1 0 0 0 0 1 0.1 0.1 0.1 0.1\n",
     "tree:4: leaf sample is 1, wanted the id of a sample that ends a branch"},
    {"ALeafWithoutArea", ours + "# leaf 2 1 0 0 2 1 0 0 0 0 1 0.1 0.1 0 0.1\n",
     "tree:4: leaf area is 0, wanted a number above 0"},
    {"ALeafBeyondItsBranch", ours + "# leaf 2 1.5 0 0 2 1 0 0 0 0 1 0.1 0.1 0.1 0.1\n",
     "tree: leaf 0: position is 1.5, wanted 0 (start of the branch) to 1 (end)"},
    {"ALeafAxisThatIsNoUnitVector", ours + "# leaf 2 1 0 0 2 3 0 0 0 0 1 0.1 0.1 0.1 0.1\n",
     "tree: leaf 0: axis has length 3, wanted a unit vector"},
    {"AFootInTheAir", ours + "3 16 0 0 3 1 -1\n", "tree:4: a foot (type 16) without parent, wanted a parent"},
    {"AFootOnAFoot", ours + "3 16 0 0 3 1 2\n4 16 0 0 4 1 3\n",
     "tree:5: a foot (type 16) on a foot, wanted a foot on a root or on the end of a branch"},
};

const std::string good_row = "0.1\t1\t0\t0\t0\t0\t0\t1\t0\t2\t1\t0\t1\t0\t0.1\n";
const std::vector<BadText> bad_treeqsm = {
    {"AChangeOfColumns", good_row + "0.1 1 0 0 1 0 0 1 1 0 1 0 2 0\n",
     "tree:2: 14 columns, wanted 15 as in the lines before"},
    {"AHeaderWithoutItsColumns", "radius\tlength\tstart\taxis\tparent\n0.1 1 0\n",
     "tree:2: 1 column, wanted 9 as in the header"},
    {"AHeaderAlone", "radius\tlength\tstart\taxis\tparent\n", "tree: no branch, wanted at least one"},
    {"AWordForALength", "0.1 long 0 0 0 0 0 1 0 2 1 0 1 0 0.1\n", "tree:1: length is long, wanted a number"},
    {"AWordInAColumnThatIsNotUsed", "0.1 1 0 0 0 0 0 1 0 2 1 0 1 no 0.1\n",
     "tree:1: column 14 is no, wanted a number"},
    {"NaN", good_row + "0.1 NaN 0 0 1 0 0 1 1 0 1 0 2 0 0.1\n",
     "tree:2: length is nan, wanted a finite number"},
    {"ARadiusOfZero", good_row + "0 1 0 0 1 0 0 1 1 0 1 0 2 0 0.1\n",
     "tree:2: radius is 0, wanted a number above 0"},
    {"ANegativeLength", good_row + "0.1 -1 0 0 1 0 0 1 1 0 1 0 2 0 0.1\n",
     "tree:2: length is -1, wanted 0 or more"},
    {"AnOverflowInTheStart", good_row + "0.1 1 0 1e400 1 0 0 1 1 0 1 0 2 0 0.1\n",
     "tree:2: start y is inf, wanted a finite number"},
    {"AnAxisThatIsNoUnitVector", good_row + "0.1 1 0 0 1 0 3 4 1 0 1 0 2 0 0.1\n",
     "tree:2: length of the axis is 5, wanted 1"},
    {"NoAxis", good_row + "0.1 1 0 0 1 0 0 0 1 0 1 0 2 0 0.1\n", "tree:2: length of the axis is 0, wanted 1"},
    {"AParentThatIsNotThere", good_row + "0.1 1 0 0 1 0 0 1 3 0 1 0 2 0 0.1\n",
     "tree:2: parent is 3, wanted 0 or the number of one of the 2 cylinders"},
    {"ANegativeParent", good_row + "0.1 1 0 0 1 0 0 1 -1 0 1 0 2 0 0.1\n",
     "tree:2: parent is -1, wanted 0 or the number of one of the 2 cylinders"},
    {"AFractionForAParent", good_row + "0.1 1 0 0 1 0 0 1 0.5 0 1 0 2 0 0.1\n",
     "tree:2: parent is 0.5, wanted 0 or the number of one of the 2 cylinders"},
    {"AParentBeyondAllCounts", good_row + "0.1 1 0 0 1 0 0 1 1e300 0 1 0 2 0 0.1\n",
     "tree:2: parent is 1e+300, wanted 0 or the number of one of the 2 cylinders"},
    {"ItsOwnParent", good_row + "0.1 1 0 0 1 0 0 1 2 0 1 0 2 0 0.1\n",
     "tree:2: parent is 2, the cylinder itself (were rows taken out? Parents count the rows of the whole "
     "table), wanted all rows, or a column of ids that parents name"},
    {"ACycleAmongParents",
     good_row + "0.1 1 0 0 1 0 0 1 3 0 1 0 2 0 0.1\n" + "0.1 1 0 0 2 0 0 1 2 0 1 0 2 0 0.1\n",
     "tree:2: parents go round in a circle (2 > 3 > 2), wanted parents that lead to a root"},
};

const std::string header = "ID, parentID, startX, startY, startZ, endX, endY, endZ, radius, length\n";
const std::string base = "0,-1,0,0,0,0,0,2,0.1,2\n";
const std::vector<BadText> bad_simpleforest = {
    {"AHeaderAlone", header, "tree: no branch, wanted at least one"},
    {"AHeaderWithoutRadius", "ID,parentID,startX,startY,startZ,endX,endY,endZ\n0,-1,0,0,0,0,0,2\n",
     "tree:1: a header without a radius, "
     "wanted columns for the parent, the radius, the start (x y z) and the end (x y z), or an axis (x y z) "
     "and a length"},
    {"AHeaderWithoutStart", "\nID, parentID\n",
     "tree:2: a header without a radius, "
     "wanted columns for the parent, the radius, the start (x y z) and the end (x y z), or an axis (x y z) "
     "and a length"},
    {"AMissingColumn", header + base + "1,0,0,0,2,0,0,3,0.1\n",
     "tree:3: 9 columns, wanted 10 as in the header"},
    {"AnExtraColumn", header + base + "1,0,0,0,2,0,0,3,0.1,1,1\n",
     "tree:3: 11 columns, wanted 10 as in the header"},
    {"AnEmptyField", header + base + "1,0,0,,2,0,0,3,0.1,1\n", "tree:3: startY is , wanted a number"},
    {"AWordForANumber", header + base + "1,0,0,0,2,0,0,up,0.1,1\n", "tree:3: endZ is up, wanted a number"},
    {"NaN", header + base + "1,0,0,0,2,NaN,0,3,0.1,1\n", "tree:3: end x is nan, wanted a finite number"},
    {"Infinity", header + base + "1,0,0,0,2,0,0,Inf,0.1,1\n", "tree:3: end z is inf, wanted a finite number"},
    {"ANegativeRadius", header + base + "1,0,0,0,2,0,0,3,-1e-3,1\n",
     "tree:3: radius is -0.001, wanted a number above 0"},
    {"ARadiusOfZero", header + "0,-1,0,0,0,0,0,2,0.0,2\n", "tree:2: radius is 0, wanted a number above 0"},
    {"AnIdTwice", header + base + "5,0,0,0,2,0,0,3,0.1,1\n0,5,0,0,3,0,0,4,0.1,1\n",
     "tree:4: ID is 0 as on line 2, wanted one that stands once"},
    {"AParentThatIsNotThere", header + base + "1,7,0,0,2,0,0,3,0.1,1\n",
     "tree:3: parentID is 7, and no row has that ID (were rows taken out?), wanted -1 or the ID of a "
     "cylinder in this file, or --allow-gaps to join what it carried"},
    {"ACycleAmongParents", header + base + "1,2,0,0,2,0,0,3,0.1,1\n2,1,0,0,3,0,0,4,0.1,1\n",
     "tree:3: parents go round in a circle (3 > 4 > 3), wanted parents that lead to a root"},
};

INSTANTIATE_TEST_SUITE_P(Any, TextFile, testing::ValuesIn(bad_anywhere), name_of);
INSTANTIATE_TEST_SUITE_P(Swc, TextFile, testing::ValuesIn(bad_swc), name_of);
INSTANTIATE_TEST_SUITE_P(OwnSwc, TextFile, testing::ValuesIn(bad_own_swc), name_of);
INSTANTIATE_TEST_SUITE_P(TreeQsm, TextFile, testing::ValuesIn(bad_treeqsm), name_of);
INSTANTIATE_TEST_SUITE_P(SimpleForest, TextFile, testing::ValuesIn(bad_simpleforest), name_of);

// What people drop in, by its first bytes.
const std::vector<BadText> foreign = {
    {"APlyFile", "ply\nformat ascii 1.0\n", "a PLY file"},
    {"AnObjFile", "# Blender\nmtllib oak.mtl\no oak\nv 0 0 0\n", "an OBJ file"},
    {"AnObjFileOfVertices", "v 0 0 0\nv 1 0 0\n", "an OBJ file"},
    {"AnStlFile", "solid oak\n facet normal 0 0 1\n", "an STL file"},
    {"ALasFile", std::string("LASF\0\0\0", 7), "a LAS or LAZ file"},
    {"AnE57File", "ASTM-E57\1", "an E57 file"},
    {"APcdFile", "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\n", "a PCD file"},
    {"AnXyzFile", "1.5 2.5 3.5\n1.6 2.5 3.5\n", "a point cloud is no tree model yet"},
    {"AnXyzFileWithColours", "1.5 2.5 3.5 0.5 255 128 7.5\n", "a point cloud is no tree model yet"},
    {"AnMtg", "CODE:\tFORM-A\nCLASSES:\n", "a multiscale tree graph (MTG)"},
    {"AnLpyModel", "Axiom: A(0)\nderivation length: 5\nproduction:\n", "an L-Py model"},
    {"AnLSystem", "# oak\naxiom: F(1)\n", "an L-system, wanted a name that ends in .lsys"},
    {"AJsonFile", "{\"name\": 1}", "a JSON file"},
    {"AnXmlFile", "<?xml version='1.0'?>", "an XML file"},
    {"AGzipFile", "\x1F\x8B\x08", "packed with gzip"},
    {"AZipFile", "PK\x03\x04", "a zip archive"},
    {"ATableInUtf16",
     std::string("\xFF\xFE"
                 "1\0 \0",
                 6),
     "text in UTF-16, wanted text in UTF-8"},
};

class ForeignFile : public testing::TestWithParam<BadText> {};

TEST_P(ForeignFile, IsNamedForWhatItIs) {
  const std::string complaint = test::complaint_about_bytes(GetParam().text, "tree");
  EXPECT_TRUE(complaint.starts_with("tree:")) << complaint;
  EXPECT_NE(complaint.find(GetParam().complaint), std::string::npos) << complaint;
}

INSTANTIATE_TEST_SUITE_P(Known, ForeignFile, testing::ValuesIn(foreign), name_of);

TEST(ReadSkeleton, RefusesADeviceWithoutReadingIt) {
  EXPECT_EQ(test::complaint_of([] { read_skeleton("/dev/zero"); }), "/dev/zero: is a device, wanted a file");
}

TEST(ReadSkeleton, RejectsAFolderAndWhatIsNotThere) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path / "tree");
  EXPECT_EQ(complaint_about(folder / "tree"), "tree: is a folder, wanted a file");
  EXPECT_EQ(complaint_about(folder / "oak"),
            "oak: cannot be opened (No such file or directory), wanted a readable file");
}

// ---- MATLAB
// ------------------------------------------------------------------------------------------------------

using Fields = std::vector<test::MatVariable>;

std::string complaint_about_fields(Fields fields) {
  const TemporaryFolder folder;
  test::save_model(folder / "tree.mat", std::move(fields));
  return complaint_about(folder / "tree.mat");
}

std::string complaint_about_bytes(std::string_view bytes) {
  return test::complaint_about_bytes(bytes, "tree.mat");
}

// One field of the small tree put another way.
std::string complaint_with(std::size_t field, test::MatVariable value) {
  Fields fields = test::mat_cylinder_fields(small_table());
  fields.at(field) = std::move(value);
  return complaint_about_fields(std::move(fields));
}

enum { radius, length, start, axis, parent };

std::string bytes_of_small_model(bool compressed) {
  const TemporaryFolder folder;
  test::save_model(folder / "tree.mat", test::mat_cylinder_fields(small_table()), compressed);
  std::ifstream file(folder / "tree.mat", std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(MatFile, IsReadBeforeItIsDamaged) {
  EXPECT_EQ(complaint_about_fields(test::mat_cylinder_fields(small_table())), "");
  EXPECT_EQ(complaint_about_bytes(bytes_of_small_model(true)), "");
  EXPECT_EQ(complaint_about_bytes(bytes_of_small_model(false)), "");
}

TEST(MatFile, IsRejectedWithoutCylinders) {
  const TemporaryFolder folder;
  Fields variables;
  variables.push_back(test::mat_array("k1", 3, 1, {1, 2, 3}));
  variables.push_back(test::mat_text("note", "no tree"));
  test::save_mat(folder / "tree.mat", std::move(variables));
  EXPECT_EQ(
      complaint_about(folder / "tree.mat"),
      "tree.mat: a MATLAB file that holds k1 (numbers), note (text), wanted a TreeQSM model: a struct QSM "
      "with a field cylinder, a struct cylinder, or the arrays Rad Len Sta Axe CPar");
}

TEST(MatFile, IsRejectedWhereAFieldIsMissing) {
  Fields fields = test::mat_cylinder_fields(small_table());
  fields.erase(fields.begin() + axis);
  EXPECT_EQ(complaint_about_fields(std::move(fields)),
            "tree.mat: QSM.cylinder.axis: missing, wanted an array of numbers");
  const TemporaryFolder folder;
  fields = test::mat_cylinder_fields(small_table(), true);
  fields.pop_back();
  test::save_mat(folder / "tree.mat", std::move(fields));
  EXPECT_EQ(complaint_about(folder / "tree.mat"), "tree.mat: CPar: missing, wanted an array of numbers");
}

TEST(MatFile, IsRejectedWhereCylinderIsNoStruct) {
  std::vector<Fields> model(1);
  model[0].push_back(test::mat_array("cylinder", 1, 1, {7}));
  Fields variables;
  variables.push_back(test::mat_struct("QSM", std::move(model)));
  const TemporaryFolder folder;
  test::save_mat(folder / "tree.mat", std::move(variables));
  EXPECT_EQ(complaint_about(folder / "tree.mat"),
            "tree.mat: QSM.cylinder: an array of class 6, wanted a struct (class 2)");
}

TEST(MatFile, IsRejectedWithoutACylinderInIt) {
  Fields fields;
  for (const char* name : {"radius", "length", "parent"}) fields.push_back(test::mat_array(name, 0, 1, {}));
  for (const char* name : {"start", "axis"}) fields.push_back(test::mat_array(name, 0, 3, {}));
  EXPECT_EQ(complaint_about_fields(std::move(fields)), "tree.mat: no branch, wanted at least one");
}

TEST(MatFile, IsRejectedWhereSizesDisagree) {
  EXPECT_EQ(complaint_with(length, test::mat_array("length", 2, 1, {1, 1})),
            "tree.mat: QSM.cylinder.length: 2 x 1 numbers, wanted 3 for as many cylinders as have a radius");
  EXPECT_EQ(
      complaint_with(start, test::mat_array("start", 3, 2, {0, 0, 0, 0, 0, 0})),
      "tree.mat: QSM.cylinder.start: 3 x 2 numbers, wanted 3 x 3 for as many cylinders as have a radius");
  EXPECT_EQ(complaint_with(parent, test::mat_array("parent", 0, 0, {})),
            "tree.mat: QSM.cylinder.parent: 0 x 0 numbers, wanted 3 for as many cylinders as have a radius");
  EXPECT_EQ(complaint_with(radius, test::mat_array("radius", 1, 1, {0.1})),
            "tree.mat: QSM.cylinder.length: 3 x 1 numbers, wanted 1 for as many cylinders as have a radius");
}

TEST(MatFile, IsRejectedWhereAFieldIsNoRealNumbers) {
  EXPECT_EQ(complaint_with(radius, test::mat_text("radius", "abc")),
            "tree.mat: QSM.cylinder.radius: an array of class 4, wanted real numbers (class 6 to 15)");
  EXPECT_EQ(complaint_with(length, test::mat_complex("length", {1, 1, 1}, {0, 1, 0})),
            "tree.mat: QSM.cylinder.length: complex numbers, wanted real numbers (class 6 to 15)");
  std::vector<Fields> inner(3);
  for (Fields& fields : inner) fields.push_back(test::mat_array("r", 1, 1, {1}));
  EXPECT_EQ(complaint_with(radius, test::mat_struct("radius", std::move(inner))),
            "tree.mat: QSM.cylinder.radius: an array of class 2, wanted real numbers (class 6 to 15)");
}

TEST(MatFile, IsRejectedWithTheCylinderThatIsImpossible) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  const auto column = [](const char* name, double a, double b, double c) {
    return test::mat_array(name, 3, 1, {a, b, c});
  };
  EXPECT_EQ(complaint_with(radius, column("radius", 1, 0, 1)),
            "tree.mat: cylinder 2: radius is 0, wanted a number above 0");
  EXPECT_EQ(complaint_with(radius, column("radius", 1, 1, nan)),
            "tree.mat: cylinder 3: radius is nan, wanted a finite number");
  EXPECT_EQ(complaint_with(length, column("length", inf, 1, 1)),
            "tree.mat: cylinder 1: length is inf, wanted a finite number");
  EXPECT_EQ(complaint_with(length, column("length", 1, -2, 1)),
            "tree.mat: cylinder 2: length is -2, wanted 0 or more");
  EXPECT_EQ(complaint_with(parent, column("parent", 0, 4, 1)),
            "tree.mat: cylinder 2: parent is 4, wanted 0 or the number of one of the 3 cylinders");
  EXPECT_EQ(
      complaint_with(parent, column("parent", 0, 3, 2)),
      "tree.mat: cylinder 2: parents go round in a circle (2 > 3 > 2), wanted parents that lead to a root");
  EXPECT_EQ(complaint_with(start, test::mat_array("start", 3, 3, {0, 0, 0, 0, 0, 0, 0, 1, nan})),
            "tree.mat: cylinder 3: start z is nan, wanted a finite number");
  EXPECT_EQ(complaint_with(axis, test::mat_array("axis", 3, 3, {0, 0, 0, 0, 0, 0, 1, 1, 1e6})),
            "tree.mat: cylinder 3: length of the axis is 1e+06, wanted 1");
  EXPECT_EQ(complaint_with(axis, test::mat_array("axis", 3, 3, {0, 0, 0, 0, 0, 0, 1, 1, 1e10})),
            "tree.mat: cylinder 3: length of the axis is 1e+10, wanted 1");
}

TEST(MatFile, IsRejectedInSinglePrecisionFarFromTheOrigin) {
  test::CylinderTable table = small_table();
  for (Vec3& s : table.start) s += Vec3(500000, 4649776, 250);
  EXPECT_EQ(complaint_about_fields(test::mat_cylinder_fields(table)), "");
  EXPECT_EQ(complaint_about_fields(test::mat_cylinder_fields(table, false, MAT_C_SINGLE)),
            "tree.mat: coordinates up to 4.64978e+06 m are known to 0.554296 m only, with branches of "
            "0.833333 m on average, wanted coordinates nearer to the origin or in higher precision");
}

TEST(MatFile, IsRejectedWhenItIsOfAnotherVersion) {
  std::string bytes = bytes_of_small_model(false);
  EXPECT_EQ(complaint_about_bytes("\x89HDF\r\n\x1a\n"),
            "tree.mat: a MATLAB 7.3 (HDF5) file, wanted one saved with save(..., '-v7')");
  bytes[125] = 2;
  EXPECT_EQ(complaint_about_bytes(bytes),
            "tree.mat: a MATLAB 7.3 (HDF5) file, wanted one saved with save(..., '-v7')");
  bytes[125] = 3;
  EXPECT_EQ(complaint_about_bytes(bytes), "tree.mat: MATLAB file version 768, wanted 256 (level 5)");
  bytes[126] = 'X';
  EXPECT_EQ(complaint_about_bytes(bytes),
            "tree.mat: a MATLAB header without its mark of byte order, wanted IM or MI at byte 126");
  EXPECT_EQ(complaint_about_bytes("MATLAB 5.0 MAT-file"),
            "tree.mat: 19 bytes, wanted the 128 with which a MATLAB file begins");
}

TEST(MatFile, IsRejectedWhereverItIsCutOff) {
  for (const bool compressed : {true, false}) {
    const std::string bytes = bytes_of_small_model(compressed);
    for (std::size_t size = 129; size < bytes.size(); ++size) {
      const std::string complaint = complaint_about_bytes(std::string_view(bytes).substr(0, size));
      const std::size_t left = size - 136;
      EXPECT_EQ(complaint,
                size < 136 ? "tree.mat: variable 1: ends where the next of its elements should begin, wanted "
                             "a whole file"
                           : "tree.mat: variable 1: an element of " + std::to_string(bytes.size() - 136) +
                                 " bytes where " + std::to_string(left) + " are left, wanted a whole file");
    }
  }
  EXPECT_EQ(complaint_about_bytes(bytes_of_small_model(true).substr(0, 128)),
            "tree.mat: a MATLAB file that holds nothing, wanted a TreeQSM model: a struct QSM with a field "
            "cylinder, a struct cylinder, or the arrays Rad Len Sta Axe CPar");
}

// Where in an uncompressed file the data of a field begin: after its name, found by the number that stands
// there.
std::string with_word(std::string bytes, std::size_t at, std::uint32_t value) {
  std::memcpy(&bytes.at(at), &value, 4);
  return bytes;
}

TEST(MatFile, IsRejectedWhereItsCountsAreImpossible) {
  // Byte 128: the tag of the variable; 136: array flags (tag and 8 bytes); 152: dimensions (tag and 2
  // numbers); 168: the name "QSM" as a small element; 176: the width of field names; 184: the names.
  const std::string bytes = bytes_of_small_model(false);
  EXPECT_EQ(complaint_about_bytes(with_word(bytes, 128, 3)),
            "tree.mat: variable 1: an array of element type 3, wanted type 14");
  EXPECT_EQ(complaint_about_bytes(with_word(bytes, 132, 0xFFFFFFF0)),
            "tree.mat: variable 1: an element of 4294967280 bytes where " +
                std::to_string(bytes.size() - 136) + " are left, wanted a whole file");
  EXPECT_EQ(complaint_about_bytes(with_word(bytes, 136, 9)),
            "tree.mat: variable 1: array flags of element type 9, wanted type 6");
  EXPECT_EQ(complaint_about_bytes(with_word(bytes, 152, 9)),
            "tree.mat: variable 1: dimensions of element type 9, wanted type 5");
  EXPECT_EQ(complaint_about_bytes(with_word(bytes, 160, 0xFFFFFFFF)),
            "tree.mat: variable 1: dimension -1, wanted 0 or more");
  EXPECT_EQ(complaint_about_bytes(with_word(with_word(bytes, 160, 0x7FFFFFFF), 164, 0x7FFFFFFF)),
            "tree.mat: variable 1: dimensions with a product above 2^40, wanted what fits into the file");
  EXPECT_EQ(complaint_about_bytes(with_word(bytes, 168, 0x00070001)),
            "tree.mat: variable 1: a small element of 7 bytes, wanted at most 4");
  EXPECT_EQ(complaint_about_bytes(with_word(bytes, 180, 0)),
            "tree.mat: QSM: field names of length 0, wanted at least 1");
}

TEST(MatFile, IsRejectedInOneLineWhateverItsVariableIsCalled) {
  std::string bytes = bytes_of_small_model(false);
  ASSERT_EQ(bytes.substr(172, 3), "QSM");
  bytes.replace(172, 3, "\n\xFF\"");
  EXPECT_EQ(complaint_about_bytes(with_word(bytes, 180, 0)),
            "tree.mat: ??\": field names of length 0, wanted at least 1");
}

TEST(MatFile, IsRejectedWhereItsBytesHoldMoreOrFewerCylindersThanItClaims) {
  // 3 x 1 numbers become 4 x 1, or 2 x 1, in every field; the bytes stay.
  const std::string three_by_one("\5\0\0\0\10\0\0\0\3\0\0\0\1\0\0\0", 16);
  for (const char claimed : {4, 2}) {
    std::string bytes = bytes_of_small_model(false);
    for (std::size_t at = 0; (at = bytes.find(three_by_one, at)) != std::string::npos; ++at)
      bytes[at + 8] = claimed;
    EXPECT_EQ(complaint_about_bytes(bytes), "tree.mat: QSM.cylinder.radius: 24 bytes of numbers, wanted " +
                                                std::to_string(8 * claimed) + " by its dimensions");
  }
}

TEST(MatFile, IsRejectedWhereItClaimsMoreCylindersThanAnyoneReads) {
  std::string bytes = bytes_of_small_model(false);
  const std::string three_by_one("\5\0\0\0\10\0\0\0\3\0\0\0\1\0\0\0", 16);
  bytes = with_word(bytes, bytes.find(three_by_one) + 8, 60'000'000);
  EXPECT_EQ(complaint_about_bytes(bytes),
            "tree.mat: QSM.cylinder.radius: 60000000 cylinders, wanted at most 50000000");
}

TEST(MatFile, IsRejectedWhereItsCompressedDataAreDamaged) {
  std::string bytes = bytes_of_small_model(true);
  bytes[bytes.size() - 1] = static_cast<char>(bytes[bytes.size() - 1] ^ 1);  // the check sum
  EXPECT_EQ(complaint_about_bytes(bytes),
            "tree.mat: variable 1: compressed data that are damaged, wanted a whole file");
  std::string cut = bytes_of_small_model(true);
  cut.resize(cut.size() - 20);
  cut = with_word(cut, 132, static_cast<std::uint32_t>(cut.size() - 136));
  EXPECT_EQ(complaint_about_bytes(cut),
            "tree.mat: variable 1: compressed data that break off, wanted a whole file");
}

// A megabyte of zeros packs to a thousandth: what unpacks to more than a hundred times its size is refused by
// the size that stands in it, before memory is taken for it.
TEST(MatFile, IsRejectedWhereItUnpacksToAHundredTimesItsSize) {
  const TemporaryFolder folder;
  Fields variables;
  variables.push_back(test::mat_array("zeros", 9'000'000, 1, std::vector<double>(9'000'000, 0.0)));
  test::save_mat(folder / "tree.mat", std::move(variables));
  const std::string complaint = complaint_about(folder / "tree.mat");
  EXPECT_NE(complaint.find("bytes that unpack to 720000"), std::string::npos) << complaint;
  EXPECT_NE(complaint.find("wanted at most 67108864"), std::string::npos) << complaint;
}

TEST(MatFile, IsRejectedWhereCylindersAreStructsOfTheirOwn) {
  std::vector<Fields> cylinders(2), model(1);
  for (Fields& fields : cylinders) fields = test::mat_cylinder_fields(small_table());
  model[0].push_back(test::mat_struct("cylinder", std::move(cylinders)));
  Fields variables;
  variables.push_back(test::mat_struct("QSM", std::move(model)));
  const TemporaryFolder folder;
  test::save_mat(folder / "tree.mat", std::move(variables));
  EXPECT_EQ(complaint_about(folder / "tree.mat"),
            "tree.mat: QSM.cylinder: an array of 2 structs, wanted one struct of arrays with a row for each "
            "cylinder");
}

}  // namespace
}  // namespace tremula
