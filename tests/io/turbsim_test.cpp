#include "tremula/io/turbsim.hpp"

#include "tremula/io/atomic_file.hpp"
#include "tremula/numerics/random.hpp"

#include <cmath>
#include <cstring>
#include <limits>

#include "io/input_files.hpp"

namespace tremula {
namespace {

using test::complaint_of;
using test::TemporaryFolder;

double random_number(std::uint64_t place) { return uniform({7, RandomStream::test, 0, place}); }

WindField random_field(int y_count, int z_count, int step_count, int tower_count, bool periodic = true) {
  WindField field;
  field.grid = {.y_count = y_count,
                .z_count = z_count,
                .step_count = step_count,
                .y_spacing = 2.5,
                .z_spacing = 1.25,
                .bottom = 3.5,
                .step = 0.125,
                .mean_speed = 8.5,
                .reference_height = 10.25,
                .periodic = periodic};
  field.tower_count = tower_count;
  std::uint64_t place = 0;
  const double mean[] = {8, 0, -0.5}, width[] = {9, 4, 1};
  for (std::size_t c = 0; c < 3; ++c) {
    field.velocity[c].resize(field.grid.point_count() * static_cast<std::size_t>(step_count));
    field.tower[c].resize(static_cast<std::size_t>(tower_count * step_count));
    for (auto* values : {&field.velocity[c], &field.tower[c]}) {
      for (float& value : *values)
        value = static_cast<float>(mean[c] + width[c] * (random_number(place++) - 0.5));
    }
  }
  return field;
}

// The number that stands at a byte of a file.
template <typename T>
T at(const std::string& bytes, std::size_t place) {
  T value;
  std::memcpy(&value, bytes.data() + place, sizeof value);
  return value;
}

template <typename T>
std::string with(std::string bytes, std::size_t place, T value) {
  return bytes.replace(place, sizeof value, reinterpret_cast<const char*>(&value), sizeof value);
}

std::string written(const WindField& field, std::string_view text = "made for a test") {
  const TemporaryFolder folder;
  write_turbsim(folder / "a.bts", field, text);
  return read_file(folder / "a.bts");
}

// ---- Files that TurbSim wrote

class FileOfTurbSim : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Data, FileOfTurbSim,
                         testing::Values("wind/tree15_11x11x2048.bts", "wind/nonper_tower_5x5.bts"));

TEST_P(FileOfTurbSim, IsReadToTheLastBitAndWrittenBackByteForByte) {
  TREMULA_NEED_DATA(GetParam());
  const std::string path = (test::data_folder() / GetParam()).string(), bytes = read_file(path);
  const TurbSimFile file = read_turbsim(path);
  const WindField field = wind_field(file);
  const WindGrid& grid = field.grid;

  // The layout once more, byte by byte.
  EXPECT_EQ(file.periodic, at<std::int16_t>(bytes, 0) == 8);
  const std::int32_t nz = at<std::int32_t>(bytes, 2), ny = at<std::int32_t>(bytes, 6),
                     towers = at<std::int32_t>(bytes, 10), steps = at<std::int32_t>(bytes, 14);
  ASSERT_EQ(grid.z_count, nz);
  ASSERT_EQ(grid.y_count, ny);
  ASSERT_EQ(field.tower_count, towers);
  ASSERT_EQ(grid.step_count, steps);
  EXPECT_EQ(grid.z_spacing, static_cast<double>(at<float>(bytes, 18)));
  EXPECT_EQ(grid.y_spacing, static_cast<double>(at<float>(bytes, 22)));
  EXPECT_EQ(grid.step, static_cast<double>(at<float>(bytes, 26)));
  EXPECT_EQ(grid.mean_speed, static_cast<double>(at<float>(bytes, 30)));
  EXPECT_EQ(grid.reference_height, static_cast<double>(at<float>(bytes, 34)));
  EXPECT_EQ(grid.bottom, static_cast<double>(at<float>(bytes, 38)));
  std::size_t place = 70 + static_cast<std::size_t>(at<std::int32_t>(bytes, 66));
  std::size_t wrong = 0;
  for (std::int32_t t = 0; t < steps; ++t) {
    for (std::int32_t p = 0; p < nz * ny + towers; ++p) {
      for (std::size_t c = 0; c < 3; ++c, place += 2) {
        const auto slope = static_cast<double>(at<float>(bytes, 42 + 8 * c)),
                   offset = static_cast<double>(at<float>(bytes, 46 + 8 * c));
        const auto wanted = static_cast<float>((at<std::int16_t>(bytes, place) - offset) / slope);
        const float found = p < nz * ny ? field.velocity[c][static_cast<std::size_t>(t * nz * ny + p)]
                                        : field.tower[c][static_cast<std::size_t>(t * towers + p - nz * ny)];
        wrong += std::memcmp(&wanted, &found, 4) != 0;
      }
    }
  }
  EXPECT_EQ(place, bytes.size());
  EXPECT_EQ(wrong, 0U);

  const TemporaryFolder folder;
  write_turbsim(folder / "copy.bts", file);
  EXPECT_EQ(read_file(folder / "copy.bts"), bytes);
}

// TurbSim chose the scales from the range of each component, so ours, from the same velocities, are its own
// up to the rounding of single precision, and so are the integers but for the few on a boundary between two.
TEST_P(FileOfTurbSim, IsScaledByUsAsTurbSimScaledIt) {
  TREMULA_NEED_DATA(GetParam());
  const TurbSimFile theirs = read_turbsim((test::data_folder() / GetParam()).string());
  const TemporaryFolder folder;
  write_turbsim(folder / "ours.bts", wind_field(theirs), theirs.text);
  const TurbSimFile ours = read_turbsim(folder / "ours.bts");
  EXPECT_EQ(ours.text, theirs.text);
  ASSERT_EQ(ours.values.size(), theirs.values.size());
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(ours.slope[c] / theirs.slope[c], 1, 1e-6);
    EXPECT_NEAR(ours.offset[c], theirs.offset[c], 0.1F);
  }
  int largest = 0;
  for (std::size_t i = 0; i < ours.values.size(); ++i)
    largest = std::max(largest, std::abs(ours.values[i] - theirs.values[i]));
  EXPECT_LE(largest, 1);
}

