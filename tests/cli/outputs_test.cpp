// Where results go: never over an input or another output, all or none, and nothing left behind.
#include "cli/outputs.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include "cli/program.hpp"

#include <chrono>
#include <csignal>
#include <limits>
#include <nlohmann/json.hpp>
#include <thread>

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tremula/base/error.hpp"

namespace tremula {
namespace {

namespace fs = std::filesystem;
using test::contents;
using test::file_count;
using test::Outcome;
using test::run;
using test::TemporaryFolder;
using testing::HasSubstr;
using testing::StartsWith;

const std::string quick = "animate stam-17 --period 1 --fps 4 ";

// As run(), for a whole line of shell; $T is the program.
Outcome run_shell(const TemporaryFolder& folder, const std::string& line) {
  const std::string command = "cd '" + folder.path.string() + "' && export T='" TREMULA_PROGRAM "' && ( " +
                              line + " ) > stdout.txt 2> stderr.txt < /dev/null";
  const int status = std::system(command.c_str());
  const Outcome outcome{WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status),
                        contents(folder / "stdout.txt"), contents(folder / "stderr.txt")};
  fs::remove(folder / "stdout.txt");
  fs::remove(folder / "stderr.txt");
  return outcome;
}

void make_field(const TemporaryFolder& folder) {
  ASSERT_EQ(run(folder, "wind --points 3x3 --steps 32 -o field.bts").code, 0);
}

TEST(Outputs, NeverReplaceAnInputByWhateverName) {
  const TemporaryFolder folder;
  make_field(folder);
  ASSERT_EQ(run(folder, "grow stam-17 -o tree.swc").code, 0);
  fs::create_hard_link(folder / "field.bts", folder / "hard.bts");
  fs::create_symlink("field.bts", folder / "soft.bts");
  fs::create_hard_link(folder / "tree.swc", folder / "hard.csv");
  fs::create_hard_link(folder / "tree.swc", folder / "hard.json");
  const std::string field = contents(folder / "field.bts"), tree = contents(folder / "tree.swc");
  const auto before = file_count(folder);
  for (const std::string arguments :
       {"wind -o field.bts field.bts", "wind field.bts -o ./field.bts", "wind field.bts -o hard.bts",
        "wind field.bts -o soft.bts", "wind soft.bts -o field.bts", "wind field.bts -o x.vti -o field.bts",
        "animate tree.swc -o hard.csv", "animate tree.swc --report hard.json",
        "modes tree.swc -o ././hard.csv", "grow tree.swc -o tree.swc"}) {
    const Outcome outcome = run(folder, arguments);
    EXPECT_EQ(outcome.code, 2) << arguments;
    EXPECT_THAT(outcome.messages, HasSubstr("would replace the input")) << arguments;
    EXPECT_EQ(file_count(folder), before) << arguments;
  }
  EXPECT_EQ(contents(folder / "field.bts"), field);
  EXPECT_EQ(contents(folder / "tree.swc"), tree);
}

TEST(Outputs, NeverReplaceEachOther) {
  const TemporaryFolder folder;
  fs::create_directory(folder / "sub");
  fs::create_symlink("../a.csv", folder / "sub/b.csv");
  for (const std::string& arguments :
       {quick + "-o a.csv -o a.csv", quick + "-o a.csv -o ./a.csv", quick + "-o a.csv -o sub/../a.csv",
        quick + "-o a.csv -o sub/b.csv", quick + "-o - --format csv --report -",
        std::string("modes stam-17 --plot -")}) {
    const Outcome outcome = run(folder, arguments);
    EXPECT_EQ(outcome.code, 2) << arguments;
    EXPECT_THAT(outcome.messages, HasSubstr("a place of its own")) << arguments;
    EXPECT_EQ(outcome.output, "");
    EXPECT_EQ(file_count(folder), 1U) << arguments;
  }
  EXPECT_EQ(run(folder, quick + "-o /dev/null -o /dev/null --format csv --report /dev/null").code, 0);
}

TEST(Outputs, AFlagTakesOneFileAndMayBeRepeated) {
  const TemporaryFolder folder;
  make_field(folder);
  const std::string field = contents(folder / "field.bts");
  ASSERT_EQ(run(folder, "wind -o y.vti field.bts").code, 0);  // the field is read, not written
  EXPECT_EQ(contents(folder / "field.bts"), field);
  ASSERT_EQ(run(folder, "animate -o a.csv stam-17 -o a.png --period 1 --fps 4").code, 0);
  EXPECT_TRUE(fs::exists(folder / "a.csv") && fs::exists(folder / "a.png"));
  ASSERT_EQ(run(folder, "grow --set order=2 stam-17 -o a.swc").code, 2);  // no such constant, but a plant
}

TEST(Outputs, AreAllWrittenOrNone) {
  const TemporaryFolder folder;
  std::ofstream(folder / "a.csv") << "old";
  for (const std::string& line :
       {quick + "-o a.csv -o a.png -o /dev/full --format csv", quick + "-o a.csv -o a.png --report /dev/full",
        std::string("wind --points 3x3 --steps 32 -o a.bts -o a.vti --plot a.svg --report /dev/full"),
        std::string("modes stam-17 -o a.csv --plot /dev/full")}) {
    const Outcome outcome = run(folder, line);
    EXPECT_EQ(outcome.code, 1) << line << outcome.messages;
    EXPECT_THAT(outcome.messages, HasSubstr("tremula: error: /dev/full: cannot be written: No space left"));
    EXPECT_THAT(outcome.messages, testing::Not(HasSubstr("wrote"))) << line;
    EXPECT_EQ(contents(folder / "a.csv"), "old") << line;
    EXPECT_EQ(file_count(folder), 1U) << line;
  }
}

TEST(Outputs, AFolderThatIsMissingIsFoundBeforeTheWork) {
  const TemporaryFolder folder;
  std::ofstream(folder / "bad.swc") << "not a tree";
  for (const std::string arguments :
       {"animate bad.swc -o a.csv -o nowhere/a.glb", "modes bad.swc -o nowhere/a.csv",
        "animate bad.swc -o a.csv --report nowhere/r.json", "grow bad.swc -o nowhere/a.swc",
        "wind bad.bts -o nowhere/a.bts"}) {
    const Outcome outcome = run(folder, arguments);
    EXPECT_EQ(outcome.code, 1) << arguments;
    EXPECT_THAT(outcome.messages, HasSubstr("nowhere/")) << arguments;
    EXPECT_THAT(outcome.messages, HasSubstr("No such file or directory")) << arguments;
    EXPECT_EQ(file_count(folder), 1U);
  }
}

TEST(Outputs, ALinkToItselfIsRefusedAndStays) {
  const TemporaryFolder folder;
  fs::create_symlink("a.csv", folder / "a.csv");
  const Outcome outcome = run(folder, quick + "-o a.csv");
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.messages, HasSubstr("Too many levels of symbolic links"));
  EXPECT_TRUE(fs::is_symlink(folder / "a.csv"));
}

