#include "tremula/modes/solve_modes.hpp"

#include "tremula/base/error.hpp"

#include <fstream>

#include "support.hpp"
#include "trees.hpp"
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace tremula {
namespace {

nlohmann::json reference() {
  return nlohmann::json::parse(std::ifstream(test::data_folder() / "modes/random_tree_62_frequencies.json"));
}

TEST(SolveModes, AgreesWithTheLongDoubleReferenceForEveryMaterialAndSection) {
  TREMULA_NEED_DATA("modes/random_tree_62_frequencies.json");
  const Skeleton skeleton = test::cylinders_from_text(test::data_folder() / "modes/random_tree_62.txt");
  ASSERT_EQ(skeleton.branch_count(), 62);
  const nlohmann::json sets = reference().at("sets");
  ASSERT_EQ(sets.size(), 6U);
  for (const auto& set : sets) {
    StructureOptions options;
    options.material = {"reference", set["youngs_modulus"], set["shear_modulus"], set["density"], ""};
    options.section = set["section_factor"] == 4.0 ? Section::paper : Section::exact;
    options.rotatory_inertia = set["rotatory_inertia"];
    const Structure structure = assemble(skeleton, options);
    for (const ModeMethod method : {ModeMethod::dense, ModeMethod::iterative}) {
      const Modes modes = solve_modes(structure, {.count = 40, .method = method});
      for (int r = 0; r < 40; ++r) {
        const double wanted = set["frequency_hz"][static_cast<std::size_t>(r)];
        EXPECT_NEAR(modes.frequency[r] / wanted, 1, 2e-12)
            << "mode " << r << " of set " << set["section_factor"];
      }
    }
  }
}

}  // namespace
}  // namespace tremula
