// Every reader and every writer of the io folder, at work on something small.
#pragma once

#include <cstddef>
#include <ostream>
#include <string>
#include <vector>

namespace tremula::test {

struct ReadTask {
  std::string name;
  std::string (*bytes)();
  std::size_t (*read)(const std::string& path);  // gives some number of what was read
};
inline std::ostream& operator<<(std::ostream& out, const ReadTask& task) { return out << task.name; }

struct WriteTask {
  std::string name;
  void (*write)(const std::string& path);
  // The destructor of nlohmann's JSON takes memory itself, and std::terminate is called where there is none.
  // The program ends with its line before that (cli/main.cpp).
  bool builds_json = false;
};
inline std::ostream& operator<<(std::ostream& out, const WriteTask& task) { return out << task.name; }

const std::vector<ReadTask>& read_tasks();
const std::vector<WriteTask>& write_tasks();

}  // namespace tremula::test