TEST(Outputs, AWriteToAStandardOutputThatIsFullOrClosedFails) {
  const TemporaryFolder folder;
  make_field(folder);
  for (const std::string arguments :
       {"modes stam-17", "modes stam-17 --format json", "info stam-17", "info stam-17 --format json",
        "info field.bts", "grow --list", "grow stam-17 -o -", "wind --list-terrains",
        "animate stam-17 --period 1 --fps 4 -o a.csv --report -", "--help", "modes --help", "--version"}) {
    for (const std::string where : {"> /dev/full", ">&-", "| true"}) {
      const Outcome outcome = run_shell(
          folder, where == "| true"
                      ? "( sleep 0.1; $T " + arguments + "; echo $? > code ) | true; exit $(cat code)"
                      : "$T " + arguments + " " + where);
      EXPECT_EQ(outcome.code, 1) << arguments << where;
      EXPECT_THAT(outcome.messages, HasSubstr("tremula: error: standard output: cannot be written"))
          << arguments;
      fs::remove(folder / "code");
      EXPECT_EQ(file_count(folder), 1U) << arguments << where;
    }
  }
}

TEST(Outputs, GoToStandardOutputByADash) {
  const TemporaryFolder folder;
  ASSERT_EQ(run(folder, quick + "-o a.csv -o a.glb --report r.json").code, 0);
  EXPECT_EQ(run(folder, quick + "-o - --format csv").output, contents(folder / "a.csv"));
  EXPECT_EQ(run(folder, quick + "-o a.csv -o - --format glb").output, contents(folder / "a.glb"));
  const auto report = nlohmann::json::parse(run(folder, quick + "--report -").output);
  EXPECT_EQ(report["frequencies_hz"], nlohmann::json::parse(contents(folder / "r.json"))["frequencies_hz"]);
  ASSERT_EQ(run(folder, "grow stam-17 -o tree.swc").code, 0);
  EXPECT_EQ(run(folder, "grow stam-17 -o -").output, contents(folder / "tree.swc"));
  EXPECT_EQ(run(folder, "modes stam-17 -o - --format csv").output,
            run(folder, "modes stam-17 --format csv").output);
  const Outcome nameless = run(folder, quick + "-o -");
  EXPECT_EQ(nameless.code, 2);
  EXPECT_THAT(nameless.messages, HasSubstr("-o -: has no extension that says what to write"));
}

