#include "tremula/structure/plausibility.hpp"

#include <gtest/gtest.h>

#include "trees.hpp"
#include "tremula/geometry/grow.hpp"
#include "tremula/geometry/lsystem.hpp"
#include "tremula/geometry/plants.hpp"

namespace tremula {
namespace {

// 6 m high, 0.1 m in radius.
Skeleton stem(double scale = 1) { return test::straight_stem(6, 6 * scale, 0.1 * scale, 0.04 * scale); }

bool says(const std::vector<std::string>& lines, const std::string& words) {
  for (const std::string& line : lines) {
    if (line.find(words) != std::string::npos) return true;
  }
  return false;
}

TEST(Plausibility, IsSilentAboutEveryPresetInEveryWood) {
  for (const PlantPreset& preset : plant_presets()) {
    const Skeleton plant =
        grow(parse_lsystem(std::string(preset.text), std::string(preset.name)), {}).skeleton;
    for (const Material& material : material_presets()) {
      StructureOptions options;
      options.material = material;
      EXPECT_TRUE(plausibility(plant, options, 1.0).empty()) << preset.name << ", " << material.name;
    }
  }
}

TEST(Plausibility, IsSilentFromASeedlingToTheTallestTree) {
  EXPECT_TRUE(plausibility(test::straight_stem(2, 0.03, 0.0005, 0.0003), {}, 40.0).empty());
  EXPECT_TRUE(plausibility(test::straight_stem(10, 116, 2.5, 0.1), {}, 0.1).empty());
  EXPECT_TRUE(plausibility(test::straight_stem(10, 1, 0.0015, 0.001), {}, 2.0).empty());  // a stalk
}

TEST(Plausibility, NamesTheUnitThatMakesATreeOfIt) {
  EXPECT_TRUE(says(plausibility(stem(1000), {}), "In mm it would be 6 m: --unit mm"));
  EXPECT_TRUE(says(plausibility(stem(100), {}), "In cm it would be 6 m: --unit cm"));
  EXPECT_TRUE(
      says(plausibility(test::straight_stem(9, 150, 2, 1), {}), "In ft it would be 45.72 m: --unit ft"));
  EXPECT_TRUE(says(plausibility(stem(1e-4), {}), "another unit than --unit says"));
  EXPECT_TRUE(says(plausibility(stem(1000), {}), "kg of wood"));
}

TEST(Plausibility, NamesRadiiInAnotherUnitThanCoordinates) {
  EXPECT_TRUE(says(plausibility(test::straight_stem(6, 6, 100, 40), {}), "times as high as it is thick"));
  EXPECT_TRUE(says(plausibility(test::straight_stem(6, 6, 1e-4, 4e-5), {}), "times as high as it is thick"));
}

TEST(Plausibility, NamesTheUnitOfAModulusAndOfADensity) {
  const auto with = [](double youngs_modulus, double shear_modulus, double density) {
    StructureOptions options;
    options.material = {"custom", youngs_modulus, shear_modulus, density, ""};
    return plausibility(stem(), options);
  };
  EXPECT_TRUE(with(9.5e9, 7e8, 900).empty());
  EXPECT_TRUE(says(with(9.5, 7e8, 900), "9.5 GPa is --youngs-modulus 9.5e+09"));
  EXPECT_TRUE(says(with(9500, 7e8, 900), "9500 MPa is --youngs-modulus 9.5e+09"));
  EXPECT_TRUE(says(with(9.5e9, 0.7, 900), "0.7 GPa is --shear-modulus 7e+08"));
  EXPECT_TRUE(says(with(9.5e9, 7e8, 0.9), "0.9 g/cm^3 is --density 900"));
}

TEST(Plausibility, NamesAFrequencyThatNoPlantHas) {
  EXPECT_TRUE(says(plausibility(stem(), {}, 0.003), "the lowest frequency is 0.003 Hz"));
  EXPECT_TRUE(says(plausibility(stem(), {}, 1e5), "the lowest frequency is 1e+05 Hz"));
  EXPECT_TRUE(plausibility(stem(), {}, 3.1).empty());
}

TEST(Plausibility, NamesAStemThatItsFloatWouldTear) {
  Skeleton kelp = test::straight_stem(4, 5, 0.002, 0.002);
  kelp.branches.push_back(test::make_branch(4, {0, 0, 5}, {0, 0, 5.3}, 0.15, 0.15));
  kelp.branches.back().wall = 0.1;
  StructureOptions options{.material = find_material("kelp")};
  EXPECT_FALSE(says(plausibility(kelp, options), "floats"));  // in air
  options.added_mass_density = 1000;
  EXPECT_TRUE(says(plausibility(kelp, options), "what floats stretches branch 3 by 10"));
  kelp.branches.back().start_radius = kelp.branches.back().end_radius = 0.02;
  EXPECT_FALSE(says(plausibility(kelp, options), "floats"));
}

}  // namespace
}  // namespace tremula
