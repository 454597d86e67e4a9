#include "tremula/io/treeqsm.hpp"

#include <cmath>
#include <numbers>
#include <sstream>

#include <gmock/gmock.h>

#include "io/input_files.hpp"
#include "trees.hpp"

namespace tremula {
namespace {

using test::count_of;
using test::CylinderTable;
using test::data_folder;
using test::read_text;
using test::small_table;
using test::TemporaryFolder;

// TreeQSM's columns, 17 of them with mad and surface coverage.
std::string to_text(const CylinderTable& table, const std::string& separator = "\t",
                    bool version_24 = false) {
  std::ostringstream text;
  text.precision(17);
  for (std::size_t k = 0; k < table.size(); ++k) {
    const char* s = separator.c_str();
    text << table.radius[k] << s << table.length[k];
    for (int i = 0; i < 3; ++i) text << s << table.start[k][i];
    for (int i = 0; i < 3; ++i) text << s << table.axis[k][i];
    text << s << table.parent[k] << s << 0 << s << 1 << s << 0 << s << 1;
    if (version_24) text << s << "NaN" << s << 0.5;
    text << s << 0 << s << table.radius[k] << "\n";
  }
  return text.str();
}

CylinderTable random_table(int count, std::uint64_t seed) {
  const auto draw = [&](int k, std::uint32_t what) {
    return uniform({seed, RandomStream::test, what, static_cast<std::uint64_t>(k)});
  };
  CylinderTable table;
  for (int k = 0; k < count; ++k) {
    const int parent = k == 0 ? 0 : 1 + static_cast<int>(draw(k, 0) * k);
    const Vec3 axis = Vec3(draw(k, 1) - 0.5, draw(k, 2) - 0.5, draw(k, 3) - 0.2).normalized();
    Vec3 start = Vec3::Zero();
    if (parent > 0)
      start = table.start[parent - 1] + table.length[parent - 1] * draw(k, 4) * table.axis[parent - 1];
    table.add(0.01 + 0.1 * draw(k, 5), 0.1 + draw(k, 6), start, axis, parent);
  }
  return table;
}

void expect_same(const Skeleton& a, const Skeleton& b, double tolerance) {
  ASSERT_EQ(a.branch_count(), b.branch_count());
  ASSERT_EQ(a.root_count(), b.root_count());
  for (int k = 0; k < a.branch_count(); ++k) {
    const Branch& p = a.branches[std::size_t(k)];
    const Branch& q = b.branches[std::size_t(k)];
    EXPECT_EQ(p.start_node, q.start_node) << k;
    EXPECT_LE((p.start - q.start).norm(), tolerance) << k;
    EXPECT_LE((p.end - q.end).norm(), tolerance) << k;
    EXPECT_LE(std::abs(p.start_radius - q.start_radius), tolerance) << k;
    EXPECT_LE(std::abs(p.end_radius - q.end_radius), tolerance) << k;
  }
}

double volume(const Skeleton& skeleton) {
  double sum = 0;
  for (const Branch& b : skeleton.branches)
    sum += std::numbers::pi * b.start_radius * b.start_radius * b.length();
  return sum;
}

// As TreeQSM's tree_data reckons it: from the lowest start to the end of the cylinder with the highest start.
double height(const Skeleton& skeleton) {
  const auto lower = [](const Branch& a, const Branch& b) { return a.start.z() < b.start.z(); };
  const auto [bottom, top] = std::minmax_element(skeleton.branches.begin(), skeleton.branches.end(), lower);
  return std::max(top->start.z(), top->end.z()) - bottom->start.z();
}

// ---- text
// ------------------------------------------------------------------------------------------------------

TEST(ReadTreeQsmText, GivesTheReferenceTreeExactlyAsItStands) {
  TREMULA_NEED_DATA("modes/random_tree_62.txt");
  const std::filesystem::path path = data_folder() / "modes/random_tree_62.txt";
  const ImportedSkeleton imported = read_skeleton(path.string());
  EXPECT_EQ(imported.format, "treeqsm-text");
  EXPECT_TRUE(imported.repairs.empty());
  expect_same(imported.skeleton, test::cylinders_from_text(path), 1e-15);
  for (const Branch& branch : imported.skeleton.branches) {
    EXPECT_EQ(branch.start, imported.skeleton.node_position(branch.start_node));
    EXPECT_EQ(branch.start_radius, branch.end_radius);
  }
}

TEST(ReadTreeQsmText, HangsAChildOnTheNearerEndOfItsParent) {
  CylinderTable table = small_table();
  table.add(0.01, 0.3, {0.05, 0, 0.9}, {1, 0, 0}, 1);  // near the end of cylinder 1, at z = 1
  table.add(0.01, 0.3, {0, 0.05, 1.1}, {0, 1, 0}, 2);  // near the start of cylinder 2
  const Skeleton skeleton = read_text(to_text(table)).skeleton;
  ASSERT_EQ(skeleton.branch_count(), 5);
  EXPECT_EQ(skeleton.branches[0].start_node, 0);
  EXPECT_EQ(skeleton.branches[1].start_node, 1);
  EXPECT_EQ(skeleton.branches[2].start_node, 1);
  EXPECT_EQ(skeleton.branches[3].start_node, 1);
  EXPECT_EQ(skeleton.branches[4].start_node, 1);  // which is where cylinder 2 starts
  EXPECT_EQ(skeleton.branches[3].start, Vec3(0.05, 0, 0.9));
  EXPECT_EQ(skeleton.branches[4].start, Vec3(0, 0.05, 1.1));
}

TEST(ReadTreeQsmText, TakesWhatIsANodeWithinRoundOffForTheNode) {
  CylinderTable table = small_table();
  table.start[1].x() = 1e-10;
  table.start[2].x() = 1e-5;  // really elsewhere
  const Skeleton skeleton = read_text(to_text(table)).skeleton;
  EXPECT_EQ(skeleton.branches[1].start, Vec3(0, 0, 1));
  EXPECT_EQ(skeleton.branches[2].start, Vec3(1e-5, 0, 1));
}

TEST(ReadTreeQsmText, ReadsTheSameTreeWhateverSeparatesItsColumns) {
  const CylinderTable table = random_table(40, 1);
  const std::string tabs = to_text(table);
  const Skeleton expected = read_text(tabs).skeleton;
  std::string windows = tabs;
  for (std::size_t at = 0; (at = windows.find('\n', at)) != std::string::npos; at += 2)
    windows.replace(at, 1, "\r\n");
  std::string header = "radius (m)\tlength (m)\tstart_point\taxis_direction\tparent\textension\n";
  for (const std::string& text :
       {to_text(table, "  "), to_text(table, ", "), to_text(table, ";"), windows, header + tabs,
        to_text(table, "\t", true), "\xEF\xBB\xBF" + tabs, "# by hand\n\n" + tabs + "\n"}) {
    const ImportedSkeleton imported = read_text(text);
    EXPECT_EQ(imported.format, "treeqsm-text");
    expect_same(imported.skeleton, expected, 0);
  }
}

// ---- .mat
// ------------------------------------------------------------------------------------------------------

TEST(ReadTreeQsmMat, AgreesWithTheSameTreeAsText) {
  const TemporaryFolder folder;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const CylinderTable table = random_table(30, seed);
    const Skeleton expected = read_text(to_text(table)).skeleton;
    for (const bool compressed : {true, false}) {
      test::save_model(folder / "new.mat", test::mat_cylinder_fields(table), compressed);
      test::save_mat(folder / "old.mat", test::mat_cylinder_fields(table, true), compressed);
      for (const char* name : {"new.mat", "old.mat"}) {
        const ImportedSkeleton imported = read_skeleton(folder / name);
        EXPECT_EQ(imported.format, "treeqsm-mat");
        EXPECT_TRUE(imported.repairs.empty());
        expect_same(imported.skeleton, expected, 0);
      }
    }
  }
}

TEST(ReadTreeQsmMat, ConvertsEveryClassOfNumber) {
  const TemporaryFolder folder;
  const CylinderTable table = random_table(30, 1);
  const Skeleton expected = read_text(to_text(table)).skeleton;
  for (const matio_classes whole : {MAT_C_UINT16, MAT_C_INT32, MAT_C_UINT64, MAT_C_SINGLE}) {
    test::save_model(folder / "tree.mat", test::mat_cylinder_fields(table, false, MAT_C_DOUBLE, whole));
    expect_same(read_skeleton(folder / "tree.mat").skeleton, expected, 0);
  }
  // Single precision keeps 2^-24 of coordinates that stay below 16 m.
  test::save_model(folder / "tree.mat", test::mat_cylinder_fields(table, false, MAT_C_SINGLE, MAT_C_UINT16));
  expect_same(read_skeleton(folder / "tree.mat").skeleton, expected, 16 * 0x1p-22);
}

// Turns the bytes of every number of an uncompressed file round: what MATLAB writes on a big-endian machine.
void turn_elements(std::string& bytes, std::size_t first, std::size_t last) {
  const auto turn = [&](std::size_t at, std::size_t width) { std::reverse(&bytes[at], &bytes[at] + width); };
  while (first < last) {
    std::uint32_t tag[2];
    std::memcpy(tag, &bytes[first], 8);
    std::size_t data = first + 8, size = tag[1], type = tag[0], next = data + (size + 7) / 8 * 8;
    if (tag[0] >> 16) {  // a small element
      type = tag[0] & 0xFFFF;
      size = tag[0] >> 16;
      data = first + 4;
      next = first + 8;
      turn(first, 4);
    } else {
      turn(first, 4);
      turn(first + 4, 4);
    }
    constexpr std::size_t width_of[] = {0, 1, 1, 2, 2, 4, 4, 4, 0, 8, 0, 0, 8, 8};
    if (type == 14) {
      turn_elements(bytes, data, data + size);
    } else {
      for (std::size_t at = data; at < data + size; at += width_of[type]) turn(at, width_of[type]);
    }
    first = next;
  }
}

TEST(ReadTreeQsmMat, ReadsTheOtherByteOrder) {
  const TemporaryFolder folder;
  const CylinderTable table = random_table(30, 2);
  test::save_model(folder / "tree.mat", test::mat_cylinder_fields(table, false, MAT_C_DOUBLE, MAT_C_UINT16),
                   false);
  const Skeleton expected = read_skeleton(folder / "tree.mat").skeleton;
  std::ifstream file(folder / "tree.mat", std::ios::binary);
  std::string bytes(std::istreambuf_iterator<char>(file), {});
  ASSERT_EQ(bytes.substr(124, 4), std::string("\0\1IM", 4));
  bytes.replace(124, 4, std::string("\1\0MI", 4));
  turn_elements(bytes, 128, bytes.size());
  test::write_text(folder / "turned.mat", bytes);
  expect_same(read_skeleton(folder / "turned.mat").skeleton, expected, 0);
}

TEST(ReadTreeQsmMat, ReadsTheFirstOfSeveralModelsAndSaysSo) {
  const TemporaryFolder folder;
  std::vector<std::vector<test::MatVariable>> models(3);
  for (int i = 0; i < 3; ++i) {
    std::vector<std::vector<test::MatVariable>> cylinder(1);
    cylinder[0] = test::mat_cylinder_fields(random_table(10 + i, 3));
    models[std::size_t(i)].push_back(test::mat_struct("cylinder", std::move(cylinder)));
  }
  std::vector<test::MatVariable> variables;
  variables.push_back(test::mat_text("note", "models of one tree"));
  variables.push_back(test::mat_struct("QSMs", std::move(models)));
  test::save_mat(folder / "tree.mat", std::move(variables));
  const ImportedSkeleton imported = read_skeleton(folder / "tree.mat");
  EXPECT_EQ(imported.skeleton.branch_count(), 10);
  EXPECT_EQ(count_of(imported, "first_of_several"), 2u);
  EXPECT_EQ(test::message_of(imported, "first_of_several"), "the first of 3 models in QSMs read");
}

TEST(ReadTreeQsmMat, ReadsCylindersWithoutTheModelAroundThem) {
  const TemporaryFolder folder;
  const Skeleton expected = read_text(to_text(small_table())).skeleton;
  std::vector<std::vector<test::MatVariable>> cylinder(1);
  cylinder[0] = test::mat_cylinder_fields(small_table());
  std::vector<test::MatVariable> variables;
  variables.push_back(test::mat_text("note", "the struct alone"));
  variables.push_back(test::mat_struct("cylinder", std::move(cylinder)));
  test::save_mat(folder / "struct.mat", std::move(variables));
  test::save_mat(folder / "arrays.mat", test::mat_cylinder_fields(small_table()));
  for (const char* name : {"struct.mat", "arrays.mat"}) {
    expect_same(read_skeleton(folder / name).skeleton, expected, 0);
  }
}

TEST(ReadTreeQsmMat, ReadsTheFirstModelOfACellArray) {
  const TemporaryFolder folder;
  std::size_t dimensions[] = {1, 2};
  test::MatVariable cell(Mat_VarCreate("QSMs", MAT_C_CELL, MAT_T_CELL, 2, dimensions, nullptr, 0),
                         Mat_VarFree);
  for (int i = 0; i < 2; ++i) {
    Mat_VarSetCell(cell.get(), i,
                   test::mat_model("", test::mat_cylinder_fields(random_table(10 + i, 3))).release());
  }
  std::vector<test::MatVariable> variables;
  variables.push_back(std::move(cell));
  test::save_mat(folder / "tree.mat", std::move(variables));
  const ImportedSkeleton imported = read_skeleton(folder / "tree.mat");
  EXPECT_EQ(imported.skeleton.branch_count(), 10);
  EXPECT_EQ(count_of(imported, "first_of_several"), 1u);
}

// How a scan program of another language counts: PyTLidar's tables are TreeQSM's with parents from 0.
TEST(ReadTreeQsmText, RecognisesParentsCountedFromZero) {
  const CylinderTable table = random_table(60, 4);
  const Skeleton expected = read_text(to_text(table)).skeleton;
  CylinderTable from_zero = table, root_names_itself = table, from_one = table;
  for (std::size_t k = 0; k < table.size(); ++k) {
    from_zero.parent[k] = table.parent[k] - 1;
    root_names_itself.parent[k] = std::max(table.parent[k] - 1, 0.0);
    from_one.parent[k] = table.parent[k] == 0 ? -1 : table.parent[k];
  }
  const auto expect_read_so = [&](const CylinderTable& other, const char* words) {
    const ImportedSkeleton imported = read_text(to_text(other));
    expect_same(imported.skeleton, expected, 0);
    EXPECT_NE(test::message_of(imported, "parents_counted_otherwise").find(words), std::string::npos);
  };
  expect_read_so(from_zero, "from 0, and -1 is none");
  expect_read_so(root_names_itself, "from 0, and the first names itself");
  expect_read_so(from_one, "from 1, and -1 is none");
}

TEST(ReadTreeQsmText, NeverCountsARealScanFromZero) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    EXPECT_TRUE(read_text(to_text(random_table(40, seed))).repairs.empty());
  }
}