// TurbSim gives the point at the middle of the lowest row twice: in the grid and as the first of the tower.
TEST(WindFieldOfTurbSim, HasATowerThatBeginsAtTheLowestRow) {
  TREMULA_NEED_DATA("wind/nonper_tower_5x5.bts");
  const TurbSimFile file = read_turbsim((test::data_folder() / "wind/nonper_tower_5x5.bts").string());
  const WindField field = wind_field(file);
  ASSERT_EQ(file.tower_count, 3);
  EXPECT_EQ(file.tower_height(0), field.grid.z(0));
  EXPECT_EQ(file.tower_height(2), field.grid.z(0) - 2 * field.grid.z_spacing);
  for (std::size_t t = 0; t < static_cast<std::size_t>(file.step_count); ++t)
    ASSERT_EQ(field.tower[0][3 * t], field.velocity[0][25 * t + 2]) << "step " << t;
}

// ---- Files that we wrote

TEST(WriteTurbSim, KeepsEveryValueWithinHalfAStepOfItsScale) {
  for (const int towers : {0, 1, 70}) {
    for (const bool periodic : {true, false}) {
      const WindField field = random_field(3, 4, 2500, towers, periodic);
      const TurbSimFile file = parse_turbsim(written(field), "a");
      const WindField back = wind_field(file);
      EXPECT_EQ(file.text, "made for a test");
      EXPECT_EQ(back.grid.periodic, periodic);
      EXPECT_EQ(back.grid.y_count, 3);
      EXPECT_EQ(back.grid.z_count, 4);
      EXPECT_EQ(back.grid.y_spacing, 2.5);
      EXPECT_EQ(back.grid.z_spacing, 1.25);
      EXPECT_EQ(back.grid.bottom, 3.5);
      EXPECT_EQ(back.grid.step, 0.125);
      EXPECT_EQ(back.grid.mean_speed, 8.5);
      EXPECT_EQ(back.grid.reference_height, 10.25);
      ASSERT_EQ(back.tower_count, towers);
      for (std::size_t c = 0; c < 3; ++c) {
        // Speeds are below 16 m/s, where single precision rounds by 2^-21 m/s: on the way there and back.
        const float half = 0.5F / file.slope[c] + std::ldexp(2.0F, -21);
        const auto worst = [](const std::vector<float>& a, const std::vector<float>& b) {
          float largest = 0;
          for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b.at(i)));
          return largest;
        };
        EXPECT_LE(worst(field.velocity[c], back.velocity[c]), half);
        EXPECT_LE(worst(field.tower[c], back.tower[c]), half);
        EXPECT_GT(worst(field.velocity[c], back.velocity[c]), half / 2);
      }
    }
  }
}

