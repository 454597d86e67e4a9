#include "tremula/io/gust_table.hpp"

#include <gtest/gtest.h>

#include "complaint.hpp"

namespace tremula {
namespace {

TEST(ReadGustTable, FindsItsColumnsByNameWhateverStandsBetweenThem) {
  for (const std::string text :
       {"# squall\ntime_s,speed_m_s,heading_deg\n0,4,10\n2.5,9,-20\r\n",
        "time;note;heading;speed\n0;a;10;4\n2.5;b;-20;9\n", "t U heading\n0 4 10\n2.5 9 -20",
        "0,4,10\n2.5,9,-20\n",
        "\xEF\xBB\xBF\"time (s)\",\"speed (m/s)\",\"heading (deg)\"\n0,4,10\n2.5,9,-20"}) {
    const GustScript script = read_gust_table(text, "g.csv");
    ASSERT_EQ(script.rows.size(), 2U) << text;
    EXPECT_EQ(script.rows[0].time, 0);
    EXPECT_EQ(script.rows[1].time, 2.5);
    EXPECT_EQ(script.rows[0].speed, 4);
    EXPECT_EQ(script.rows[1].speed, 9);
    EXPECT_EQ(script.rows[0].heading, 10);
    EXPECT_EQ(script.rows[1].heading, -20);
    EXPECT_FALSE(script.gust);
  }
}

TEST(ReadGustTable, TakesTheHeadingOfTheCallerWhereItHasNone) {
  EXPECT_EQ(read_gust_table("time,speed\n0,3\n1,4\n", "g.csv", 70).rows[1].heading, 70);
  EXPECT_EQ(read_gust_table("0,3\n1,4\n", "g.csv", 70).rows[0].heading, 70);
}

TEST(ReadGustTable, SaysWhatIsWrongAndWhere) {
  const auto complaint = [](const std::string& text) {
    return test::complaint_of([&] { read_gust_table(text, "g.csv"); });
  };
  const std::string header = "time_s,speed_m_s,heading_deg\n";
  EXPECT_EQ(complaint(""), "g.csv: no rows, wanted times, speeds and headings of a wind");
  EXPECT_EQ(complaint(header), "g.csv: no rows, wanted times, speeds and headings of a wind");
  EXPECT_EQ(complaint(header + "0,1,0\n0,2,0\n"),
            "g.csv:3: time is 0, wanted more than the 0 s of the row before");
  EXPECT_EQ(complaint(header + "0,-1,0\n"), "g.csv:2: speed is -1, wanted 0 to 100 m/s");
  EXPECT_EQ(complaint(header + "0,1,north\n"), "g.csv:2: heading is north, wanted a number");
  EXPECT_EQ(complaint(header + "0,1\n"), "g.csv:2: 2 columns, wanted 3 as in the first line");
  EXPECT_EQ(complaint(header + "0,0,0\n1,0,0\n"), "g.csv: no wind in any row, wanted a speed above 0 m/s");
  EXPECT_EQ(
      complaint("wind,way\n1,2\n"),
      "g.csv:1: 2 columns beginning with wind, wanted a header with time_s, speed_m_s and, where the wind "
      "turns, heading_deg");
  EXPECT_EQ(complaint("time,speed,direction\n1,2,3\n"),
            "g.csv:1: a direction, wanted a heading: where the wind blows to, counter-clockwise from x");
  EXPECT_EQ(complaint("1\n2\n"), "g.csv:1: 1 column, wanted time [s], speed [m/s] and heading [degrees]");
}

}  // namespace
}  // namespace tremula
