// The program on a disk that fails: exit code 1, one line that says so, and none of its outputs.
#ifdef TREMULA_PROGRAM

#include <ostream>

#include <gtest/gtest.h>

#include "cli/program.hpp"
#include "failing_calls.hpp"

namespace tremula {
namespace {

using test::TemporaryFolder;

const std::string tree = "1 1 0 0 0 0.1 -1\n2 2 0 0 1 0.08 1\n3 2 0.5 0 2 0.05 2\n4 2 -0.5 0 2 0.05 2\n";

struct Attempt {
  test::Outcome outcome;
  bool failed;  // there was an n-th call
};

// As test::run, with the n-th writing call of the program failing.
Attempt run_with_failing_call(const TemporaryFolder& folder, const std::string& arguments, int n) {
  const TemporaryFolder notes;
  ::setenv("TREMULA_FAIL_NOTE", (notes / "failed").c_str(), 1);
  ::setenv("LD_PRELOAD", TREMULA_FAILING_CALLS, 1);
  ::setenv("TREMULA_FAIL_WRITE_CALL", std::to_string(n).c_str(), 1);
  const test::Outcome outcome = test::run(folder, arguments);
  ::unsetenv("LD_PRELOAD");
  ::unsetenv("TREMULA_FAIL_WRITE_CALL");
  return {outcome, std::filesystem::exists(notes / "failed")};
}

// Sanitizers want to be loaded before all else.
bool can_preload() { return test::can_fail_allocations(); }

struct Case {
  const char* name;
  const char* arguments;
  std::size_t outputs;
};

std::ostream& operator<<(std::ostream& out, const Case& one) { return out << one.name; }

class Program : public testing::TestWithParam<Case> {};

TEST_P(Program, ExitsWithOneAndLeavesNoOutputWhereverAWriteFails) {
  if (!can_preload()) GTEST_SKIP() << "not under sanitizers";
  int failed = 0;
  for (int n = 1;; ++n) {
    SCOPED_TRACE("call " + std::to_string(n));
    ASSERT_LT(n, 1000);
    const TemporaryFolder folder;
    std::ofstream(folder / "tree.swc") << tree;
    const auto [outcome, call_failed] = run_with_failing_call(folder, GetParam().arguments, n);
    if (outcome.code == 0) {
      ASSERT_EQ(test::file_count(folder), 1 + GetParam().outputs);
    }
    if (!call_failed) {
      EXPECT_EQ(outcome.code, 0) << outcome.messages;
      break;
    }
    if (outcome.code == 0) continue;  // it could do without that call
    ++failed;
    ASSERT_EQ(outcome.code, 1) << outcome.messages;
    const std::size_t line = outcome.messages.rfind("tremula: error: ");
    ASSERT_NE(line, std::string::npos) << outcome.messages;
    ASSERT_EQ(outcome.messages.find('\n', line), outcome.messages.size() - 1) << outcome.messages;
    ASSERT_EQ(test::file_count(folder), 1U) << outcome.messages;
  }
  EXPECT_GE(failed, 1) << "one write at least";
}

TEST(ProgramInMemory, WritesAllOrNothingAndSaysSoWhereverItRunsOut) {
  if (!can_preload()) GTEST_SKIP() << "the sanitizers want much more";
  int refused = 0, done = 0;
  for (int kilobytes = 40000; kilobytes <= 240000; kilobytes += 5000) {
    SCOPED_TRACE(kilobytes);
    const TemporaryFolder folder;
    const test::Outcome outcome =
        test::run(folder, "animate sapling -o a.glb -o b.html -o c.csv --report d.json",
                  "ulimit -v " + std::to_string(kilobytes) + "; ");
    if (outcome.code == 127) continue;  // its libraries do not find room, and it does not begin
    if (outcome.code == 0) {
      ++done;
      EXPECT_EQ(test::file_count(folder), 4U);
      continue;
    }
    ++refused;
    EXPECT_EQ(outcome.code, 1) << outcome.messages;
    EXPECT_NE(outcome.messages.find("tremula: error: "), std::string::npos) << outcome.messages;
    EXPECT_EQ(test::file_count(folder), 0U) << outcome.messages;
  }
  EXPECT_GE(refused, 1);
  EXPECT_GE(done, 1);
}

INSTANTIATE_TEST_SUITE_P(
    Every, Program,
    testing::Values(
        Case{"Animate",
             "animate tree.swc -o a.glb -o b.csv -o c.png --report d.json --modes 2 --period 1 --fps 8", 4},
        Case{"Grow", "grow stam-17 -o a.swc", 1},
        Case{"Modes", "modes tree.swc --count 3 -o a.json --plot b.svg", 2},
        Case{"ModesToStdout", "modes tree.swc --count 3", 0}, Case{"InfoToStdout", "info tree.swc", 0},
        Case{"Wind", "wind --speed 8 --steps 16 --points 2x2 -o a.bts -o b.vti --report c.json", 3}),
    [](const auto& instance) { return instance.param.name; });

}  // namespace
}  // namespace tremula

#endif
