// Memory that runs out anywhere in a reader or a writer: bad_alloc or Error, nothing lost, no file left.
#include "tremula/base/error.hpp"

#include <filesystem>
#include <new>

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include "failing_calls.hpp"
#include "support.hpp"
#include "tasks.hpp"
#include "tremula/io/atomic_file.hpp"

namespace tremula {
namespace {

using test::Calls;
using test::FailingCall;
using test::Fails;

enum class Outcome { done, out_of_memory, error };

Outcome outcome_of(const std::function<void()>& work) {
  try {
    work();
    return Outcome::done;
  } catch (const std::bad_alloc&) {
    return Outcome::out_of_memory;
  } catch (const Error&) {
    return Outcome::error;
  }
}

// The first hundred allocations one by one, then some of the rest: a few hundred runs in all.
long next_after(long n, long total) { return n < 100 ? n + 1 : n + 1 + total / 200; }

// `work` with every allocation failing in turn; `check` after each.
void fail_every_allocation(const std::function<void()>& work, const std::function<void(Outcome)>& check) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
  work();  // what is made once is there now
  long total = 0;
  {
    const FailingCall none(Calls::allocations, 0);
    work();
    total = none.count();
    ASSERT_EQ(none.more_allocations(), 0) << "nothing is kept from one run to the next";
  }
  ASSERT_GT(total, 3);
  for (const Fails fails : {Fails::once, Fails::for_good}) {
    for (long n = 1; n <= total; n = next_after(n, total)) {
      Outcome outcome{};
      long more = 0;
      {
        const FailingCall failing(Calls::allocations, n, fails);
        outcome = outcome_of(work);
        more = failing.more_allocations();
      }
      ASSERT_EQ(more, 0) << more << " blocks lost when allocation " << n << " of " << total << " fails";
      check(outcome);
    }
  }
}

class ReadingInMemory : public testing::TestWithParam<test::ReadTask> {};

TEST_P(ReadingInMemory, StandsAFailingAllocationWhereverItIs) {
  if (!test::can_fail_allocations()) GTEST_SKIP() << "the sanitizers have a malloc of their own";
  const test::TemporaryFolder folder;
  const std::string path = folder / "input";
  write_file_atomically(path, GetParam().bytes());
  const std::size_t right = GetParam().read(path);
  std::size_t found = 0;
  int failed = 0;
  fail_every_allocation([&] { found = GetParam().read(path); },
                        [&](Outcome outcome) {
                          if (outcome != Outcome::done) ++failed;
                          if (outcome == Outcome::done) {
                            ASSERT_EQ(found, right);
                          }
                        });
  EXPECT_GT(failed, 3);
}

class WritingInMemory : public testing::TestWithParam<test::WriteTask> {};

TEST_P(WritingInMemory, StandsAFailingAllocationWhereverItIsAndLeavesNoFile) {
  if (!test::can_fail_allocations()) GTEST_SKIP() << "the sanitizers have a malloc of their own";
  if (GetParam().builds_json) GTEST_SKIP() << "see ProgramInMemory";
  const test::TemporaryFolder folder;
  const std::string path = folder / "output";
  GetParam().write(path);
  const std::string right = read_file(path);
  std::filesystem::remove(path);
  int failed = 0;
  fail_every_allocation(
      [&] {
        GetParam().write(path);
        ::unlink(path.c_str());
      },
      [&](Outcome outcome) {
        if (outcome != Outcome::done) ++failed;
        ASSERT_TRUE(std::filesystem::is_empty(folder.path));
      });
  EXPECT_GT(failed, 3);
  GetParam().write(path);
  EXPECT_EQ(read_file(path), right) << "after all these failures";
}

const auto name_of = [](const auto& instance) { return instance.param.name; };
INSTANTIATE_TEST_SUITE_P(Every, ReadingInMemory, testing::ValuesIn(test::read_tasks()), name_of);
INSTANTIATE_TEST_SUITE_P(Every, WritingInMemory, testing::ValuesIn(test::write_tasks()), name_of);

}  // namespace
}  // namespace tremula
