// What people's files give from the command line: the frequency of the tree in them, or the message.
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "cli/program.hpp"

namespace tremula {
namespace {

using test::Outcome;
using test::run;
using test::TemporaryFolder;

void write(const TemporaryFolder& folder, const std::string& name, const std::string& text) {
  std::ofstream(folder / name, std::ios::binary) << text;
}

double first_frequency(const Outcome& outcome) {
  if (outcome.code != 0) return std::nan("");
  return nlohmann::json::parse(outcome.output).at("modes").at(0).at("frequency_hz").get<double>();
}

struct Case {
  const char* file;
  const char* flags;
  double frequency;     // of the first mode [Hz], to four figures; 0: the file is refused
  const char* message;  // what stderr says
};

// The tree of reference__tree15.txt has 3.1406 Hz; as SWC, whose pieces taper from the trunk's
// radius, 3.0271. A stem of the two has 3.613 Hz as cylinders, 3.625 as SWC.
const std::vector<Case> cases = {
    {"reference__tree15.txt", "", 3.1406, ""},
    {"header_order_ignored__extension_before_parent.csv", "", 3.1406, ""},
    {"rtwig_write_csv__write_csv_rownames_off.csv", "", 3.1406, ""},
    {"units_not_checked__tree_in_mm_treeqsm.txt", "--unit mm", 3.1406, ""},
    {"units_not_checked__tree_in_mm_treeqsm.txt", "", 3.1406e-3, "In mm it would be 6 m: --unit mm"},
    {"swc_dialects__eswc_12_columns.swc", "", 3.0271, ""},
    {"swc_dialects__header_without_hash.swc", "", 3.0271, ""},
    {"swc_dialects__inline_comment.swc", "", 3.0271, ""},
    {"swc_dialects__parent_zero_root.swc", "", 3.0271, ""},
    {"swc_dialects__millimetres.swc", "--unit mm", 3.0271, ""},
    {"swc_dialects__millimetres.swc", "", 3.0271e-3, "In mm it would be 6 m: --unit mm"},
    {"two_stems__one_stem.swc", "", 3.6249, ""},
    {"two_stems__two_stems.swc", "", 3.6249, "2 stems stand on the ground"},
    {"two_stems__one_stem_treeqsm.txt", "", 3.6134, ""},
    {"two_stems__two_stems_treeqsm.txt", "", 3.6134, "2 stems stand on the ground"},
    {"two_stems__two_stems_simpleforest.csv", "", 3.6134, "2 stems stand on the ground"},
    {"hundred_million_metres__two.swc", "", 0, "the whole plant measures 1e+08 m, wanted at most 1e+06 m"},
    {"parents_off_by_one__limb_cylinders_name_far_parents.txt", "", 0,
     ":9: starts 3.13892 m from its parent, line 1, wanted a start on its parent"},
    {"parents_off_by_one__limb_cylinders_name_far_parents.txt", "--allow-gaps", 3.2,
     "start far from their parents and are carried by rigid arms, at 3.14 m (line 9)"},
    {"filtered_qsm__row_removed_treeqsm.txt", "", 0,
     ":7: parent is 7, the cylinder itself (were rows taken out?"},
};

TEST(Reading, GivesEachCaseItsFrequencyOrItsMessage) {
  TREMULA_NEED_DATA("cases");
  const TemporaryFolder folder;
  for (const Case& c : cases) {
    const std::string path = std::filesystem::absolute(test::data_folder() / "cases" / c.file).string();
    const Outcome outcome =
        run(folder, "modes '" + path + "' --count 1 --gravity 0 --format json " + std::string(c.flags));
    EXPECT_EQ(outcome.code, c.frequency == 0 ? 2 : 0) << c.file << ": " << outcome.messages;
    if (c.frequency > 0) {
      EXPECT_NEAR(first_frequency(outcome), c.frequency, 1e-4 * c.frequency) << c.file;
    }
    EXPECT_NE(outcome.messages.find(c.message), std::string::npos) << c.file << ": " << outcome.messages;
    if (std::string(c.message).empty()) {
      EXPECT_EQ(outcome.messages, "") << c.file;
    }
  }
}

const std::string in_metres = "1 1 0 0 0 0.1 -1\n2 3 0 0 3 0.05 1\n3 3 1 0 4 0.02 2\n";
const std::string in_millimetres = "1 1 0 0 0 100 -1\n2 3 0 0 3000 50 1\n3 3 1000 0 4000 20 2\n";

TEST(Reading, UnitIsTakenByEveryCommandThatReadsATree) {
  const TemporaryFolder folder;
  write(folder, "m.swc", in_metres);
  write(folder, "mm.swc", in_millimetres);
  const double expected = first_frequency(run(folder, "modes m.swc --count 1 --format json"));
  const Outcome modes = run(folder, "modes mm.swc --unit mm --count 1 --format json");
  EXPECT_NEAR(first_frequency(modes), expected, 1e-12 * expected);
  EXPECT_EQ(modes.messages, "");
  const Outcome info = run(folder, "info mm.swc --unit mm --format json");
  EXPECT_EQ(nlohmann::json::parse(info.output).at("height_m"), 4);
  const Outcome grow = run(folder, "grow mm.swc --unit mm -o grown.swc");
  EXPECT_EQ(grow.code, 0) << grow.messages;
  EXPECT_EQ(first_frequency(run(folder, "modes grown.swc --count 1 --format json")), first_frequency(modes));
  const Outcome animate = run(folder, "animate mm.swc --unit mm -o mm.csv --period 2 --fps 10");
  EXPECT_EQ(animate.code, 0) << animate.messages;
  EXPECT_EQ(run(folder, "animate m.swc -o m.csv --period 2 --fps 10").code, 0);
  EXPECT_EQ(test::contents(folder / "mm.csv"), test::contents(folder / "m.csv"));
}

TEST(Reading, FlagsOfTreeFilesAreRefusedWithWhatIsNone) {
  const TemporaryFolder folder;
  for (const std::string command :
       {"modes sapling", "info sapling", "grow sapling -o x.swc", "animate sapling -o x.csv"}) {
    const Outcome unit = run(folder, command + " --unit mm");
    EXPECT_EQ(unit.code, 2);
    EXPECT_EQ(unit.messages, "tremula: error: --unit mm: given with sapling, wanted a tree file\n");
    EXPECT_EQ(run(folder, command + " --allow-gaps").code, 2);
  }
}

TEST(Reading, WarnsOfAModulusInGigapascals) {
  const TemporaryFolder folder;
  write(folder, "m.swc", in_metres);
  for (const auto& [flags, code] : {std::pair{"--gravity 0", 0}, std::pair{"", 2}}) {
    const Outcome outcome = run(folder, "modes m.swc --count 1 --youngs-modulus 9.5 " + std::string(flags));
    EXPECT_EQ(outcome.code, code);
    EXPECT_NE(outcome.messages.find("9.5 GPa is --youngs-modulus 9.5e+09"), std::string::npos)
        << outcome.messages;
  }
}

// In millimetres taken for metres a plant is too large to stand; what it says first is why.
TEST(Reading, APlantThatIsTooLargeToStandIsToldItsUnit) {
  const TemporaryFolder folder;
  write(folder, "mm.swc", in_millimetres);
  for (const std::string command : {"modes mm.swc --count 1", "animate mm.swc -o a.csv --period 2"}) {
    const Outcome outcome = run(folder, command);
    EXPECT_EQ(outcome.code, 2) << command;
    EXPECT_LT(outcome.messages.find("--unit mm"), outcome.messages.find("buckles")) << outcome.messages;
  }
}

TEST(Reading, AGrownPlantComesBackFromItsFileAsItWas) {
  const TemporaryFolder folder;
  for (const std::string preset : {"sapling", "willow"}) {
    ASSERT_EQ(run(folder, "grow " + preset + " -o plant.swc").code, 0);
    nlohmann::json from_preset =
        nlohmann::json::parse(run(folder, "info " + preset + " --format json").output);
    nlohmann::json from_file = nlohmann::json::parse(run(folder, "info plant.swc --format json").output);
    for (const char* differs : {"name", "format"}) {
      from_preset.erase(differs);
      from_file.erase(differs);
    }
    EXPECT_EQ(from_preset, from_file) << preset;
  }
}

}  // namespace
}  // namespace tremula
