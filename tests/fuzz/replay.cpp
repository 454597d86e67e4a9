// fuzz_replay HARNESS FILE...         tries files one by one: what a finding is looked into with, on any
// compiler fuzz_replay HARNESS --seeds FOLDER   writes the seeds of a harness, and its dictionary beside as
// FOLDER.dict fuzz_replay --list                   the names of all harnesses
#include "tremula/io/atomic_file.hpp"

#include <cstdio>
#include <exception>
#include <filesystem>
#include <iostream>

#include "harness.hpp"
#include "mutate.hpp"

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

int try_mutants(const Harness& harness, std::uint64_t count, std::uint64_t first) {
  const std::vector<std::string> seeds = harness.seeds();
  int findings = 0;
  for (std::uint64_t number = first; number < first + count; ++number) {
    const std::string bytes = mutant(seeds, harness.words, number);
    try {
      harness.try_input(bytes);
    } catch (const std::exception& error) {
      const std::string file = harness.name + "-mutant-" + std::to_string(number);
      write_file_atomically(file, bytes);
      std::cout << file << ": " << error.what() << '\n';
      ++findings;
    }
  }
  return findings;
}

// The number of findings.
int run(const std::vector<std::string>& arguments) {
  if (arguments.size() == 1 && arguments[0] == "--list") {
    for (const Harness& harness : harnesses()) std::cout << harness.name << '\n';
    return 0;
  }
  if (arguments.size() < 2)
    throw Broken("wanted HARNESS FILE..., HARNESS --seeds FOLDER, HARNESS --mutants COUNT or --list");
  const Harness& harness = harness_named(arguments[0]);
  if (arguments[1] == "--mutants" && arguments.size() > 2)
    return try_mutants(harness, std::stoull(arguments[2]),
                       arguments.size() > 3 ? std::stoull(arguments[3]) : 0);
  if (arguments.size() == 3 && arguments[1] == "--seeds") {
    write_seeds(harness, arguments[2]);
    return 0;
  }
  for (std::size_t i = 1; i < arguments.size(); ++i) {
    harness.try_input(read_file(arguments[i]));
    std::cout << arguments[i] << ": nothing found\n";
  }
  return 0;
}

}  // namespace
}  // namespace tremula::fuzz

int main(int argc, char** argv) {
  try {
    return tremula::fuzz::run({argv + 1, argv + argc}) == 0 ? 0 : 1;
  } catch (const std::exception& error) {
    std::cerr << "fuzz_replay: " << error.what() << '\n';
    return 1;
  }
}
