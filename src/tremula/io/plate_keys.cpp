#include "tremula/io/plate_keys.hpp"

#include <array>
#include <cstdint>

namespace tremula {
namespace {

std::array<int, 2> elements_of(const TomlPlace& place, const toml::node& node) {
  const char* wanted = "two whole numbers from 1 to 1000";
  const toml::array& entries = list(place, node, "elements", wanted);
  if (entries.size() != 2)
    place.fail(node, "elements", "a list of " + std::to_string(entries.size()), wanted);
  std::array<int, 2> elements{};
  for (std::size_t i = 0; i < 2; ++i) {
    const auto value = entries[i].value_exact<std::int64_t>();
    if (!value || *value < 1 || *value > 1000)
      place.fail(entries[i], "elements", kind_of(entries[i]), wanted);
    elements[i] = static_cast<int>(*value);
  }
  return elements;
}

}  // namespace

void read_plate(const TomlPlace& place, const toml::table& table, const char* what, Sheet& sheet) {
  const auto above_zero = [&](const char* key, double least, const char* wanted) {
    return number(place, needed(place, table, key, what), key, least, wanted);
  };
  sheet.width = above_zero("width", 1e-9, "a number above 0 [m]");
  sheet.height = above_zero("height", 1e-9, "a number above 0 [m]");
  sheet.thickness = above_zero("thickness", 1e-9, "a number above 0 [m]");
  sheet.youngs_modulus = above_zero("youngs_modulus", 1e-15, "a number above 0 [Pa]");
  sheet.density = above_zero("density", 1e-15, "a number above 0 [kg/m^3]");
  if (const toml::node* node = table.get("poisson_ratio"))
    sheet.poisson_ratio = number(place, *node, "poisson_ratio", -1, "a number above -1 and up to 0.5");
  if (const toml::node* node = table.get("elements")) sheet.elements = elements_of(place, *node);
}

}  // namespace tremula
