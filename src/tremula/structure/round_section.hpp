// The cross section of a stem: a disc, or a ring where the stem is hollow.
#pragma once

#include <numbers>

namespace tremula {

struct RoundSection {
  double area;           // A [m^2]
  double second_moment;  // I about a diameter [m^4]; the polar moment J is twice that
};

// Of a stem with this radius and thickness of the wall [m]; 0, the default, is solid. Nothing cancels in a
// thin wall: I tends to pi r^3 wall with r the radius of its middle (F section 6.1 has the outer one, which
// is right to first order).
inline RoundSection round_section(double radius, double wall = 0) {
  using std::numbers::pi;
  if (wall == 0 || wall == radius) return {pi * radius * radius, pi / 4 * radius * radius * radius * radius};
  const double bore = radius - wall, area = pi * wall * (radius + bore);
  return {area, area * (radius * radius + bore * bore) / 4};
}

}  // namespace tremula