TEST(WriteTurbSim, UsesAllSixteenBits) {
  const TurbSimFile file = parse_turbsim(written(random_field(5, 2, 300, 2)), "a");
  for (std::size_t c = 0; c < 3; ++c) {
    int low = 0, high = 0;
    for (std::size_t i = c; i < file.values.size(); i += 3) {
      low = std::min<int>(low, file.values[i]);
      high = std::max<int>(high, file.values[i]);
    }
    EXPECT_EQ(low, -32768);
    EXPECT_EQ(high, 32767);
  }
}

TEST(WriteTurbSim, KeepsAConstantComponentExactly) {
  for (const float constant : {0.0F, 3.3F, -1e-30F, 7e8F}) {
    WindField field = random_field(2, 2, 10, 1);
    for (auto* values : {&field.velocity[1], &field.tower[1]})
      for (float& value : *values) value = constant;
    const WindField back = wind_field(parse_turbsim(written(field), "a"));
    EXPECT_EQ(back.velocity[1], field.velocity[1]);
    EXPECT_EQ(back.tower[1], field.tower[1]);
  }
}

// A breath around a gale: the scale is finer than single precision resolves the values.
TEST(WriteTurbSim, KeepsWhatSinglePrecisionHoldsOfATinyRange) {
  WindField field = random_field(2, 2, 100, 0);
  for (std::size_t i = 0; i < field.velocity[0].size(); ++i)
    field.velocity[0][i] = 50 + 4e-6F * static_cast<float>(i % 7);
  for (std::size_t i = 0; i < field.velocity[2].size(); ++i)
    field.velocity[2][i] = 1e-38F * static_cast<float>(i % 3);
  const WindField back = wind_field(parse_turbsim(written(field), "a"));
  for (std::size_t i = 0; i < field.velocity[0].size(); ++i) {
    EXPECT_NEAR(back.velocity[0][i], field.velocity[0][i], 8e-6F);
    EXPECT_NEAR(back.velocity[2][i], field.velocity[2][i], 1e-12F);
  }
}

TEST(WriteTurbSim, WritesAFieldOfOnePointAndOneStep) {
  WindField field = random_field(1, 1, 1, 0);
  field.grid.y_spacing = field.grid.z_spacing = 0;
  const WindField back = wind_field(parse_turbsim(written(field), "a"));
  for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(back.velocity[c], field.velocity[c]);
}

