#include "tremula/wind/gust_script.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/number_text.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

namespace tremula {
namespace {

constexpr double degree = std::numbers::pi / 180;

double speed_of(const OneMinusCosine& gust, double time) {
  const double part = (time - gust.start) / gust.duration;
  if (!(part > 0 && part < 1)) return 0;
  return 0.5 * gust.amplitude * (1 - std::cos(2 * std::numbers::pi * part));
}

// Of the rows alone.
GustRow between_rows(const std::vector<GustRow>& rows, double time) {
  const auto after = std::upper_bound(rows.begin(), rows.end(), time,
                                      [](double t, const GustRow& row) { return t < row.time; });
  if (after == rows.begin()) return {time, rows.front().speed, rows.front().heading};
  if (after == rows.end()) return {time, rows.back().speed, rows.back().heading};
  const GustRow& before = *(after - 1);
  const double part = (time - before.time) / (after->time - before.time);
  return {time, (1 - part) * before.speed + part * after->speed,
          before.heading + part * std::remainder(after->heading - before.heading, 360)};
}

void check_gust(const OneMinusCosine& gust) {
  if (!(gust.duration > 0 && std::isfinite(gust.duration)))
    throw InputError("duration of the gust", number_text(gust.duration) + " s", "above 0 s");
  if (!std::isfinite(gust.start)) throw InputError("start of the gust", number_text(gust.start), "seconds");
  if (!(std::abs(gust.amplitude) <= 100))
    throw InputError("amplitude of the gust", number_text(gust.amplitude) + " m/s", "-100 to 100 m/s");
}

}  // namespace

void check_gust_script(const GustScript& script) {
  check_at_least("rows of a gust script", static_cast<std::ptrdiff_t>(script.rows.size()), 1);
  for (std::size_t i = 0; i < script.rows.size(); ++i) {
    const auto& [time, speed, heading] = script.rows[i];
    const std::string row = " in row " + std::to_string(i + 1) + " of a gust script";
    if (!std::isfinite(time) || (i > 0 && !(time > script.rows[i - 1].time)))
      throw InputError("time" + row, number_text(time) + " s", "finite, and more than in the row before");
    if (!(speed >= 0 && speed <= 100))
      throw InputError("speed" + row, number_text(speed) + " m/s", "0 to 100 m/s");
    if (!std::isfinite(heading))
      throw InputError("heading" + row, number_text(heading), "an angle in degrees");
  }
  if (!script.gust) return;
  check_gust(*script.gust);
  if (script.gust->amplitude >= 0) return;
  // A lull is deepest in its middle, and may be deeper where the wind falls towards it.
  constexpr int parts = 100;
  for (int i = 0; i <= parts; ++i) {
    const double time = script.gust->start + script.gust->duration * i / parts;
    const double left = between_rows(script.rows, time).speed + speed_of(*script.gust, time);
    if (left < 0) {
      throw InputError("amplitude of the gust", number_text(script.gust->amplitude) + " m/s",
                       "a lull that leaves a wind of 0 m/s or more");
    }
  }
}

GustRow wind_at_time(const GustScript& script, double time) {
  GustRow now = between_rows(script.rows, time);
  if (script.gust) now.speed = std::max(0.0, now.speed + speed_of(*script.gust, time));
  return now;
}

GustRow mean_of(const GustScript& script, const TimeAxis& axis) {
  check_gust_script(script);
  check_at_least("samples of a clip", axis.sample_count, 1);
  double square = 0, x = 0, y = 0;
  for (int p = 0; p < axis.sample_count; ++p) {
    const GustRow now = wind_at_time(script, axis.period * p / axis.sample_count);
    square += now.speed * now.speed;
    x += now.speed * now.speed * std::cos(now.heading * degree);
    y += now.speed * now.speed * std::sin(now.heading * degree);
  }
  const bool points = std::hypot(x, y) > 1e-9 * square;
  return {0, std::sqrt(square / axis.sample_count),
          points ? std::atan2(y, x) / degree : script.rows[0].heading};
}

Mat3 change_of_wind(const GustRow& to, double speed, double heading) {
  if (!(speed > 0)) throw InputError("wind under a gust script", number_text(speed) + " m/s", "above 0 m/s");
  const double angle = (to.heading - heading) * degree, factor = to.speed / speed;
  Mat3 change = factor * Mat3::Identity();
  change.topLeftCorner<2, 2>() << factor * std::cos(angle), -factor * std::sin(angle),
      factor * std::sin(angle), factor * std::cos(angle);
  return change;
}

}  // namespace tremula
