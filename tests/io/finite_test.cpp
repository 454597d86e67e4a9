#include "tremula/io/finite.hpp"

#include <gmock/gmock.h>

#include <array>
#include <limits>

#include "complaint.hpp"
#include "tremula/base/error.hpp"
#include "tremula/io/svg.hpp"

namespace tremula {
namespace {

using testing::HasSubstr;

template <class Numbers>
std::string complaint(const Numbers& numbers) {
  return test::complaint_of<Error>([&] { check_finite("masses", numbers); });
}

constexpr double nan = std::numeric_limits<double>::quiet_NaN(),
                 inf = std::numeric_limits<double>::infinity();

TEST(CheckFinite, SaysWhatAndWhichNumberIsNotFinite) {
  EXPECT_EQ(complaint(std::vector<double>{1, -1e308, 0}), "");
  EXPECT_EQ(complaint(std::vector<double>{}), "");
  EXPECT_THAT(complaint(std::vector<double>{1, nan, 0}), HasSubstr("masses: number 2 of 3 is nan"));
  EXPECT_THAT(complaint(std::vector<double>{1, 2, -inf}), HasSubstr("masses: number 3 of 3 is -inf"));
  EXPECT_THAT(complaint(std::vector<float>{std::numeric_limits<float>::infinity()}),
              HasSubstr("masses: number 1 of 1 is inf"));
  EXPECT_THAT(
      complaint(std::vector<Eigen::Vector3f>{{1, 2, 3}, {4, std::numeric_limits<float>::quiet_NaN(), 6}}),
      HasSubstr("masses: number 5 of 6 is nan"));
  EXPECT_THAT(complaint(Eigen::VectorXd(Eigen::Vector2d(1, inf))), HasSubstr("masses: number 2 of 2 is inf"));
  EXPECT_THAT(complaint(nan), HasSubstr("masses: nan"));
}

TEST(CheckFinite, StandsAtTheDoorOfPictures) {
  EXPECT_THROW(svg_text(nan, 0, "here"), Error);
  EXPECT_THROW(svg_lines({{Eigen::Vector2d(0, 0), Eigen::Vector2d(1, inf)}}, "#000", 1), Error);
}

}  // namespace
}  // namespace tremula
