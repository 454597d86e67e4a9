#include "tremula/io/gauge_table.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "tremula/base/error.hpp"

namespace tremula {
namespace {

GaugeSeries series(const std::string& name, double offset) {
  const auto column = [&](double first) -> Eigen::VectorXd {
    return Eigen::VectorXd::LinSpaced(4, first, first + 3) / 3 + Eigen::VectorXd::Constant(4, offset);
  };
  return {name, 2, column(10), column(20), column(-30), column(40), column(-50), column(60), column(70)};
}

TEST(EncodeGaugeTable, GivesBackEveryNumberOfEveryGaugeFrameByFrame) {
  const std::vector<GaugeSeries> gauges{series("base", 0), series("stem:1.3", 0.1)};
  const std::vector<int> frames{0, 3, 4};
  std::istringstream text(encode_gauge_table(gauges, frames));
  std::string line;
  std::getline(text, line);
  EXPECT_EQ(line,
            "frame,time_s,gauge,bending_moment_n_m,along_n_m,across_n_m,shear_n,axial_n,torsion_n_m,strain");
  for (const int frame : frames) {
    for (const GaugeSeries& gauge : gauges) {
      ASSERT_TRUE(std::getline(text, line));
      std::istringstream row(line);
      std::vector<std::string> fields;
      for (std::string field; std::getline(row, field, ',');) fields.push_back(field);
      ASSERT_EQ(fields.size(), 10U);
      EXPECT_EQ(fields[0], std::to_string(frame));
      EXPECT_EQ(std::stod(fields[1]), frame * 0.5);
      EXPECT_EQ(fields[2], gauge.gauge);
      const Eigen::Index p = frame % 4;
      const double wanted[] = {gauge.bending_moment[p], gauge.along_wind[p], gauge.across_wind[p],
                               gauge.shear[p],          gauge.axial[p],      gauge.torsion[p],
                               gauge.strain[p]};
      for (std::size_t i = 0; i < 7; ++i) EXPECT_EQ(std::stod(fields[3 + i]), wanted[i]);
    }
  }
  EXPECT_FALSE(std::getline(text, line));
}

TEST(EncodeGaugeTable, RefusesFramesOutsideTheLoopAndSeriesThatDoNotAgree) {
  const auto encode = [&](std::vector<GaugeSeries> gauges, int frame) {
    const std::vector<int> one{frame};
    return encode_gauge_table(gauges, one);
  };
  EXPECT_THROW(encode({}, 0), InputError);
  EXPECT_THROW(encode({series("base", 0)}, -1), InputError);
  EXPECT_THROW(encode({series("base", 0)}, 5), InputError);
  EXPECT_THROW(encode({series("a,b", 0)}, 0), InputError);
  GaugeSeries shorter = series("base", 0), longer = series("base", 0), broken = series("base", 0);
  shorter.shear.conservativeResize(3);
  longer.period = 3;
  broken.strain[2] = std::nan("");
  EXPECT_THROW(encode({shorter}, 0), InputError);
  EXPECT_THROW(encode({series("base", 0), longer}, 0), InputError);
  EXPECT_THROW(encode({broken}, 0), Error);
}

}  // namespace
}  // namespace tremula
