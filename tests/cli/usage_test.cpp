// Flags: numbers within bounds, none without effect, and messages that name them.
#include "cli/program.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

namespace tremula {
namespace {

using test::contents;
using test::file_count;
using test::Outcome;
using test::run;
using testing::HasSubstr;
using testing::StartsWith;

void expect_refused(const std::string& arguments, const std::vector<std::string>& parts) {
  const test::TemporaryFolder folder;
  const Outcome outcome = run(folder, arguments);
  EXPECT_EQ(outcome.code, 2) << arguments << "\n" << outcome.messages;
  EXPECT_THAT(outcome.messages, StartsWith("tremula: error: ")) << arguments;
  EXPECT_EQ(std::count(outcome.messages.begin(), outcome.messages.end(), '\n'), 1) << outcome.messages;
  for (const std::string& part : parts) EXPECT_THAT(outcome.messages, HasSubstr(part)) << arguments;
  EXPECT_EQ(file_count(folder), 0U) << arguments;
}

TEST(Usage, SeedsAreWholeNumbersOf64Bits) {
  const std::string range = "a whole number, 0 to 18446744073709551615";
  for (const std::string command :
       {"animate stam-17 -o a.csv", "grow stam-17 -o a.swc", "wind --report r.json"}) {
    for (const std::string seed : {"-1", "18446744073709551616", "1.5", "x", "0x10"})
      expect_refused(command + " --seed " + seed, {"--seed: '" + seed + "', wanted " + range});
  }
  const test::TemporaryFolder folder;
  ASSERT_EQ(run(folder, "grow stam-17 --seed 18446744073709551615 -o a.swc").code, 0);
  // With a zero in front a number stays decimal.
  ASSERT_EQ(run(folder, "grow sapling --seed 010 -o b.swc").code, 0);
  ASSERT_EQ(run(folder, "grow sapling --seed 10 -o c.swc").code, 0);
  EXPECT_EQ(contents(folder / "b.swc"), contents(folder / "c.swc"));
}

TEST(Usage, WhatIsMisspeltIsGuessed) {
  expect_refused("annimate oak", {"no command 'annimate'", "did you mean animate?"});
  expect_refused("animate oak --wind-sped 5 -o a.csv", {"'--wind-sped'", "did you mean --wind-speed?"});
  expect_refused("modes oak --coutn=5", {"'--coutn'", "tremula modes", "did you mean --count?"});
  expect_refused("modes oak --format jsno",
                 {"--format: 'jsno', wanted one of table, json, csv", "did you mean json?"});
  expect_refused("modes oak --zzzzzzzz 5", {"'--zzzzzzzz': no such flag of tremula modes (see"});
}

TEST(Usage, EveryMessageNamesTheFlag) {
  expect_refused("modes oak --modes", {"--modes: no value, wanted a number"});
  expect_refused("modes oak --modes abc", {"--modes: 'abc', wanted a whole number"});
  expect_refused("modes oak --modes 3 --count 4", {"--modes: given 2 times, wanted once"});
  expect_refused("modes oak --up-to 1e300", {"--up-to: '1e300', wanted 1e-09 to 1e+09 Hz"});
  expect_refused("modes oak --max-memory -1", {"--max-memory: '-1', wanted bytes"});
  expect_refused("modes oak --no-rotatory-inertia=maybe", {"--no-rotatory-inertia", "'maybe'"});
  expect_refused("modes oak ash", {"'ash': one argument too many"});
  expect_refused("animate oak -o a.csv --period 1e-16 --fps 4e16", {"1e-16", "--period"});
  expect_refused("animate oak -o a.csv --youngs-modulus 1e-25 --shear-modulus 1e-25",
                 {"--youngs-modulus: '1e-25'"});
  expect_refused("animate oak -o ''", {"--output: '', wanted a value"});
  expect_refused("animate oak -o a.glb --tolerance 0", {"--tolerance: '0'", "of the height"});
  expect_refused("animate oak -o a.glb --max-joints 1", {"--max-joints: '1'", "2 to 65535"});
  expect_refused("animate oak --report ''", {"--report: '', wanted a value"});
  expect_refused("wind --report r.json --decay-y 1,2", {"--decay-y: 2 values, wanted 3"});
}

TEST(Usage, FlagsWithoutEffectAreRefused) {
  const std::string animate = "animate stam-17 -o a.csv ";
  for (const std::string flag : {"--wind-speed 5",         "--reference-height 8",
                                 "--terrain open",         "--seed 3",
                                 "--spectrum iec-kaimal",  "--coherence iec",
                                 "--profile log",          "--turbulence-intensity 0.1",
                                 "--friction-velocity 1",  "--power-exponent 0.1",
                                 "--roughness-length 0.1", "--displacement 1",
                                 "--canopy-height 1",      "--canopy-decay 1",
                                 "--decay-y 1,2,3",        "--decay-z 1,2,3",
                                 "--amplitudes phases",    "--transfer sampled",
                                 "--correlation-time 1",   "--correlation-length 1"}) {
    const std::string name = flag.substr(0, flag.find(' '));
    expect_refused(animate + "--wind field.bts " + flag, {name + ": given with --wind field.bts"});
  }
  for (const std::string flag :
       {"--spectrum iec-kaimal", "--coherence iec", "--decay-y 1,2,3", "--amplitudes phases"}) {
    expect_refused(animate + "--wind stam " + flag, {": given with --wind stam"});
  }
  expect_refused(animate + "--correlation-time 2", {"--correlation-time: given with --wind turbulent"});
  expect_refused("animate stam-17 -o a.glb --frames 3", {"--frames", "-o FILE.csv"});
  expect_refused("animate stam-17 --report r.json --format csv", {"--format: given without -o"});
  expect_refused(animate + "--damping-ratio 0.1 --mass-damping 1",
                 {"--damping-ratio: given with --mass-damping"});
  expect_refused(animate + "--damping-ratio 0.1 --stiffness-damping 1",
                 {"--damping-ratio: given with --stiffness-damping"});
  expect_refused(animate + "--waves 0.5:4", {"--waves: given with --medium air, wanted --medium water"});
  expect_refused("animate sapling -o a.csv --medium water --water-depth 3",
                 {"--water-depth: given without --waves"});
  for (const std::string text : {"0.5", "0.5:", ":4", "0.5:4x", "a:4"}) {
    expect_refused("animate sapling -o a.csv --medium water --waves " + text,
                   {"--waves: '" + text + "', wanted a significant height [m] and a peak period [s]"});
  }
  expect_refused("animate sapling -o a.csv --medium water --waves 3:5 --water-depth 2",
                 {"significant height of the waves: 3", "break in 2 m of water"});
  expect_refused("animate curtain -o a.csv --medium water --waves 0.2:3",
                 {"--waves: given with a sheet, wanted --water-depth with it"});
  expect_refused("animate sapling -o a.csv --medium water --waves 0.2:25",
                 {"peak period of the waves: 25 s, wanted less than the period of the loop, 20 s"});
  expect_refused(animate + "--current 0.3", {"--current: given with --medium air, wanted --medium water"});
  expect_refused("animate sapling -o a.csv --medium water --current 0.3 --wind-speed 2",
                 {"--current: given with --wind-speed, wanted one of them"});
  expect_refused("animate kelp -o a.csv --current 0.3 --waves 0.5:4 --wind-speed 8",
                 {"--wind-speed: given with --current and --waves"});
  expect_refused("animate kelp -o a.csv --waves 8:9", {"significant height of the waves: 8", "of water"});
  expect_refused(animate + "--decay-time 1 --damping-ratio 0.1",
                 {"--damping-ratio: given with --decay-time"});
  expect_refused(animate + "--decay-time 1 --mode-damping 0.1", {"--mode-damping: given with --decay-time"});
  expect_refused(animate + "--mode-damping 0.1,0 -o b.csv", {"--mode-damping", "'0'"});
  expect_refused(animate + "--mode-damping 0.1,x -o b.csv", {"--mode-damping", "'x'"});
  expect_refused(animate + "--mass-damping 1 --stiffness-damping 1", {"--stiffness-damping"});
  expect_refused(animate + "--power-exponent 0.3", {"--power-exponent: given with --profile log"});
  expect_refused(animate + "--profile power --roughness-length 0.3",
                 {"--roughness-length: given with --profile power"});
  expect_refused(animate + "--canopy-decay 3", {"--canopy-decay", "--canopy-height"});
  expect_refused(animate + "--loads paper --leaf-drag-coefficient 1",
                 {"--leaf-drag-coefficient: given with --loads paper"});
  const std::string model = "animate sapling --period 2 -o a.glb ";
  expect_refused(animate + "--max-joints 20", {"--max-joints: given without a .glb or a page"});
  expect_refused(animate + "--tolerance 0.01", {"--tolerance: given without a .glb or a page"});
  expect_refused(model + "--form morph --max-joints 20", {"--max-joints: given with --form morph"});
  expect_refused(model + "--form skin --morphs paired", {"--morphs: given with --form skin"});
  expect_refused(model + "--morphs paired --max-joints 20", {"--max-joints: given with --morphs"});
  expect_refused(model + "--morphs paired --tolerance 0.01", {"--tolerance: given with --morphs"});
  const std::string frame = "animate '" + (test::source_folder() / "examples/frames/pergola.toml").string() +
                            "' --period 2 -o a.glb ";
  for (const std::string flag : {"--form skin", "--clip calm:2", "--max-joints 20", "--tolerance 0.01"})
    expect_refused(frame + flag, {flag.substr(0, flag.find(' ')), "given with a frame"});
  expect_refused(model + "--pose linear --max-joints 20",
                 {"--max-joints: given where displacements superpose"});
  expect_refused(model + "--pose linear --form skin", {"--form skin: given with linear poses"});
  expect_refused("modes oak --count 3 --up-to 5", {"--modes: given with --up-to"});
  expect_refused("modes stam-17 --method dense --tolerance 1e-9", {"--tolerance: given with --method dense"});
  expect_refused("grow --list --seed 3", {"--seed: given with --list"});
}

TEST(Usage, NoNumericFlagMakesTheProgramAnswerBadly) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "the sweep gives the program 4 GB of addresses, and a sanitizer takes more";
#endif
  const std::string sweep = (test::data_folder() / "../tools/sweep_flags.py").string();
  if (!std::filesystem::exists(sweep)) GTEST_SKIP() << "no " << sweep;
  const test::TemporaryFolder folder;
  const std::string command = "python3 '" + sweep + "' '" TREMULA_PROGRAM "' animate modes grow wind > '" +
                              (folder / "found") + "' 2>&1";
  EXPECT_EQ(std::system(command.c_str()), 0) << contents(folder / "found");
}

TEST(Usage, EveryDynamicsAnimatesAndRefusesTheFlagsOfTheOthers) {
  const test::TemporaryFolder folder;
  std::vector<std::string> tables;
  for (const std::string dynamics : {"modal", "time", "oscillators"}) {
    const Outcome outcome =
        run(folder, "animate stam-17 -o " + dynamics + ".csv --period 4 --frames 3 --dynamics " + dynamics);
    EXPECT_EQ(outcome.code, 0) << outcome.messages;
    tables.push_back(contents(folder / (dynamics + ".csv")));
    EXPECT_EQ(std::count(tables.back().begin(), tables.back().end(), '\n'),
              std::count(tables.front().begin(), tables.front().end(), '\n'));
  }
  EXPECT_NE(tables[0], tables[2]);
  expect_refused("animate stam-17 -o a.csv --dynamics waves", {"--dynamics", "'waves'", "oscillators"});
  expect_refused("animate stam-17 -o a.csv --dynamics time --transfer sampled",
                 {"--transfer", "given with --dynamics time"});
  for (const std::string flag : {"--drag quadratic", "--no-static-correction", "--modes 10"})
    expect_refused("animate stam-17 -o a.csv --dynamics oscillators " + flag,
                   {flag.substr(0, flag.find(' ')), "given with --dynamics oscillators"});
  expect_refused("animate stam-17 -o a.csv --carried-mass",
                 {"--carried-mass", "given with --dynamics modal", "--dynamics oscillators"});
  expect_refused("animate stam-17 -o a.csv --dynamics oscillators --oscillator-modes 9", {"9", "1 to 8"});
  expect_refused("animate " + (test::source_folder() / "examples/frames/pergola.toml").string() +
                     " -o a.csv --dynamics oscillators",
                 {"oscillators: a frame, wanted a tree"});
}

TEST(Usage, OfABeamIsRefusedWhereItsWallIsThickerThanItsRadius) {
  expect_refused("beam --radius 0.01 --wall 0.02", {"--wall: 0.02 m, in a radius of 0.01 m"});
  expect_refused("beam --frequency 2 --youngs-modulus 1e9", {"--frequency", "--youngs-modulus"});
  expect_refused("beam --damping-time 1", {"--damping-time", "--frequency"});
  expect_refused("beam --count 0", {"--count", "0", "1 to "});
}

}  // namespace
}  // namespace tremula
