#include "tremula/io/spectrum_table.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "complaint.hpp"
#include "support.hpp"

namespace tremula {
namespace {

std::string complaint_about(const std::string& text) {
  return test::complaint_of([&] { read_spectrum_table(text, "s.csv"); });
}

TEST(ReadSpectrumTable, FindsItsColumnsByNameAndPassesOverOthers) {
  const SpectrumTable table = read_spectrum_table(
      "# measured\nS_w,comment,frequency,S_u,S_v\n1,5,0.01,3,2\n\n0.5;6;0.02;2;1\r\n", "s.csv");
  EXPECT_FALSE(table.by_wave_number);
  EXPECT_EQ(table.at, (std::vector<double>{0.01, 0.02}));
  EXPECT_EQ(table.values, (std::vector<Vec3>{{3, 2, 1}, {2, 1, 0.5}}));
  EXPECT_TRUE(read_spectrum_table("k1_rad_per_m Fu Fv Fw\n1 1 1 1\n2 1 1 1\n", "s.csv").by_wave_number);
}

TEST(ReadSpectrumTable, SaysWhatIsWrongAndWhere) {
  const std::string header = "frequency,S_u,S_v,S_w\n";
  EXPECT_EQ(complaint_about(""), "s.csv: 0 rows of a spectrum, wanted a header and two rows or more");
  EXPECT_EQ(complaint_about(header + "1,1,1,1\n"),
            "s.csv: 1 row of a spectrum, wanted a header and two rows or more");
  EXPECT_EQ(
      complaint_about("1,2,3,4\n"),
      "s.csv:1: 4 columns beginning with 1, wanted a header with frequency S_u S_v S_w, or with k1_rad_per_m "
      "Fu Fv Fw");
  EXPECT_EQ(complaint_about(header + "1,1,1\n"), "s.csv:2: 3 columns, wanted 4 as in the header");
  EXPECT_EQ(complaint_about(header + "1,1,x,1\n"), "s.csv:2: S_v is x, wanted a number");
  EXPECT_EQ(complaint_about(header + "1,1,1,0\n"), "s.csv:2: S_w is 0, wanted a number above 0");
  EXPECT_EQ(complaint_about(header + "1,nan,1,1\n"), "s.csv:2: S_u is nan, wanted a finite number");
  EXPECT_EQ(complaint_about(header + "2,1,1,1\n2,1,1,1\n"),
            "s.csv:3: frequency is 2, wanted more than the 2 of the row before");
  EXPECT_EQ(complaint_about(std::string("\0\0\0", 3)).substr(0, 8), "s.csv:1:");
}

TEST(ReadSpectrumTable, OfTheGreatBeltHasMoreVarianceAlongTheWindThanUpAndFallsAsTurbulenceDoes) {
  TREMULA_NEED_DATA("wind/great_belt_spectra.csv");
  const SpectrumModel model =
      table_spectrum(read_spectrum_table((test::data_folder() / "wind/great_belt_spectra.csv").string()));
  EXPECT_TRUE(model.table.by_wave_number);
  const Vec3 variance = spectrum_variance(model);
  EXPECT_GT(variance[0], variance[1]);
  EXPECT_GT(variance[1], variance[2]);
  // Wave numbers pass faster in more wind: f S(f) is the same at the same f/U.
  const Vec3 slow = 0.02 * spectrum(model, 0.02, 70, 10), fast = 0.04 * spectrum(model, 0.04, 70, 20);
  EXPECT_LT((slow - fast).norm() / slow.norm(), 1e-12);
  // k1 of the middle of the table, by hand: S(f) df = F(k1) dk1.
  const std::size_t row = model.table.at.size() / 2;
  const double k1 = model.table.at[row], f = k1 * 15 / (2 * M_PI);
  EXPECT_NEAR(f * spectrum(model, f, 70, 15)[0] / (k1 * model.table.values[row][0]), 1, 1e-9);
}

}  // namespace
}  // namespace tremula
