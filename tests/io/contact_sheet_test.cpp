#include "tremula/io/contact_sheet.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "io/small_loop.hpp"
#include "tremula/base/error.hpp"

namespace tremula {
namespace {

TEST(EncodeContactSheet, IsAPngOfFourByThreePictures) {
  const std::string png = encode_contact_sheet(test::small_loop());
  EXPECT_EQ(png.substr(0, 8), "\x89PNG\r\n\x1a\n");
  EXPECT_EQ(png.substr(12, 4), "IHDR");
  const auto number_at = [&](std::size_t place) {
    int number = 0;
    for (std::size_t i = 0; i < 4; ++i) number = 256 * number + static_cast<unsigned char>(png.at(place + i));
    return number;
  };
  const int width = number_at(16), height = number_at(20);
  EXPECT_EQ(width % 4, 0);
  EXPECT_NEAR(static_cast<double>(width) / height, 4.0 / 3, 0.01);
}

TEST(EncodeContactSheet, ShowsTwelveInstantsThatPartTheLoopEvenly) {
  const Loop whole = test::small_loop();
  std::vector<double> times;
  Loop loop = whole;
  loop.skin_at = [&](double time) {
    times.push_back(time);
    return whole.skin_at(time);
  };
  encode_contact_sheet(loop);
  ASSERT_EQ(times.size(), 12U);
  for (int i = 0; i < 12; ++i) EXPECT_DOUBLE_EQ(times[static_cast<std::size_t>(i)], 2.0 * i / 12);
}

TEST(EncodeContactSheet, ShowsEveryInstanceAtItsOwnTime) {
  const Loop whole = test::small_loop();
  std::vector<double> times;
  Loop loop = whole;
  loop.instances = {{}, {.position = {3, 0, 0}, .turn = 1, .scale = 0.5, .time_shift = 0.25}};
  loop.skin_at = [&](double time) {
    times.push_back(time);
    return whole.skin_at(time);
  };
  const std::string png = encode_contact_sheet(loop);
  ASSERT_EQ(times.size(), 24U);
  for (std::size_t i = 0; i < 24; ++i)
    EXPECT_DOUBLE_EQ(times[i], 2.0 * static_cast<double>(i / 2) / 12 + (i % 2 == 0 ? 0 : 0.25));
  EXPECT_TRUE(png != encode_contact_sheet(whole));
  loop.instances.clear();
  EXPECT_THROW(encode_contact_sheet(loop), InputError);
}

TEST(EncodeContactSheet, ChangesWithTheMotionAndWithTheWindItIsSeenAcross) {
  const Loop loop = test::small_loop();
  const std::string png = encode_contact_sheet(loop);
  Loop still = loop;
  still.skin_at = [&](double) { return loop.skin_at(0); };
  EXPECT_TRUE(png != encode_contact_sheet(still));
  Loop turned = loop;
  turned.facts.heading += 90;
  EXPECT_TRUE(png != encode_contact_sheet(turned));
}

TEST(EncodeContactSheet, RefusesPosesThatAreNotFinite) {
  const Loop whole = test::small_loop();
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    for (const bool of_normal : {false, true}) {
      Loop loop = whole;
      loop.skin_at = [&](double time) {
        SurfaceDelta delta = whole.skin_at(time);
        (of_normal ? delta.normal : delta.position)[3].y() = bad;
        return delta;
      };
      EXPECT_THROW(encode_contact_sheet(loop), Error);
    }
  }
}

}  // namespace
}  // namespace tremula
