// tremula wind and tremula info on wind fields.
#include "cli/program.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

namespace tremula {
namespace {

using nlohmann::json;
using test::contents;
using test::file_count;
using test::Outcome;
using test::run;
using testing::HasSubstr;
using testing::StartsWith;

template <typename T>
void append(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

// A file of 2 x 3 points and a tower of 2, in which a value at step t is the integer 1000 t + 100 c + point;
// the slope is 10, 20, 40, the offset 500. The text is no text.
std::string small_bts(std::int16_t id = 7, int steps = 4) {
  std::string bytes;
  append<std::int16_t>(bytes, id);
  for (const std::int32_t count : {3, 2, 2, steps}) append(bytes, count);
  for (const float number : {2.0F, 1.5F, 0.5F, 6.0F, 10.0F, 4.0F}) append(bytes, number);
  for (const float slope : {10.0F, 20.0F, 40.0F}) {
    append(bytes, slope);
    append(bytes, 500.0F);
  }
  append<std::int32_t>(bytes, 3);
  bytes += "a\n\xFF";
  for (int t = 0; t < steps; ++t)
    for (int p = 0; p < 8; ++p)
      for (int c = 0; c < 3; ++c) append(bytes, static_cast<std::int16_t>(1000 * (t % 4) + 100 * c + p));
  return bytes;
}

void write(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

TEST(InfoOfAWindField, SaysAsJsonWhatWasRead) {
  const test::TemporaryFolder folder;
  write(folder / "a.bts", small_bts());
  const Outcome outcome = run(folder, "info a.bts --format json");
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  const json info = json::parse(outcome.output);
  EXPECT_EQ(info.at("format"), "turbsim-bts");
  EXPECT_EQ(info.at("id"), 7);
  EXPECT_EQ(info.at("text"), "a??");
  EXPECT_EQ(info.at("periodic"), false);
  EXPECT_EQ(info.at("points"), (json{{"y", 2}, {"z", 3}}));
  EXPECT_EQ(info.at("spacing_m"), (json{{"y", 1.5}, {"z", 2.0}}));
  EXPECT_EQ(info.at("steps"), 4);
  EXPECT_EQ(info.at("step_s"), 0.5);
  EXPECT_EQ(info.at("period_s"), 2);
  EXPECT_EQ(info.at("mean_speed_m_s"), 6);
  EXPECT_EQ(info.at("reference_height_m"), 10);
  EXPECT_EQ(info.at("slope"), (json{10, 20, 40}));
  EXPECT_EQ(info.at("y_m"), (json{-0.75, 0.75}));
  EXPECT_EQ(info.at("z_m"), (json{4, 6, 8}));
  EXPECT_EQ(info.at("tower").at("z_m"), (json{4, 2}));
  const double slopes[] = {10, 20, 40};
  for (int c = 0; c < 3; ++c) {
    const std::string name(1, "uvw"[c]);
    // Over t the integers are 1000 (0, 1, 2, 3) and the rest: mean 1500, deviation 1000 sqrt(1.25).
    const auto mean = [&](int point) { return (1500 + 100 * c + point - 500) / slopes[c]; };
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 2; ++j) {
        EXPECT_NEAR(info.at("mean_m_s").at(name).at(i).at(j), mean(static_cast<int>(2 * i + j)), 1e-5);
        EXPECT_NEAR(info.at("deviation_m_s").at(name).at(i).at(j), 1000 * std::sqrt(1.25) / slopes[c], 1e-5);
      }
    }
    for (std::size_t k = 0; k < 2; ++k) {
      EXPECT_NEAR(info.at("tower").at("mean_m_s").at(name).at(k), mean(6 + static_cast<int>(k)), 1e-5);
      EXPECT_NEAR(info.at("tower").at("deviation_m_s").at(name).at(k), 1000 * std::sqrt(1.25) / slopes[c],
                  1e-5);
    }
  }
}

TEST(InfoOfAWindField, IsATableByHeightFromTheTopDown) {
  const test::TemporaryFolder folder;
  write(folder / "a.BTS", small_bts(8));
  const Outcome outcome = run(folder, "info a.BTS");
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  EXPECT_THAT(outcome.output, HasSubstr("(id 8, periodic)"));
  EXPECT_THAT(outcome.output, HasSubstr("2 x 3 points"));
  const std::size_t top = outcome.output.find("     8.000   100.450"),
                    lowest = outcome.output.find("     4.000   100.050"),
                    tower = outcome.output.find("     2.000   100.700");
  ASSERT_NE(top, std::string::npos) << outcome.output;
  EXPECT_LT(top, lowest);
  EXPECT_LT(lowest, tower);
  EXPECT_NE(tower, std::string::npos) << outcome.output;
}

TEST(Wind, ChecksAndRewritesAField) {
  const test::TemporaryFolder folder;
  write(folder / "a.bts", small_bts(8, 64));
  const Outcome outcome =
      run(folder, "wind a.bts -o b.bts -o b.vti --report r.json --plot r.svg --separations 2,1 --bands 1000");
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  EXPECT_EQ(outcome.output, "");
  for (const std::string name : {"b.bts", "b.vti", "r.json", "r.svg"})
    EXPECT_THAT(outcome.messages, HasSubstr("tremula: wrote " + name));
  EXPECT_EQ(file_count(folder), 5U);
  EXPECT_THAT(contents(folder / "b.vti"), HasSubstr("WholeExtent=\"0 63 0 1 0 2\""));
  EXPECT_THAT(contents(folder / "r.svg"), HasSubstr("<title>a</title>"));

  const json report = json::parse(contents(folder / "r.json"));
  EXPECT_EQ(report.at("grid").at("steps"), 64);
  ASSERT_EQ(report.at("rows").size(), 3U);
  EXPECT_NEAR(report.at("rows").at(1).at("mean_m_s").at("u"), 100.25, 1e-4);
  EXPECT_NEAR(report.at("rows").at(1).at("deviation_m_s").at("v"), 50 * std::sqrt(1.25), 1e-4);
  ASSERT_EQ(report.at("bands").size(), 31U);
  ASSERT_EQ(report.at("spectra").size(), 9U);
  // A sawtooth of period 4 has one line below the Nyquist frequency, at bin 16: 0.5 Hz. Its amplitude is
  // |sum over t of t i^t| * 2/4 = sqrt(2) thousands, its variance 1, and the band 1/32 Hz.
  const json& u = report.at("spectra").at(0);
  EXPECT_EQ(u.at("component"), "u");
  EXPECT_EQ(report.at("bands").at(15).at("frequency_hz"), 0.5);
  for (std::size_t b = 0; b < 31; ++b)
    EXPECT_NEAR(u.at("measured_m2_s2_per_hz").at(b), b == 15 ? 32 * 1e4 : 0, 1) << b;
  ASSERT_EQ(report.at("coherence").size(), 9U);  // 1 across, 1 and 2 upward; u, v, w
  EXPECT_NEAR(report.at("coherence").at(0).at("measured_root").at(15), 1, 1e-5);

  // What was written is read as what was read.
  const Outcome before = run(folder, "info a.bts --format json"),
                after = run(folder, "info b.bts --format json");
  const json a = json::parse(before.output), b = json::parse(after.output);
  EXPECT_EQ(a.at("tower").at("z_m"), b.at("tower").at("z_m"));
  for (const std::string name : {"u", "v", "w"}) {
    EXPECT_NEAR(a.at("mean_m_s").at(name).at(2).at(1), b.at("mean_m_s").at(name).at(2).at(1), 3e-3);
    EXPECT_NEAR(a.at("tower").at("mean_m_s").at(name).at(1), b.at("tower").at("mean_m_s").at(name).at(1),
                3e-3);
  }
}

TEST(Wind, RefusesInOneLineAndLeavesNoFile) {
  const auto expect_refused = [](const std::string& arguments, const std::string& bytes,
                                 const std::string& part) {
    const test::TemporaryFolder folder;
    write(folder / "a.bts", bytes);
    const Outcome outcome = run(folder, arguments);
    EXPECT_EQ(outcome.code, 2) << arguments;
    EXPECT_THAT(outcome.messages, StartsWith("tremula: error: ")) << arguments;
    EXPECT_THAT(outcome.messages, HasSubstr(part)) << arguments;
    EXPECT_EQ(std::count(outcome.messages.begin(), outcome.messages.end(), '\n'), 1) << outcome.messages;
    EXPECT_EQ(outcome.output, "");
    EXPECT_EQ(file_count(folder), 1U) << arguments;
  };
  const std::string good = small_bts();
  expect_refused("wind a.bts", good, "no output, wanted --report");
  expect_refused("wind a.bts -o b.wav", good, "'.wav', wanted .bts (TurbSim)");
  expect_refused("wind a.bts --plot b.png", good, "'.png', wanted .svg");
  expect_refused("wind b.bts --report r.json", good, "b.bts: cannot be opened");
  expect_refused("wind a.bts -o b.bts --report r.json --bands 0", good,
                 "bands per decade: 0.000000, wanted 1 to 1000");
  expect_refused("wind a.bts --plot r.svg --separations 0", good,
                 "separation across: 0 cells, wanted 1 or more");
  expect_refused("wind a.bts --report r.json", good.substr(0, 100), "a.bts: 100 bytes, wanted 265");
  expect_refused("info a.bts", "tree", "a.bts: kind of file (byte 0)");
}

}  // namespace
}  // namespace tremula