TEST(ReadTreeQsmMat, KnowsTheNamesPeopleGiveTheirModels) {
  const TemporaryFolder folder;
  for (const char* name : {"QSM", "OptQSM", "QSMs", "qsm", "tree_7"}) {
    std::vector<test::MatVariable> variables;
    variables.push_back(test::mat_model(name, test::mat_cylinder_fields(small_table())));
    test::save_mat(folder / "tree.mat", std::move(variables));
    EXPECT_EQ(read_skeleton(folder / "tree.mat").skeleton.branch_count(), 3) << name;
  }
}

// ---- real files
// ------------------------------------------------------------------------------------------------

// A numeric array of a file as libmatio reads it.
std::vector<double> by_libmatio(const matvar_t& array) {
  const std::size_t count = array.nbytes / static_cast<std::size_t>(array.data_size);
  std::vector<double> values(count);
  for (std::size_t i = 0; i < count; ++i) {
    switch (array.data_type) {
      case MAT_T_DOUBLE:
        values[i] = static_cast<const double*>(array.data)[i];
        break;
      case MAT_T_SINGLE:
        values[i] = static_cast<const float*>(array.data)[i];
        break;
      case MAT_T_UINT8:
        values[i] = static_cast<const std::uint8_t*>(array.data)[i];
        break;
      case MAT_T_UINT16:
        values[i] = static_cast<const std::uint16_t*>(array.data)[i];
        break;
      default:
        throw std::runtime_error("the test does not know this type");
    }
  }
  return values;
}

