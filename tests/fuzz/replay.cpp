// fuzz_replay HARNESS FILE...         tries files one by one: what a finding is looked into with, on any
// compiler fuzz_replay HARNESS --seeds FOLDER   writes the seeds of a harness, and its dictionary beside as
// FOLDER.dict fuzz_replay --list                   the names of all harnesses
#include "tremula/io/atomic_file.hpp"

#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>

#include "harness.hpp"

namespace tremula::fuzz {
namespace {

// libFuzzer's form: "word" with \xAB for what is not printable.
std::string dictionary_line(const std::string& word) {
  std::string line = "\"";
  for (const char c : word) {
    const auto code = static_cast<unsigned char>(c);
    char text[8];
    std::snprintf(text, sizeof text, code < 0x20 || code >= 0x7F || c == '"' || c == '\\' ? "\\x%02X" : "%c",
                  code);
    line += text;
  }
  return line + "\"\n";
}

void write_seeds(const Harness& harness, const std::string& folder) {
  std::filesystem::create_directories(folder);
  int number = 0;
  for (const std::string& seed : harness.seeds())
    write_file_atomically(folder + "/seed_" + std::to_string(number++), seed);
  std::string dictionary;
  for (const std::string& word : harness.words) dictionary += dictionary_line(word);
  write_file_atomically(folder + ".dict", dictionary);
}

void run(const std::vector<std::string>& arguments) {
  if (arguments.size() == 1 && arguments[0] == "--list") {
    for (const Harness& harness : harnesses()) std::cout << harness.name << '\n';
    return;
  }
  if (arguments.size() < 2) throw Broken("wanted HARNESS FILE..., HARNESS --seeds FOLDER or --list");
  const Harness& harness = harness_named(arguments[0]);
  if (arguments.size() == 3 && arguments[1] == "--seeds") return write_seeds(harness, arguments[2]);
  for (std::size_t i = 1; i < arguments.size(); ++i) {
    harness.try_input(read_file(arguments[i]));
    std::cout << arguments[i] << ": nothing found\n";
  }
}

}  // namespace
}  // namespace tremula::fuzz

int main(int argc, char** argv) {
  try {
    tremula::fuzz::run({argv + 1, argv + argc});
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "fuzz_replay: " << error.what() << '\n';
    return 1;
  }
}
