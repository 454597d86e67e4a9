// One file per subcommand: parsing and printing only. Each adds itself to the program and says what to run.
#pragma once

#include <CLI/CLI.hpp>

namespace tremula::cli {

void add_grow(CLI::App& app);
void add_modes(CLI::App& app);
void add_animate(CLI::App& app);
void add_load(CLI::App& app);
void add_wind(CLI::App& app);
void add_info(CLI::App& app);
void add_render(CLI::App& app);
void add_check(CLI::App& app);
void add_beam(CLI::App& app);

}  // namespace tremula::cli
