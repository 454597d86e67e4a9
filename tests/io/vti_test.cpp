#include "tremula/io/vti.hpp"

#include "tremula/io/atomic_file.hpp"

#include <cstring>
#include <filesystem>
#include <limits>
#include <regex>

#include "io/input_files.hpp"

namespace tremula {
namespace {

using test::complaint_of;
using test::TemporaryFolder;

// Every value says where it stands.
WindField numbered_field(const WindGrid& grid) {
  WindField field;
  field.grid = grid;
  for (int t = 0; t < grid.step_count; ++t) {
    for (int i = 0; i < grid.z_count; ++i) {
      for (int j = 0; j < grid.y_count; ++j) {
        for (std::size_t c = 0; c < 3; ++c)
          field.velocity[c].push_back(static_cast<float>(1000 * t + 100 * i + 10 * j) +
                                      static_cast<float>(c));
      }
    }
  }
  return field;
}

const WindGrid grid{.y_count = 3,
                    .z_count = 2,
                    .step_count = 5,
                    .y_spacing = 1.5,
                    .z_spacing = 2.5,
                    .bottom = 4,
                    .step = 0.25,
                    .mean_speed = 8};

std::string attribute(const std::string& text, const std::string& name) {
  std::smatch match;
  return std::regex_search(text, match, std::regex(" " + name + "=\"([^\"]*)\"")) ? match[1].str() : "";
}

TEST(WriteVti, PutsTheFirstStepFurthestDownwind) {
  const TemporaryFolder folder;
  for (const VtiOptions& options : {VtiOptions{}, VtiOptions{.first_step = 1, .step_count = 3}}) {
    const int first = options.first_step, count = options.step_count == 0 ? 5 : options.step_count;
    write_vti(folder / "a.vti", numbered_field(grid), options);
    const std::string bytes = read_file(folder / "a.vti");
    const std::size_t data = bytes.find("encoding=\"raw\">\n_") + 17;
    const std::string head = bytes.substr(0, data);
    EXPECT_EQ(attribute(head, "WholeExtent"), "0 " + std::to_string(count - 1) + " 0 2 0 1");
    EXPECT_EQ(attribute(head, "Extent"), attribute(head, "WholeExtent"));
    EXPECT_EQ(attribute(head, "Origin"), "0 -1.5 4");
    EXPECT_EQ(attribute(head, "Spacing"), "2 1.5 2.5");
    EXPECT_EQ(attribute(head, "NumberOfComponents"), "3");
    std::uint64_t size = 0;
    std::memcpy(&size, &bytes.at(data), 8);
    ASSERT_EQ(size, 4U * 3 * 6 * static_cast<unsigned>(count));
    std::size_t place = data + 8;
    for (int i = 0; i < 2; ++i) {
      for (int j = 0; j < 3; ++j) {
        for (int k = 0; k < count; ++k) {
          for (int c = 0; c < 3; ++c, place += 4) {
            float value = 0;
            std::memcpy(&value, &bytes.at(place), 4);
            const int step = first + count - 1 - k;
            ASSERT_EQ(value, static_cast<float>(1000 * step + 100 * i + 10 * j + c));
          }
        }
      }
    }
    EXPECT_EQ(bytes.substr(place), "\n  </AppendedData>\n</VTKFile>\n");
  }
}

TEST(WriteVti, RefusesStepsThatAreNotThereAndStillAir) {
  const TemporaryFolder folder;
  const auto complaint = [&](const WindField& field, const VtiOptions& options) {
    return complaint_of([&] { write_vti(folder / "a.vti", field, options); });
  };
  const WindField field = numbered_field(grid);
  EXPECT_EQ(complaint(field, {.first_step = 3, .step_count = 3}),
            "steps of the box of wind: 3 from 3, wanted some of the 5 of the field");
  EXPECT_NE(complaint(field, {.first_step = -1}), "");
  EXPECT_NE(complaint(field, {.first_step = 5}), "");
  EXPECT_NE(complaint(field, {.step_count = -1}), "");
  WindField calm = field;
  calm.grid.mean_speed = 0;
  EXPECT_EQ(complaint(calm, {}),
            "mean speed of the wind field: 0.000000, wanted above 0 m/s, to make a box of wind of it");
  EXPECT_TRUE(std::filesystem::is_empty(folder.path));
}

TEST(WriteVti, RefusesAVelocityThatIsNotFiniteAndLeavesNoFile) {
  const TemporaryFolder folder;
  WindField field = numbered_field(grid);
  field.velocity[1][4] = std::numeric_limits<float>::infinity();
  EXPECT_THROW(write_vti(folder / "a.vti", field), Error);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path));
}

}  // namespace
}  // namespace tremula
