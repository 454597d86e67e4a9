// The keys that every plate in a TOML file has.
#pragma once

#include "tremula/io/toml_reading.hpp"
#include "tremula/structure/sheet.hpp"

namespace tremula {

// width, height, thickness, youngs_modulus, density, and where they are given poisson_ratio and elements.
// `what`: the table, for messages. Fails as the functions of toml_reading.hpp do.
void read_plate(const TomlPlace& place, const toml::table& table, const char* what, Sheet& sheet);

}  // namespace tremula
