// Disks that fill up and fail anywhere in a reader or a writer: one clean error, and the file that was there
// before as it was.
#include "tremula/base/error.hpp"
#include "tremula/io/atomic_file.hpp"

#include <cerrno>
#include <filesystem>

#include <gtest/gtest.h>

#include "failing_calls.hpp"
#include "support.hpp"
#include "tasks.hpp"

namespace tremula {
namespace {

using test::Calls;
using test::FailingCall;
using test::Fails;
using test::TemporaryFolder;

// ---- Writing

std::string written_by(const test::WriteTask& task) {
  const TemporaryFolder folder;
  task.write(folder / "output");
  return read_file(folder / "output");
}

std::size_t files_in(const TemporaryFolder& folder) {
  return static_cast<std::size_t>(
      std::distance(std::filesystem::directory_iterator(folder.path), std::filesystem::directory_iterator()));
}

struct Attempt {
  std::string complaint;  // "" where the writer was content
  long calls;
};

Attempt attempt(const test::WriteTask& task, const std::string& path, long n, Fails fails, int error) {
  const FailingCall failing(Calls::writing, n, fails, error);
  try {
    task.write(path);
  } catch (const Error& caught) {
    return {caught.what(), failing.count()};
  }
  return {"", failing.count()};
}

class WritingFiles : public testing::TestWithParam<test::WriteTask> {
 protected:
  const test::WriteTask& task = GetParam();
  const std::string right = written_by(task);
};

TEST_P(WritingFiles, SaysWhereverACallFailsAndLeavesTheOldFileOrTheNewOneWhole) {
  for (const int error : {ENOSPC, EIO}) {
    for (const Fails fails : {Fails::once, Fails::for_good}) {
      int failed = 0;
      for (long n = 1;; ++n) {
        SCOPED_TRACE("call " + std::to_string(n));
        const TemporaryFolder folder;
        const std::string path = folder / "output";
        write_file_atomically(path, "old");
        const Attempt done = attempt(task, path, n, fails, error);
        ASSERT_EQ(files_in(folder), 1U) << "something is left beside the file";
        const std::string found = read_file(path);
        if (done.calls < n) {
          ASSERT_EQ(done.complaint, "");
          ASSERT_TRUE(found == right);
          break;
        }
        if (done.complaint.empty()) {  // it could do without that call
          ASSERT_TRUE(found == right);
          continue;
        }
        ++failed;
        ASSERT_TRUE(done.complaint.starts_with(path + ": ")) << '"' << done.complaint << '"';
        ASSERT_TRUE(found == "old" || found == right) << "a file of " << found.size() << " bytes";
      }
      EXPECT_GE(failed, 3) << "open, write and rename at least";
    }
  }
}

TEST_P(WritingFiles, LeavesNoFileWhereACallFailsAndNoneWas) {
  for (long n = 1;; ++n) {
    SCOPED_TRACE("call " + std::to_string(n));
    const TemporaryFolder folder;
    const Attempt done = attempt(task, folder / "output", n, Fails::once, ENOSPC);
    if (done.calls < n) break;
    ASSERT_EQ(files_in(folder), done.complaint.empty() ? 1U : 0U) << done.complaint;
  }
}

TEST_P(WritingFiles, GoesOnAfterShortAndInterruptedWrites) {
  const test::ShortWrites shorter(right.size() / 50 + 1);
  EXPECT_TRUE(written_by(task) == right);
}

// ---- Reading

class ReadingFiles : public testing::TestWithParam<test::ReadTask> {};

TEST_P(ReadingFiles, SaysWhereverACallFails) {
  const TemporaryFolder folder;
  const std::string path = folder / "input";
  write_file_atomically(path, GetParam().bytes());
  const std::size_t right = GetParam().read(path);
  int failed = 0;
  for (long n = 1;; ++n) {
    std::string complaint;
    std::size_t found = 0;
    long calls = 0;
    {
      const FailingCall failing(Calls::reading, n, Fails::for_good, EIO);
      try {
        found = GetParam().read(path);
      } catch (const InputError& caught) {
        complaint = caught.what();
      }
      calls = failing.count();
    }
    if (calls < n) {
      EXPECT_EQ(found, right);
      break;
    }
    ++failed;
    EXPECT_TRUE(complaint.starts_with(path + ": cannot be ")) << complaint;
  }
  EXPECT_GE(failed, 2) << "open and read at least";
}

const auto name_of = [](const auto& instance) { return instance.param.name; };
INSTANTIATE_TEST_SUITE_P(Every, ReadingFiles, testing::ValuesIn(test::read_tasks()), name_of);
INSTANTIATE_TEST_SUITE_P(Every, WritingFiles, testing::ValuesIn(test::write_tasks()), name_of);

}  // namespace
}  // namespace tremula
