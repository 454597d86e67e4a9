// A wind that changes: how strong it blows and where to, by time. What it is like at a place, its profile and
// its gusts, is another's business: this only scales and turns it.
#pragma once

#include "tremula/base/types.hpp"
#include "tremula/numerics/time_axis.hpp"

#include <optional>
#include <vector>

namespace tremula {

struct GustRow {
  double time = 0;     // [s]
  double speed = 0;    // at the reference height [m/s]
  double heading = 0;  // where it blows to, from x towards y [degrees]
};

// The discrete gust of design codes (IEC 61400-1 since its first edition, CS-25.341): on top of the wind,
// v = A/2 (1 - cos(2 pi (t - t_0)/T)) from t_0 to t_0 + T.
struct OneMinusCosine {
  double amplitude = 0;  // A [m/s]; below 0 it is a lull
  double duration = 0;   // T [s]
  double start = 0;      // t_0 [s]
};

// Linear between its rows, headings by the shorter way round; the first row holds before, the last one after
// them.
struct GustScript {
  std::vector<GustRow> rows;                // times ascend
  std::optional<OneMinusCosine> gust = {};  // besides; it blows where the wind then does
};

// Throws InputError for a script without rows, times that do not ascend, speeds outside 0 to 100 m/s, numbers
// that are not finite, and a gust that takes no time or more than there is of the wind.
void check_gust_script(const GustScript& script);

GustRow wind_at_time(const GustScript& script, double time);

// What the wind is on the average over the samples of a clip: the root of the mean square speed, and where
// the mean of |v| v points to, which is what drag goes by; the first heading where that has none. In time: 0.
GustRow mean_of(const GustScript& script, const TimeAxis& axis);

// By what a wind of a speed [m/s] above 0 and a heading [degrees] is multiplied to become that of a row: a
// factor, and a turn about the vertical. Throws InputError for a speed that is not above 0.
Mat3 change_of_wind(const GustRow& to, double speed, double heading);

}  // namespace tremula
