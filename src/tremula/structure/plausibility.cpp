#include "tremula/structure/plausibility.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace tremula {
namespace {

struct Range {
  double low, high;
  bool holds(double value) const { return value >= low && value <= high; }
};

// From a germling to the tallest tree there is (a coast redwood of 116 m).
constexpr Range height_range{0.005, 130};  // [m]
// Height over the largest diameter: a baobab has 2, forest trees 50 to 150, a stalk of wheat 300.
constexpr Range slenderness_range{1.5, 1000};
// The largest giant sequoia holds about 1500 m^3 of stem.
constexpr double most_wood = 3e6;  // [kg]
// Dry balsa to waterlogged ebony.
constexpr Range density_range{80, 1700};  // [kg/m^3]
// Blades of kelp have 1e6, tough dry wood 2.5e10 (Zhu et al. 2021; Wood Handbook): a tenth and four times
// that.
constexpr Range youngs_modulus_range{1e5, 1e11};  // [Pa]
constexpr Range shear_modulus_range{1e4, 2e10};   // [Pa]
// Tall trees sway at 0.1 Hz, bare twigs of a hand's length at 100.
constexpr Range frequency_range{0.01, 1000};  // [Hz]
// Stipes of Macrocystis break at 0.25 to 0.33, of Nereocystis at 0.4.
constexpr double torn_strain = 0.25;

template <class... Numbers>
std::string print(const char* format, Numbers... numbers) {
  char text[300];
  std::snprintf(text, sizeof text, format, numbers...);
  return text;
}

// The unit in which a number that is far too large or too small would be that of a common plant.
struct Unit {
  const char* name;
  double size;
};

template <std::size_t Count>
const Unit* likely_unit(const std::array<Unit, Count>& units, double value, double common,
                        const Range& range) {
  const Unit* best = nullptr;
  for (const Unit& unit : units) {
    if (!range.holds(value * unit.size)) continue;
    if (best == nullptr ||
        std::abs(std::log(value * unit.size / common)) < std::abs(std::log(value * best->size / common)))
      best = &unit;
  }
  return best;
}

constexpr std::array<Unit, 3> lengths = {{{"mm", 1e-3}, {"cm", 1e-2}, {"ft", 0.3048}}};
constexpr std::array<Unit, 3> pressures = {{{"GPa", 1e9}, {"MPa", 1e6}, {"kPa", 1e3}}};
constexpr std::array<Unit, 1> densities = {{{"g/cm^3", 1e3}}};

std::string about_height(double height) {
  std::string line =
      print("the plant is %.4g m high; plants have %g to %g m", height, height_range.low, height_range.high);
  if (const Unit* unit = likely_unit(lengths, height, 10, height_range)) {
    line += print(". In %s it would be %.4g m: --unit %s", unit->name, height * unit->size, unit->name);
  } else {
    line += ". Is it in another unit than --unit says?";
  }
  return line;
}

std::string about_modulus(const char* name, const char* flag, double modulus, double common,
                          const Range& range) {
  std::string line =
      print("%s is %.4g Pa; plants have %.0e to %.0e Pa", name, modulus, range.low, range.high);
  if (const Unit* unit = likely_unit(pressures, modulus, common, range)) {
    line += print(". %.4g %s is %s %.4g", modulus, unit->name, flag, modulus * unit->size);
  }
  return line;
}

std::string about_density(double density) {
  std::string line = print("the density is %.4g kg/m^3; plants have %g to %g", density, density_range.low,
                           density_range.high);
  if (const Unit* unit = likely_unit(densities, density, 900, density_range)) {
    line += print(". %.4g %s is --density %.4g", density, unit->name, density * unit->size);
  }
  return line;
}

// How far what floats pulls a branch, and which.
struct Pulled {
  int branch = -1;
  double strain = 0;
};
Pulled most_pulled(const Skeleton& skeleton, const StructureOptions& options) {
  std::vector<double> lift(skeleton.branches.size(), 0.0);  // of what is beyond the start of each [N]
  Pulled most;
  for (int k = skeleton.branch_count() - 1; k >= 0; --k) {
    const auto index = static_cast<std::size_t>(k);
    const Branch& branch = skeleton.branches[index];
    const double a = branch.start_radius, b = branch.end_radius, share = tube_share(branch.wall).area;
    const double volume = std::numbers::pi / 3 * branch.length() * (a * a + a * b + b * b);
    lift[index] += options.gravity * volume * (options.added_mass_density - options.material.density * share);
    const double thinnest = std::numbers::pi * std::min(a, b) * std::min(a, b) * share;
    const double strain = lift[index] / (options.material.youngs_modulus * thinnest);
    if (strain > most.strain) most = {k, strain};
    if (const int parent = skeleton.parent(k); parent >= 0)
      lift[static_cast<std::size_t>(parent)] += lift[index];
  }
  return most;
}

}  // namespace

std::vector<std::string> plausibility(const Skeleton& skeleton, const StructureOptions& options,
                                      std::optional<double> lowest_frequency) {
  const Extent box = extent(skeleton);
  const double height = box.high.z() - box.low.z();
  const double size = (box.high - box.low).maxCoeff();
  double thickest = 0, volume = 0;
  for (const Branch& branch : skeleton.branches) {
    const double a = branch.start_radius, b = branch.end_radius;
    thickest = std::max({thickest, a, b});
    volume += std::numbers::pi / 3 * branch.length() * (a * a + a * b + b * b) * tube_share(branch.wall).area;
  }
  const double slenderness = size / (2 * thickest);
  const double mass = volume * options.material.density;
  const Material& wood = options.material;

  std::vector<std::string> lines;
  if (!height_range.holds(size)) lines.push_back(about_height(std::max(height, size)));
  if (!slenderness_range.holds(slenderness)) {
    lines.push_back(
        print("the plant is %.4g times as high as it is thick; plants are %g to %g times. Are "
              "radii and coordinates in one unit, and radii no diameters?",
              slenderness, slenderness_range.low, slenderness_range.high));
  }
  if (mass > most_wood) {
    lines.push_back(
        print("the plant holds %.4g kg of wood; the largest trees have %.0e kg. Are its unit "
              "(--unit) and the density right?",
              mass, most_wood));
  }
  if (!density_range.holds(wood.density)) lines.push_back(about_density(wood.density));
  if (!youngs_modulus_range.holds(wood.youngs_modulus)) {
    lines.push_back(
        about_modulus("Young's modulus", "--youngs-modulus", wood.youngs_modulus, 9e9, youngs_modulus_range));
  }
  if (!shear_modulus_range.holds(wood.shear_modulus)) {
    lines.push_back(
        about_modulus("the shear modulus", "--shear-modulus", wood.shear_modulus, 7e8, shear_modulus_range));
  }
  if (options.added_mass_density > 0) {
    const Pulled most = most_pulled(skeleton, options);
    if (most.strain > torn_strain) {
      lines.push_back(
          print("what floats stretches branch %d by %.3g %%; kelp tears at 25 to 40 %%. Are floats too large "
                "or stems too thin?",
                most.branch, 100 * most.strain));
    }
  }
  if (lowest_frequency && !frequency_range.holds(*lowest_frequency)) {
    lines.push_back(
        print("the lowest frequency is %.4g Hz; plants have %g to %g Hz. Are the unit of the plant "
              "(--unit) and the material right?",
              *lowest_frequency, frequency_range.low, frequency_range.high));
  }
  return lines;
}

}  // namespace tremula
