#include "tremula/pipeline.hpp"

#include <cmath>
#include <cstdio>
#include <numbers>

namespace tremula {
namespace {

template <class... Numbers>
std::string print(const char* format, Numbers... numbers) {
  char text[300];
  std::snprintf(text, sizeof text, format, numbers...);
  return text;
}

// What a wind is like, as far as its kind knows.
struct Summary {
  double intensity = 0;
  std::function<double(double frequency)> spectrum = {};  // S_u half way up the plant
};

Summary summary_of(const Wind& wind, double height) {
  if (const auto* turbulent = std::get_if<TurbulentWind>(&wind); turbulent && turbulent->mean.speed > 0) {
    return {std::sqrt(spectrum_variance(turbulent->spectrum)[0]) / turbulent->mean.speed,
            [turbulent, height](double frequency) { return spectrum_at(*turbulent, height, frequency)[0]; }};
  }
  if (const auto* stam = std::get_if<StamWind>(&wind);
      stam && stam->mean.speed > 0 && stam->rows == StamRows::unit_variance) {
    const double speed = mean_speed(stam->mean, height);
    if (speed <= 0) return {stam->turbulence_intensity, {}};
    return {stam->turbulence_intensity, [height, speed](double frequency) {
              return simiu_scanlan_spectrum(frequency, height, speed, 1)[0];
            }};
  }
  return {};
}

// The share of the variance between two frequencies: trapezoids over the logarithm.
double share_between(const std::function<double(double)>& spectrum, double low, double high) {
  double inside = 0, all = 0;
  const double step = 0.02;
  for (double x = std::log(1e-5); x < std::log(1e3); x += step) {
    const double frequency = std::exp(x), part = frequency * spectrum(frequency);
    all += part;
    if (frequency > low && frequency < high) inside += part;
  }
  return all > 0 ? inside / all : 1;
}

}  // namespace

std::vector<std::string> advice(const Subject& subject, const Weather& weather,
                                const MotionStatistics& statistics) {
  std::vector<std::string> lines;
  const double nyquist = weather.loop.sample_count / (2 * weather.loop.period);
  const double highest = subject.modes.frequency[subject.modes.count() - 1];
  if (nyquist < highest) {
    lines.push_back(
        print("the highest mode has %.3g Hz, and %.3g frames a second show motion up to %.3g Hz: "
              "take more frames a second or fewer modes",
              highest, 2 * nyquist, nyquist));
  }
  const Extent size = extent(subject.skeleton);
  const Summary wind =
      summary_of(weather.wind, std::max(lowest_spectrum_height, 0.5 * (size.high.z() - size.low.z())));
  if (wind.spectrum) {
    const double share = share_between(wind.spectrum, 0.5 / weather.loop.period, nyquist);
    if (share < 0.3) {
      lines.push_back(
          print("%.0f %% of the variance of the wind is faster than the loop of %.3g s and seen as "
                "motion; take a longer period to see more of its gusts",
                100 * share, weather.loop.period));
    }
  }
  if (wind.intensity > 0.4) {
    lines.push_back(
        print("a turbulence intensity of %.2g is beyond what loads linear in the gusts describe (0.4)",
              wind.intensity));
  }
  const double lean = statistics.largest_lean_rotation, rms = statistics.largest_rms_rotation;
  if (rms > 0.3 || lean + rms > 0.75) {
    lines.push_back(
        print("the wind turns branches by %.2g rad and sways them by %.2g rad rms: too far for small "
              "displacements, so stretching may show; try less wind or stiffer wood",
              lean, rms));
  }
  return lines;
}

}  // namespace tremula