struct RealFile {
  CylinderTable table;
  double total_volume = 0;  // litres, as the file itself says
  double tree_height = 0;   // m
};

RealFile read_by_libmatio(const std::filesystem::path& path) {
  RealFile file;
  const std::unique_ptr<mat_t, decltype(&Mat_Close)> mat(Mat_Open(path.c_str(), MAT_ACC_RDONLY), Mat_Close);
  std::vector<test::MatVariable> keep;
  const matvar_t* model = nullptr;
  while (matvar_t* variable = Mat_VarReadNext(mat.get())) {
    keep.emplace_back(variable, Mat_VarFree);
    if (variable->class_type == MAT_C_STRUCT && Mat_VarGetStructFieldByName(variable, "cylinder", 0))
      model = variable;
  }
  const auto variable = [&](const char* name) {
    for (const test::MatVariable& v : keep) {
      if (std::string(v->name) == name) return by_libmatio(*v);
    }
    throw std::runtime_error(std::string("no variable ") + name);
  };
  const auto field = [&](const char* of, const char* name) {
    return by_libmatio(*Mat_VarGetStructFieldByName(
        Mat_VarGetStructFieldByName(const_cast<matvar_t*>(model), of, 0), name, 0));
  };
  const std::vector<double> start = model ? field("cylinder", "start") : variable("Sta");
  const std::vector<double> axis = model ? field("cylinder", "axis") : variable("Axe");
  file.table.radius = model ? field("cylinder", "radius") : variable("Rad");
  file.table.length = model ? field("cylinder", "length") : variable("Len");
  file.table.parent = model ? field("cylinder", "parent") : variable("CPar");
  const std::size_t n = file.table.size();
  for (std::size_t k = 0; k < n; ++k) {
    file.table.start.emplace_back(start[k], start[n + k], start[2 * n + k]);
    file.table.axis.emplace_back(axis[k], axis[n + k], axis[2 * n + k]);
  }
  if (model) {
    file.total_volume = field("treedata", "TotalVolume").at(0);
    file.tree_height = field("treedata", "TreeHeight").at(0);
  }
  return file;
}

