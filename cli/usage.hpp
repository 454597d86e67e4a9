// What may be wrong with a command line, said in one line that names the flag.
#pragma once

#include <span>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace tremula::cli {

// The group of flags that shape the bones of a .glb.
inline constexpr const char* bones_group = "Bones";

// For every option of the command, once all are there: its number is a number and within the bounds of the
// table in usage.cpp, its text is not empty, and a flag that may be repeated takes one value each time.
void check_values(CLI::App& command);

// What the parser found, in our words.
std::string explain(const CLI::App& app, const CLI::ParseError& error);

// Flags that would have no effect beside others are refused: nobody gives one to be ignored.
struct IdleFlags {
  bool idle;
  std::string beside;  // "given with --wind gusts.bts"
  std::string wanted;  // "--wind turbulent"
  std::vector<std::string> flags;
};
void refuse_idle_flags(const CLI::App& command, std::span<const IdleFlags> rules);

}  // namespace tremula::cli
