#include "tremula/io/profile_table.hpp"

#include <gtest/gtest.h>

#include "complaint.hpp"

namespace tremula {
namespace {

std::string complaint_about(const std::string& text) {
  return test::complaint_of([&] { read_profile_table(text, "p.csv"); });
}

TEST(ReadProfileTable, FindsItsColumnsByNameWithTheirUnitsHoweverTheyAreWritten) {
  for (const std::string text :
       {"# measured\nspeed_m_s,gusts,height_m\n4,9,10\n\n6.5,9,40\r\n",
        "Speed [m/s],gusts [m/s],Height [m]\n4,9,10\n6.5,9,40\n", "U (m/s);g;z (m)\n4;9;10\n6.5;9;40\n",
        "U_m/s\tg\theight_m\n4\t9\t10\n6.5\t9\t40\n",
        "\xEF\xBB\xBFspeed [m/s]  g  height [m]\n4 9 10\n6.5 9 40"}) {
    const std::vector<ProfileRow> table = read_profile_table(text, "p.csv");
    ASSERT_EQ(table.size(), 2U) << text;
    EXPECT_EQ(table[0].height, 10);
    EXPECT_EQ(table[0].speed, 4);
    EXPECT_EQ(table[0].turn, 0);
    EXPECT_EQ(table[1].height, 40);
    EXPECT_EQ(table[1].speed, 6.5);
  }
}

TEST(ReadProfileTable, TurnsDirectionsClockwiseAndHeadingsCounterClockwiseByTheShorterWay) {
  const auto turns = [](const std::string& column) {
    std::vector<double> values;
    for (const ProfileRow& row :
         read_profile_table("height_m,speed_m_s," + column + "\n1,1,350\n2,1,5\n3,1,355\n", "p.csv"))
      values.push_back(row.turn);
    return values;
  };
  EXPECT_EQ(turns("direction_deg"), (std::vector<double>{-350, -365, -355}));
  EXPECT_EQ(turns("heading [degrees]"), (std::vector<double>{350, 365, 355}));
}

TEST(ReadProfileTable, SaysWhatIsWrongAndWhere) {
  const std::string header = "height_m,speed_m_s,direction_deg\n";
  EXPECT_EQ(complaint_about(""), "p.csv: 0 rows of a profile, wanted a header and two rows or more");
  EXPECT_EQ(complaint_about(header + "1,1,0\n"),
            "p.csv: 1 row of a profile, wanted a header and two rows or more");
  EXPECT_EQ(
      complaint_about("10,4\n20,5\n"),
      "p.csv:1: 2 columns beginning with 10, wanted a header with height_m, speed_m_s and, where the wind "
      "veers, direction_deg");
  EXPECT_EQ(complaint_about("height,speed_m_s\n1,1\n2,2\n"),
            "p.csv:1: the column height has no unit, wanted height [m]");
  EXPECT_EQ(complaint_about("height_ft,speed_m_s\n1,1\n2,2\n"),
            "p.csv:1: the column height is in ft, wanted height [m]");
  EXPECT_EQ(complaint_about("height_m,speed [km/h]\n1,1\n2,2\n"),
            "p.csv:1: the column speed is in km/h, wanted speed [m/s]");
  EXPECT_EQ(complaint_about("height_m,speed_m_s,direction_rad\n1,1,1\n2,2,1\n"),
            "p.csv:1: the column direction is in rad, wanted direction [deg]");
  EXPECT_EQ(complaint_about("height_m,speed_m_s,direction_deg,heading_deg\n1,1,1,1\n"),
            "p.csv:1: direction and heading, wanted one of them: they turn in opposite senses");
  EXPECT_EQ(complaint_about(header + "1,1\n"), "p.csv:2: 2 columns, wanted 3 as in the header");
  EXPECT_EQ(complaint_about(header + "1,x,0\n"), "p.csv:2: speed is x, wanted a number");
  EXPECT_EQ(complaint_about(header + "1,1,nan\n"), "p.csv:2: direction is nan, wanted a finite number");
  EXPECT_EQ(complaint_about(header + "-1,1,0\n"), "p.csv:2: height is -1, wanted 0 m or more");
  EXPECT_EQ(complaint_about(header + "1,101,0\n"), "p.csv:2: speed is 101, wanted 0 to 100 m/s");
  EXPECT_EQ(complaint_about(header + "2,1,0\n2,1,0\n"),
            "p.csv:3: height is 2, wanted more than the 2 of the row before");
  EXPECT_EQ(complaint_about(std::string("\0\0\0", 3)).substr(0, 8), "p.csv:1:");
}

}  // namespace
}  // namespace tremula