TEST(WriteTurbSim, CutsAnEndlessText) {
  const std::string text(20'000, 'x');
  EXPECT_EQ(parse_turbsim(written(random_field(2, 2, 3, 0), text), "a").text, text.substr(0, 10'000));
}

TEST(WriteTurbSim, RefusesWhatIsNoFieldAndLeavesNoFile) {
  const TemporaryFolder folder;
  const auto complaint = [&](auto damage) {
    WindField field = random_field(2, 3, 4, 1);
    damage(field);
    return complaint_of([&] { write_turbsim(folder / "a.bts", field); });
  };
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  EXPECT_EQ(complaint([&](WindField& field) { field.velocity[0][7] = nan; }),
            "wind field: u: nan, wanted finite values of at most 1e+09 m/s");
  EXPECT_EQ(complaint([&](WindField& field) { field.velocity[1][7] = -nan; }),
            "wind field: v: -nan, wanted finite values of at most 1e+09 m/s");
  EXPECT_EQ(complaint([&](WindField& field) { field.tower[2][3] = -inf; }),
            "wind field: w: -inf, wanted finite values of at most 1e+09 m/s");
  EXPECT_EQ(complaint([&](WindField& field) { field.velocity[2][0] = 2e9F; }),
            "wind field: w: 2e+09, wanted finite values of at most 1e+09 m/s");
  EXPECT_EQ(complaint([&](WindField& field) { field.velocity[2].pop_back(); }),
            "wind field: velocity: 23 values, wanted 24 for 6 points and 4 steps");
  EXPECT_EQ(complaint([&](WindField& field) { field.tower[1].clear(); }),
            "wind field: tower: 0 values, wanted 4 for 1 points and 4 steps");
  EXPECT_EQ(complaint([&](WindField& field) { field.grid.step_count = 0; }),
            "wind field: steps: 0, wanted 1 or more");
  EXPECT_EQ(complaint([&](WindField& field) { field.grid.step = 0; }),
            "wind field: step: 0, wanted a time above 0 s");
  EXPECT_TRUE(std::filesystem::is_empty(folder.path));
}

// ---- Bad files

std::string complaint_about(const std::string& bytes) {
  return complaint_of([&] { parse_turbsim(bytes, "a.bts"); });
}

TEST(ParseTurbSim, NamesTheFieldOfTheHeaderThatIsWrong) {
  const std::string good = written(random_field(2, 3, 4, 1));
  ASSERT_EQ(complaint_about(good), "");
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  EXPECT_EQ(complaint_about(""), "a.bts: 0 bytes, wanted the 70 with which a TurbSim file begins");
  EXPECT_EQ(complaint_about(good.substr(0, 69)),
            "a.bts: 69 bytes, wanted the 70 with which a TurbSim file begins");
  EXPECT_EQ(complaint_about(with<std::int16_t>(good, 0, -99)),
            "a.bts: kind of file (byte 0): -99, wanted 7 (TurbSim, one run) or 8 (TurbSim, periodic)");
  EXPECT_EQ(complaint_about(with<std::int32_t>(good, 2, 0)), "a.bts: rows (byte 2): 0, wanted 1 or more");
  EXPECT_EQ(complaint_about(with<std::int32_t>(good, 6, -5)),
            "a.bts: points across (byte 6): -5, wanted 1 or more");
  EXPECT_EQ(complaint_about(with<std::int32_t>(good, 10, -1)),
            "a.bts: points of the tower (byte 10): -1, wanted 0 or more");
  EXPECT_EQ(complaint_about(with<std::int32_t>(good, 14, 0)), "a.bts: steps (byte 14): 0, wanted 1 or more");
  EXPECT_EQ(complaint_about(with<float>(good, 18, 0)),
            "a.bts: spacing of the rows (byte 18): 0, wanted a number above 0");
  EXPECT_EQ(complaint_about(with<float>(good, 22, -2.5F)),
            "a.bts: spacing across (byte 22): -2.5, wanted a number above 0");
  EXPECT_EQ(complaint_about(with<float>(good, 26, nan)),
            "a.bts: step (byte 26): nan, wanted a finite number");
  EXPECT_EQ(complaint_about(with<float>(good, 30, -1)),
            "a.bts: mean speed at hub height (byte 30): -1, wanted 0 or more");
  EXPECT_EQ(complaint_about(with<float>(good, 34, inf)),
            "a.bts: hub height (byte 34): inf, wanted a finite number");
  EXPECT_EQ(complaint_about(with<float>(good, 38, 2e9F)),
            "a.bts: height of the lowest row (byte 38): 2e+09, wanted at most 1e+09");
  EXPECT_EQ(complaint_about(with<float>(good, 50, 0)),
            "a.bts: slope of v (byte 50): 0, wanted a number other than 0");
  EXPECT_EQ(complaint_about(with<float>(good, 62, -inf)),
            "a.bts: offset of w (byte 62): -inf, wanted a finite number");
  EXPECT_EQ(complaint_about(with<float>(with<float>(good, 58, 1e-30F), 62, 0)),
            "a.bts: slope and offset of w (byte 58): speeds up to 3.27679999e+34 m/s, wanted at most 1e+09");
  EXPECT_EQ(complaint_about(with<std::int32_t>(good, 66, -1)),
            "a.bts: length of the text (byte 66): -1, wanted 0 or more");
  EXPECT_EQ(complaint_about(with<std::int32_t>(good, 66, 1 << 30)),
            "a.bts: length of the text (byte 66): 1073741824, wanted at most 10000");
}

TEST(ParseTurbSim, RefusesAFileThatIsNotExactlyAsLongAsItsCountsSay) {
  const std::string good = written(random_field(2, 3, 4, 1));
  const std::string size = std::to_string(good.size());
  const std::string wanted =
      "wanted " + size + " for 3 x 2 grid and 1 tower points, 4 steps and a text of 15";
  ASSERT_EQ(good.size(), 70U + 15 + 4 * 7 * 3 * 2);
  for (std::size_t length = 70; length < good.size(); ++length) {
    EXPECT_EQ(complaint_about(good.substr(0, length)),
              "a.bts: " + std::to_string(length) + " bytes, " + wanted);
  }
  EXPECT_EQ(complaint_about(good + "x"), "a.bts: " + std::to_string(good.size() + 1) + " bytes, " + wanted);
  EXPECT_EQ(complaint_about(with<std::int32_t>(good, 14, 5)),
            "a.bts: " + size + " bytes, wanted " + std::to_string(good.size() + 42) +
                " for 3 x 2 grid and 1 tower points, 5 steps and a text of 15");
}

TEST(ParseTurbSim, DoesNotOverflowWhereTheProductOfTheCountsDoes) {
  const std::string good = written(random_field(2, 3, 4, 0));
  constexpr std::int32_t most = std::numeric_limits<std::int32_t>::max();
  std::string bytes = good;
  for (const std::size_t place : {2, 6, 10, 14}) bytes = with(bytes, place, most);
  EXPECT_NE(complaint_about(bytes).find("wanted 5.94211"), std::string::npos) << complaint_about(bytes);
  // Products that are 0 or the true size modulo 2^32 and 2^64.
  for (const std::int32_t rows : {1 << 30, 1 << 16, (1 << 30) + 3}) {
    for (const std::int32_t across : {1 << 30, 1 << 16, 2}) {
      for (const std::int32_t steps : {1 << 30, 1 << 2, 4}) {
        const std::string absurd = with(with(with(good, 2, rows), 6, across), 14, steps);
        EXPECT_NE(complaint_about(absurd), "") << rows << ' ' << across << ' ' << steps;
      }
    }
  }
}

// Whatever bytes come: a field in which every number is finite, or one line.
TEST(ParseTurbSim, SurvivesAnyDamage) {
  const std::string good = written(random_field(3, 3, 5, 2));
  int read = 0, refused = 0;
  for (std::uint64_t trial = 0; trial < 4000; ++trial) {
    std::string bytes = good;
    const auto random = [&](std::uint64_t what, std::size_t below) {
      const double number = uniform({trial, RandomStream::test, 1, what});
      return static_cast<std::size_t>(number * static_cast<double>(below));
    };
    const std::size_t hits = 1 + random(0, 3);
    for (std::size_t hit = 0; hit < hits; ++hit) {
      const std::size_t place = random(10 * hit + 1, 90);
      const char values[] = {0, 1, -1, 127, static_cast<char>(random(10 * hit + 2, 256))};
      bytes[place] = values[random(10 * hit + 3, 5)];
    }
    if (random(4, 4) == 0) bytes.resize(random(5, bytes.size() + 1));
    const std::string complaint = complaint_of([&] {
      const WindField field = wind_field(parse_turbsim(bytes, "a.bts"));
      for (const auto& values : field.velocity)
        for (const float value : values) ASSERT_TRUE(std::isfinite(value)) << "trial " << trial;
    });
    complaint.empty() ? ++read : ++refused;
    if (!complaint.empty()) {
      EXPECT_TRUE(complaint.starts_with("a.bts: ")) << complaint;
      EXPECT_NE(complaint.find(", wanted "), std::string::npos) << complaint;
      EXPECT_EQ(complaint.find('\n'), std::string::npos) << complaint;
    }
  }
  EXPECT_GT(read, 500);
  EXPECT_GT(refused, 500);
}

}  // namespace
}  // namespace tremula