TEST(ReadTreeQsmMat, AgreesWithLibmatioOnRealFiles) {
  for (const char* name :
       {"itsme_tree_treeqsm_v200.mat", "itsme_tree_treeqsm_v230.mat", "itsme_tree_treeqsm_v240.mat",
        "itsme_tree2_treeqsm_v240_two_roots.mat", "rtwig_sapling_treeqsm_v240.mat"}) {
    TREMULA_NEED_DATA(std::string("qsm/") + name);
    const std::filesystem::path path = data_folder() / "qsm" / name;
    const CylinderTable table = read_by_libmatio(path).table;
    const ImportedSkeleton imported = read_skeleton(path.string());
    const Skeleton& skeleton = imported.skeleton;
    ASSERT_EQ(skeleton.branch_count(), static_cast<int>(table.size())) << name;
    ASSERT_EQ(count_of(imported, "reordered"), 0u) << name;  // so that cylinder k is branch k
    for (std::size_t k = 0; k < table.size(); ++k) {
      const Branch& branch = skeleton.branches[k];
      EXPECT_EQ(branch.start_radius, table.radius[k]);
      EXPECT_EQ(branch.end_radius, table.radius[k]);
      EXPECT_NEAR(branch.length(), table.length[k], 1e-6 * table.length[k]);
      EXPECT_LE((branch.start + skeleton.origin - table.start[k]).norm(), 1e-9);
      EXPECT_LE((branch.end - branch.start - table.length[k] * table.axis[k]).norm(), 1e-6 * table.length[k]);
    }
  }
}

