#include "tremula/io/atomic_file.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include <gmock/gmock.h>

#include "complaint.hpp"
#include "support.hpp"
#include "tremula/base/error.hpp"

namespace tremula {
namespace {

namespace fs = std::filesystem;
using test::TemporaryFolder;
using testing::HasSubstr;

std::string contents(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

long files_in(const TemporaryFolder& folder) {
  return std::distance(fs::directory_iterator(folder.path), fs::directory_iterator());
}

// Of whatever kind: what is written fails with Error, what is read with InputError.
template <typename Call>
std::string complaint(Call call) {
  return test::complaint_of<Error>(call);
}

const std::string all_bytes = [] {
  std::string bytes;
  for (int i = 0; i < 70000; ++i) bytes += static_cast<char>(i * 7);
  return bytes;
}();

TEST(WriteFileAtomically, WritesTheBytesAndNothingElse) {
  const TemporaryFolder folder;
  write_file_atomically(folder / "a", all_bytes);
  EXPECT_EQ(contents(folder / "a"), all_bytes);
  write_file_atomically(folder / "a", "");
  EXPECT_EQ(contents(folder / "a"), "");
  EXPECT_EQ(files_in(folder), 1);
}

TEST(WriteFileAtomically, ReplacesAFileAtOnceAndKeepsItsPermissions) {
  const TemporaryFolder folder;
  write_file_atomically(folder / "a", "old");
  fs::permissions(folder / "a", fs::perms(0640));
  std::ifstream reader(folder / "a");  // someone who reads the old file goes on reading the old file
  write_file_atomically(folder / "a", "new and longer");
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(reader), {}), "old");
  EXPECT_EQ(contents(folder / "a"), "new and longer");
  EXPECT_EQ(fs::status(folder / "a").permissions(), fs::perms(0640));
}

TEST(WriteFileAtomically, FollowsALinkToItsFile) {
  const TemporaryFolder folder;
  fs::create_directory(folder.path / "inner");
  write_file_atomically(folder / "inner/real", "old");
  fs::create_symlink("inner/real", folder.path / "link");
  write_file_atomically(folder / "link", "new");
  EXPECT_TRUE(fs::is_symlink(folder.path / "link"));
  EXPECT_EQ(contents(folder / "inner/real"), "new");
}

TEST(WriteFileAtomically, WritesWhereSixteenThreadsWriteAtOnce) {
  const TemporaryFolder folder;
  std::vector<std::thread> threads;
  for (int i = 0; i < 16; ++i) {
    threads.emplace_back(
        [&, i] { write_file_atomically(folder / "a", std::string(50000, static_cast<char>('a' + i))); });
  }
  for (std::thread& thread : threads) thread.join();
  const std::string whole = contents(folder / "a");
  EXPECT_EQ(whole, std::string(50000, whole.at(0)));
  EXPECT_EQ(files_in(folder), 1);
}

TEST(WriteFileAtomically, LeavesTheOldFileAndNothingElseWhenTheDiskIsFull) {
  const TemporaryFolder folder;
  write_file_atomically(folder / "a", "old");
  rlimit before;
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit little{1000, before.rlim_max};
  const auto handler = signal(SIGXFSZ, SIG_IGN);
  setrlimit(RLIMIT_FSIZE, &little);
  const std::string text = complaint([&] { write_file_atomically(folder / "a", all_bytes); });
  setrlimit(RLIMIT_FSIZE, &before);
  signal(SIGXFSZ, handler);
  EXPECT_EQ(text, folder / "a" + ": cannot be written: File too large");
  EXPECT_EQ(contents(folder / "a"), "old");
  EXPECT_EQ(files_in(folder), 1);
}

TEST(WriteFileAtomically, SaysWhyItCannotWrite) {
  const TemporaryFolder folder;
  EXPECT_EQ(complaint([&] { write_file_atomically(folder / "no/a", "x"); }),
            folder / "no/a" + ": cannot be written: No such file or directory");
  EXPECT_EQ(complaint([&] { write_file_atomically(folder.path, "x"); }),
            folder.path.string() + ": cannot be written: Is a directory");
  EXPECT_EQ(files_in(folder), 0);
}

TEST(WriteFileAtomically, NeverReplacesADevice) {
  EXPECT_EQ(complaint([] { write_file_atomically("/dev/null", "x"); }), "");
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
  EXPECT_EQ(complaint([] { write_file_atomically("/dev/full", "x"); }),
            "/dev/full: cannot be written: No space left on device");
  EXPECT_TRUE(fs::is_character_file("/dev/full"));
}

TEST(WriteFileAtomically, RefusesALinkToItselfAndLeavesIt) {
  const TemporaryFolder folder;
  fs::create_symlink("link", folder.path / "link");
  EXPECT_EQ(complaint([&] { write_file_atomically(folder / "link", "x"); }),
            folder / "link" + ": cannot be written: Too many levels of symbolic links");
  EXPECT_TRUE(fs::is_symlink(folder.path / "link"));
  EXPECT_EQ(files_in(folder), 1);
}

TEST(WriteFileAtomically, MakesTheFileThatADanglingLinkNames) {
  const TemporaryFolder folder;
  fs::create_symlink("real", folder.path / "link");
  write_file_atomically(folder / "link", "new");
  EXPECT_TRUE(fs::is_symlink(folder.path / "link"));
  EXPECT_EQ(contents(folder / "real"), "new");
}

// A process that has been and gone.
pid_t dead_process() {
  const pid_t child = fork();
  if (child == 0) _exit(0);
  waitpid(child, nullptr, 0);
  return child;
}

TEST(WriteFileAtomically, RemovesWhatDeadProcessesLeftInThatFolderAndNothingElse) {
  const TemporaryFolder folder;
  const std::string dead = std::to_string(dead_process());
  const std::vector<std::string> gone{".tremula-" + dead + "-0", ".tremula-" + dead + "-17"},
      kept{".tremula-" + std::to_string(getppid()) + "-0", ".tremula-" + dead, ".tremula-" + dead + "-x",
           "tremula-" + dead + "-0", ".tremula-" + dead + "-0.csv"};
  for (const auto& names : {gone, kept}) {
    for (const std::string& name : names) std::ofstream(folder / name) << "left";
  }
  write_file_atomically(folder / "a", "x");
  for (const std::string& name : gone) EXPECT_FALSE(fs::exists(folder / name)) << name;
  for (const std::string& name : kept) EXPECT_TRUE(fs::exists(folder / name)) << name;
}

TEST(WriteFileAtomically, LeavesAFileThatSomeoneHasLocked) {
  const TemporaryFolder folder;
  const std::string name = folder / (".tremula-" + std::to_string(dead_process()) + "-0");
  std::ofstream(name) << "of a process that this one cannot see";
  const int file = open(name.c_str(), O_RDONLY);
  ASSERT_EQ(flock(file, LOCK_EX), 0);
  write_file_atomically(folder / "a", "x");
  EXPECT_TRUE(fs::exists(name));
  close(file);
  write_file_atomically(folder / "a", "x");
  EXPECT_FALSE(fs::exists(name));
}

TEST(AbandonUnfinishedFiles, LeavesNothingBehindAndLetsNoOtherBegin) {
  const TemporaryFolder folder;
  const pid_t child = fork();
  if (child == 0) {
    AtomicFile one(folder / "one"), two(folder / "two");
    one.write("some");
    abandon_unfinished_files();
    _exit(fs::is_empty(folder.path) ? 42 : 1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), 42);
  EXPECT_EQ(files_in(folder), 0);
}

TEST(CommitTogether, GivesEveryFileItsNameAndWhatWasThereIsGone) {
  const TemporaryFolder folder;
  write_file_atomically(folder / "a", "old");
  AtomicFile a(folder / "a"), b(folder / "b");
  a.write("new a");
  b.write("new b");
  commit_together(std::array{&a, &b});
  EXPECT_EQ(contents(folder / "a"), "new a");
  EXPECT_EQ(contents(folder / "b"), "new b");
  EXPECT_EQ(files_in(folder), 2);
}

TEST(CommitTogether, LeavesEverythingAsItWasWhereOneFileCannotHaveItsName) {
  const TemporaryFolder folder;
  write_file_atomically(folder / "old", "old");
  {
    AtomicFile old(folder / "old"), fresh(folder / "fresh"), blocked(folder / "blocked"),
        last(folder / "last");
    for (AtomicFile* file : {&old, &fresh, &blocked, &last}) file->write("new");
    fs::create_directory(folder / "blocked");  // since the file was begun
    EXPECT_THROW(commit_together(std::array{&old, &fresh, &blocked, &last}), Error);
  }
  EXPECT_EQ(contents(folder / "old"), "old");
  EXPECT_FALSE(fs::exists(folder / "fresh"));
  EXPECT_FALSE(fs::exists(folder / "last"));
  EXPECT_EQ(files_in(folder), 2);
}

TEST(CommitTogether, RenamesNothingWhereADeviceIsFull) {
  const TemporaryFolder folder;
  {
    AtomicFile file(folder / "a"), full("/dev/full");
    file.write("x");
    full.write("x");
    EXPECT_THROW(commit_together(std::array{&file, &full}), Error);
  }
  EXPECT_EQ(files_in(folder), 0);
}

TEST(AtomicFile, GivesAPipeItsBytesOnlyOnCommit) {
  int ends[2];
  ASSERT_EQ(pipe2(ends, O_NONBLOCK), 0);
  char byte = 0;
  {
    AtomicFile abandoned(ends[1], "pipe");
    abandoned.write("never");
  }
  EXPECT_EQ(read(ends[0], &byte, 1), -1);
  AtomicFile out(ends[1], "pipe");
  out.write("x");
  EXPECT_EQ(read(ends[0], &byte, 1), -1);
  out.commit();
  EXPECT_EQ(read(ends[0], &byte, 1), 1);
  EXPECT_EQ(byte, 'x');
  EXPECT_EQ(close(ends[1]), 0) << "what was open stays open";
  close(ends[0]);
}

TEST(AtomicFile, RefusesAStreamThatIsClosedOrOnlyRead) {
  EXPECT_THAT(complaint([] { AtomicFile(-1, "standard output"); }), HasSubstr("standard output"));
  const int file = open("/dev/null", O_RDONLY);
  EXPECT_THAT(complaint([&] { AtomicFile(file, "standard output"); }), HasSubstr("cannot be written"));
  close(file);
}

TEST(FileBehind, IsWhatAWriteReplaces) {
  const TemporaryFolder folder;
  write_file_atomically(folder / "real", "x");
  fs::create_symlink("real", folder.path / "link");
  EXPECT_EQ(file_behind(folder / "link"), folder / "real");
  EXPECT_EQ(file_behind(folder / "new"), folder / "new");
  EXPECT_EQ(complaint([&] { file_behind(folder / "no/new"); }),
            folder / "no/new" + ": cannot be written: No such file or directory");
  EXPECT_THAT(complaint([&] { file_behind(folder.path); }), HasSubstr("Is a directory"));
}

TEST(ReadFile, GivesBackWhatWasWritten) {
  const TemporaryFolder folder;
  write_file_atomically(folder / "a", all_bytes);
  EXPECT_EQ(read_file(folder / "a"), all_bytes);
  write_file_atomically(folder / "a", "");
  EXPECT_EQ(read_file(folder / "a"), "");
}

TEST(ReadFile, ReadsAPipeToItsEnd) {
  const TemporaryFolder folder;
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  std::thread writer([&] { std::ofstream(folder / "pipe", std::ios::binary) << all_bytes; });
  EXPECT_EQ(read_file(folder / "pipe"), all_bytes);
  writer.join();
}

TEST(ReadFile, RejectsWhatIsMissingAFolderOrTooLarge) {
  const TemporaryFolder folder;
  EXPECT_EQ(complaint([&] { read_file(folder / "a"); }),
            folder / "a" + ": cannot be opened (No such file or directory), wanted a readable file");
  EXPECT_EQ(complaint([&] { read_file(folder.path); }),
            folder.path.string() + ": is a folder, wanted a file");
  write_file_atomically(folder / "a", "12345");
  EXPECT_EQ(read_file(folder / "a", 5), "12345");
  EXPECT_EQ(complaint([&] { read_file(folder / "a", 4); }),
            folder / "a" + ": holds more than the 4 bytes that are read, wanted a smaller file");
  EXPECT_EQ(complaint([&] { read_file("/dev/zero", 100000); }), "/dev/zero: is a device, wanted a file");
}

TEST(ReadFile, ThrowsInputErrorSoThatTheProgramCanTellBadInputFromBadLuck) {
  EXPECT_THROW(read_file("/nowhere/at/all"), InputError);
  try {
    write_file_atomically("/nowhere/at/all", "x");
    FAIL() << "wrote into a folder that is not there";
  } catch (const InputError&) {
    FAIL() << "a failed write is not bad input";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("/nowhere/at/all"));
  }
}

}  // namespace
}  // namespace tremula
