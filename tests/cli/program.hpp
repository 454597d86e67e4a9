// Runs the command line program as a user would.
#pragma once

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <string>

#include "support.hpp"

namespace tremula::test {

struct Outcome {
  int code;
  std::string output, messages;  // stdout, stderr
};

inline std::string contents(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

// `first`: what the shell does before, such as "ulimit -v 100000; ".
inline Outcome run(const TemporaryFolder& folder, const std::string& arguments,
                   const std::string& first = "") {
  const std::string command = "cd '" + folder.path.string() + "' && " + first + "'" TREMULA_PROGRAM "' " +
                              arguments + " > stdout.txt 2> stderr.txt < /dev/null";
  const int status = std::system(command.c_str());
  const Outcome outcome{WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status),
                        contents(folder / "stdout.txt"), contents(folder / "stderr.txt")};
  std::filesystem::remove(folder / "stdout.txt");
  std::filesystem::remove(folder / "stderr.txt");
  return outcome;
}

// What the program says that refuses with code 2 and one line.
inline std::string refusal(const TemporaryFolder& folder, const std::string& arguments) {
  const Outcome outcome = run(folder, arguments);
  EXPECT_EQ(outcome.code, 2) << arguments;
  EXPECT_EQ(std::ranges::count(outcome.messages, '\n'), 1) << outcome.messages;
  return outcome.messages;
}

inline void write(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

inline std::size_t file_count(const TemporaryFolder& folder) {
  std::size_t count = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder.path)) ++count;
  return count;
}

}  // namespace tremula::test