TEST(ReadTreeQsmMat, GivesTheMetricsThatTheFilesStateThemselves) {
  TREMULA_NEED_DATA("validation.json");
  const nlohmann::json item = test::validation_item("tree.itsme.treedata");
  for (const auto& [name, expected] : item.at("values").items()) {
    TREMULA_NEED_DATA(name);
    const ImportedSkeleton imported = read_skeleton((data_folder() / name).string());
    const RealFile file = read_by_libmatio(data_folder() / name);
    EXPECT_EQ(imported.skeleton.branch_count(), expected.at("cylinders"));
    EXPECT_NEAR(1000 * volume(imported.skeleton), file.total_volume, 1e-6 * file.total_volume);
    EXPECT_NEAR(1000 * volume(imported.skeleton), expected.at("volume_l"), 0.5e-3);  // as printed
    EXPECT_NEAR(height(imported.skeleton), file.tree_height, 1e-6 * file.tree_height);
    EXPECT_NEAR(height(imported.skeleton), expected.at("height_m"), 0.5e-4);
    // One tree, one root: a second cylinder without parent is joined, and said.
    const std::size_t roots = expected.value("roots", 1u);
    EXPECT_EQ(imported.skeleton.root_count(), 1);
    EXPECT_EQ(count_of(imported, "joined_to_nearest"), roots - 1);
    for (std::size_t k = 1; k < file.table.size(); ++k) {
      if (file.table.parent[k] != 0) continue;
      EXPECT_GE(imported.skeleton.branches[k].start_node, 1) << "joined to the ground";
    }
  }
}

TEST(ReadSkeleton, GivesOneTreeFromTwoFormats) {
  TREMULA_NEED_DATA("validation.json");
  const nlohmann::json item = test::validation_item("tree.rtwig.same_tree_two_formats");
  std::vector<double> heights;
  for (std::size_t i = 0; i < item.at("files").size(); ++i) {
    const std::string name = item.at("files")[i];
    TREMULA_NEED_DATA(name);
    const Skeleton skeleton = read_skeleton((data_folder() / name).string()).skeleton;
    heights.push_back(height(skeleton));
    EXPECT_NEAR(heights.back(), item.at("height_m")[i], 0.5e-3) << name;
    if (!item.at("volume_l")[i].is_null()) {
      EXPECT_NEAR(1000 * volume(skeleton), item.at("volume_l")[i], 0.5e-2) << name;
    }
  }
  EXPECT_NEAR(heights.at(0), heights.at(1), 0.01 * heights.at(0));
}

}  // namespace
}  // namespace tremula
