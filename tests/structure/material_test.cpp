#include "tremula/structure/material.hpp"

#include "tremula/base/error.hpp"

#include <fstream>
#include <limits>
#include <map>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "complaint.hpp"
#include "support.hpp"

namespace tremula {
namespace {

TEST(MaterialPresets, AgreeWithTheForestGalesTable) {
  TREMULA_NEED_DATA("species/forestgales_species_parameters.tsv");
  std::ifstream file(test::data_folder() / "species/forestgales_species_parameters.tsv");
  const std::map<std::string, std::string> rows = {
      {"BI", "birch"},        {"BE", "beech"},          {"OK", "oak"},
      {"SP", "scots-pine"},   {"LP", "lodgepole-pine"}, {"NS", "norway-spruce"},
      {"SS", "sitka-spruce"}, {"DF", "douglas-fir"},    {"EL", "european-larch"}};
  std::size_t compared = 0;
  for (std::string line; std::getline(file, line);) {
    std::istringstream text(line);
    std::vector<std::string> columns;
    for (std::string column; std::getline(text, column, '\t');) columns.push_back(column);
    const auto row = rows.find(columns[0]);
    if (row == rows.end()) continue;
    const Material& material = find_material(row->second);
    EXPECT_DOUBLE_EQ(material.density, std::stod(columns[12])) << line;
    EXPECT_DOUBLE_EQ(material.youngs_modulus, std::stod(columns[15])) << line;
    ++compared;
  }
  EXPECT_EQ(compared, rows.size());
}

TEST(MaterialPresets, TheDefaultIsTheMeanOfThreeBroadleaves) {
  const auto mean = [](double Material::*field) {
    return (find_material("birch").*field + find_material("beech").*field + find_material("oak").*field) / 3;
  };
  const Material& green = find_material("green-wood");
  EXPECT_DOUBLE_EQ(green.youngs_modulus, mean(&Material::youngs_modulus));
  EXPECT_DOUBLE_EQ(green.shear_modulus, mean(&Material::shear_modulus));
  EXPECT_DOUBLE_EQ(green.density, mean(&Material::density));
}

TEST(FindMaterial, ListsTheNamesForAnUnknownOne) {
  EXPECT_THAT(test::complaint_of([] { find_material("balsa"); }),
              testing::AllOf(testing::HasSubstr("'balsa'"), testing::HasSubstr("walnut, paper")));
}

TEST(CheckMaterial, RefusesWhatIsNotAboveZeroOrFarBeyondAnythingThereIs) {
  for (const double bad : {0.0, -1e9, 1e-25, 1e300, std::numeric_limits<double>::quiet_NaN(),
                           std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW(check_material({"m", bad, 1, 1, ""}), InputError);
    EXPECT_THROW(check_material({"m", 1, bad, 1, ""}), InputError);
    EXPECT_THROW(check_material({"m", 1, 1, bad, ""}), InputError);
  }
}

}  // namespace
}  // namespace tremula