TEST(Outputs, TheExtensionDecidesTheFormat) {
  const TemporaryFolder folder;
  ASSERT_EQ(run(folder, "modes stam-17 --count 3 -o a.csv").code, 0);
  EXPECT_EQ(contents(folder / "a.csv"), run(folder, "modes stam-17 --count 3 --format csv").output);
  ASSERT_EQ(run(folder, "modes stam-17 --count 3 -o a.JSON").code, 0);
  EXPECT_TRUE(nlohmann::json::accept(contents(folder / "a.JSON")));
  ASSERT_EQ(run(folder, "modes stam-17 --count 3 -o a.txt").code, 0);
  EXPECT_THAT(contents(folder / "a.txt"), StartsWith("stam-17: 17 branches"));
  for (const auto& [arguments, part] : std::vector<std::pair<std::string, std::string>>{
           {"modes stam-17 -o b.csv --format json", "--format json: given with -o b.csv"},
           {"modes stam-17 -o b.table", "'.table', wanted .txt (a table), .json"},
           {quick + "-o b.glb --format csv", "--format csv: given with -o b.glb"},
           {quick + "--report b.txt", "--report b.txt: '.txt', wanted .json"},
           {"grow stam-17 -o b.csv", "'.csv', wanted .swc"}}) {
    const Outcome outcome = run(folder, arguments);
    EXPECT_EQ(outcome.code, 2) << arguments;
    EXPECT_THAT(outcome.messages, HasSubstr(part));
  }
  EXPECT_EQ(file_count(folder), 3U);
}

TEST(Outputs, AFileNameThatIsNotUtf8IsANameLikeAnyOther) {
  const TemporaryFolder folder;
  ASSERT_EQ(run(folder, "grow stam-17 -o \xFF.swc").code, 0);
  const Outcome outcome =
      run(folder, "animate \xFF.swc --period 1 --fps 4 -o \xFE.csv -o \xFE.glb --report r.json");
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  EXPECT_TRUE(fs::exists(folder / "\xFE.csv") && fs::exists(folder / "\xFE.glb"));
  const auto report = nlohmann::json::parse(contents(folder / "r.json"));
  EXPECT_EQ(report["input"], "\xEF\xBF\xBD.swc");
}

