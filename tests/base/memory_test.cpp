#include "tremula/base/memory.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace tremula {
namespace {

TEST(AvailableMemory, IsSomeAndNotMoreThanTheMachineHas) {
  const auto pages = static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES));
  EXPECT_GT(available_memory(), std::uint64_t{1} << 20);
  EXPECT_LT(available_memory(), pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE)));
}

TEST(AvailableMemory, EndsWhereTheAddressSpaceDoes) {
  const pid_t child = fork();
  if (child == 0) {
    std::uint64_t taken = 0;
    std::ifstream("/proc/self/statm") >> taken;
    taken *= static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
    constexpr std::uint64_t more = 100'000'000;
    const rlimit limit{taken + more, taken + more};
    setrlimit(RLIMIT_AS, &limit);
    const std::uint64_t left = available_memory();
    _exit(left <= more && left > more / 2 ? 42 : 1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), 42);
}

}  // namespace
}  // namespace tremula
