#include "tremula/base/memory.hpp"

#include <algorithm>
#include <fstream>
#include <limits>
#include <optional>
#include <string>

#include <sys/resource.h>
#include <unistd.h>

namespace tremula {
namespace {

constexpr std::uint64_t unlimited = std::numeric_limits<std::uint64_t>::max();

std::uint64_t difference(std::uint64_t most, std::uint64_t taken) { return most > taken ? most - taken : 0; }

// The number after a word, as in /proc/meminfo and memory.stat.
std::optional<std::uint64_t> number_after(const std::string& path, const std::string& word) {
  std::ifstream file(path);
  for (std::string read; file >> read;) {
    std::uint64_t number = 0;
    if (read == word && file >> number) return number;
  }
  return {};
}

// The file's only number; none where it says "max".
std::optional<std::uint64_t> number_in(const std::string& path) {
  std::ifstream file(path);
  std::uint64_t number = 0;
  if (file >> number) return number;
  return {};
}

struct GroupFiles {
  const char *limit, *usage, *inactive, *active;
};

// Pages of files that the group has read count as used, but go when they are needed.
std::uint64_t left_in(const std::string& folder, const GroupFiles& files) {
  const auto limit = number_in(folder + files.limit), usage = number_in(folder + files.usage);
  if (!limit || !usage) return unlimited;
  const std::string statistics = folder + "/memory.stat";
  const std::uint64_t cached = number_after(statistics, files.inactive).value_or(0) +
                               number_after(statistics, files.active).value_or(0);
  return difference(*limit, difference(*usage, cached));
}

// Of the group and all those above it. A container may not see the path of its own: then only the top.
std::uint64_t left_in_groups(const std::string& root, std::string path, const GroupFiles& files) {
  std::uint64_t least = left_in(root, files);
  for (; path.size() > 1; path.resize(path.rfind('/'))) least = std::min(least, left_in(root + path, files));
  return least;
}

std::uint64_t left_in_control_groups() {
  constexpr GroupFiles unified{"/memory.max", "/memory.current", "inactive_file", "active_file"},
      split{"/memory.limit_in_bytes", "/memory.usage_in_bytes", "total_inactive_file", "total_active_file"};
  std::uint64_t least = unlimited;
  std::ifstream groups("/proc/self/cgroup");  // lines of NUMBER:CONTROLLERS:PATH
  for (std::string line; std::getline(groups, line);) {
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1),
                      path = line.substr(second + 1);
    if (controllers.empty()) least = std::min(least, left_in_groups("/sys/fs/cgroup", path, unified));
    if (controllers == "memory") {
      least = std::min(least, left_in_groups("/sys/fs/cgroup/memory", path, split));
    }
  }
  return least;
}

std::uint64_t left_of_address_space() {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return unlimited;
  const auto pages = number_in("/proc/self/statm").value_or(0);
  return difference(limit.rlim_cur, pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE)));
}

}  // namespace

std::uint64_t available_memory() {
  const auto kilobytes = number_after("/proc/meminfo", "MemAvailable:");
  const std::uint64_t of_machine = kilobytes ? *kilobytes * 1024 : unlimited;
  return std::min({of_machine, left_in_control_groups(), left_of_address_space()});
}

}  // namespace tremula