TEST(Outputs, ThatWouldNotFitAreRefusedWithTheNumber) {
  const TemporaryFolder folder;
  const auto begun = std::chrono::steady_clock::now();
  const Outcome outcome = run(folder, "animate oak --period 1e6 --fps 16 -o a.csv");
  EXPECT_EQ(outcome.code, 1);
  // 1.6e7 frames of the oak's nodes at 150 bytes, twice.
  EXPECT_THAT(outcome.messages, testing::ContainsRegex("a loop of 16000000 frames and 20 modes wants about "
                                                       "[0-9.e+]+ GB of memory and there are [0-9.]+ GB"));
  EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(30));
  EXPECT_EQ(file_count(folder), 0U);
  const Outcome all = run(folder, quick + "--modes 100000 -o a.csv");
  EXPECT_EQ(all.code, 0);
  EXPECT_THAT(all.messages, HasSubstr("warning: --modes 100000: the plant has 102, and all are taken"));
}

TEST(TextOf, RefusesANumberThatIsNotFiniteAndSaysWhere) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(cli::text_of({{"a", 0.5}, {"b", {1, nullptr, "nan"}}}),
            "{\n \"a\": 0.5,\n \"b\": [\n  1,\n  null,\n  \"nan\"\n ]\n}\n");
  try {
    cli::text_of({{"motion", {{"rms_m", cli::Json::array({1.0, nan})}}}});
    FAIL() << "wrote a number that is not finite";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("/motion/rms_m/1 is nan"));
  }
}

TEST(Printed, RefusesANumberThatIsNotFinite) {
  EXPECT_EQ(cli::printed("%d %.2f %s", 3, 0.5, "nan"), "3 0.50 nan");
  EXPECT_THROW(cli::printed("%.2f", std::numeric_limits<double>::infinity()), Error);
}

// Starts a run that has one temporary file and waits for a reader of its second output, which never comes.
struct WaitingRun {
  TemporaryFolder folder;
  pid_t process = 0;

  WaitingRun() {
    mkfifo((folder / "pipe").c_str(), 0600);
    process = fork();
    if (process == 0) {
      if (chdir(folder.path.c_str()) != 0) _exit(99);
      const int nothing = open("/dev/null", O_RDWR);
      dup2(nothing, STDERR_FILENO);
      for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, SIG_DFL);
      execl(TREMULA_PROGRAM, "tremula", "animate", "stam-17", "--period", "1", "--fps", "4", "-o", "a.csv",
            "-o", "pipe", "--format", "csv", static_cast<char*>(nullptr));
      _exit(98);
    }
    for (int i = 0; i < 3000 && temporaries() == 0; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  int temporaries() const {
    int count = 0;
    for (const auto& entry : fs::directory_iterator(folder.path))
      count += entry.path().filename().string().starts_with(".tremula-") ? 1 : 0;
    return count;
  }
  int stop(int signal) const {
    kill(process, signal);
    int status = 0;
    waitpid(process, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }
};

TEST(Outputs, AreCleanedUpWhenTheRunIsStopped) {
  for (const int signal : {SIGINT, SIGTERM}) {
    const WaitingRun run;
    ASSERT_EQ(run.temporaries(), 1);
    EXPECT_EQ(run.stop(signal), 128 + signal);
    EXPECT_EQ(file_count(run.folder), 1U) << "more than the pipe is left";
  }
}

TEST(Outputs, OfAKilledRunAreRemovedByTheNext) {
  const WaitingRun killed;
  ASSERT_EQ(killed.temporaries(), 1);
  EXPECT_EQ(killed.stop(SIGKILL), -SIGKILL);
  EXPECT_EQ(killed.temporaries(), 1);
  ASSERT_EQ(run(killed.folder, quick + "-o b.csv").code, 0);
  EXPECT_EQ(killed.temporaries(), 0);
}

}  // namespace
}  // namespace tremula
