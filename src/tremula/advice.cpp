#include "tremula/pipeline.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

namespace tremula {
namespace {

template <class... Numbers>
std::string print(const char* format, Numbers... numbers) {
  char text[300];
  std::snprintf(text, sizeof text, format, numbers...);
  return text;
}

// From the lowest node to the highest [m].
double height_of(const Structure& structure) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Node& node : structure.nodes) {
    low = std::min(low, node.position.z());
    high = std::max(high, node.position.z());
  }
  return high - low;
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
                                const MotionStatistics& statistics, bool superposed) {
  std::vector<std::string> lines;
  const double nyquist = weather.loop.sample_count / (2 * weather.loop.period);
  const double highest = subject.modes.frequency[subject.modes.count() - 1];
  if (nyquist < highest && weather.dynamics != Dynamics::flapping) {
    lines.push_back(
        print("the highest mode has %.3g Hz, and %.3g frames a second show motion up to %.3g Hz: "
              "take more frames a second or fewer modes",
              highest, 2 * nyquist, nyquist));
  }
  const double height = std::max(lowest_spectrum_height, 0.5 * height_of(subject.structure));
  const auto at_height = [&](double frequency) { return weather.wind.spectrum(height, frequency); };
  if (weather.wind.spectrum && !weather.makes_clip()) {
    const double share = share_between(at_height, 0.5 / weather.loop.period, nyquist);
    if (share < 0.3) {
      lines.push_back(
          print("%.0f %% of the variance of the wind is faster than the loop of %.3g s and seen as "
                "motion; take a longer period to see more of its gusts",
                100 * share, weather.loop.period));
    }
  }
  const double intensity = weather.wind.reference.intensity.value_or(0);
  if (intensity > 0.4 && weather.loads.model != LoadModel::stochastic) {
    lines.push_back(print(
        "a turbulence intensity of %.2g is beyond what loads linear in the gusts describe (0.4)", intensity));
  }
  if (!superposed) return lines;
  // Bent, a branch is stretched; twisted, only its skin is: then the rotation alone tells.
  // The lean itself is bent where rotations are large.
  const bool bends = subject.structure.tree && weather.lean.rotations == Rotations::large;
  const double lean = bends ? 0 : statistics.largest_lean_rotation, rms = statistics.about_lean.rotation;
  if (statistics.largest_stretch > 0.05) {
    lines.push_back(
        print("small displacements superposed stretch branch %d by up to %.0f %%; try a lower wind speed or "
              "stiffer wood",
              statistics.most_stretched_branch, 100 * statistics.largest_stretch));
  } else if (rms > 0.3 || lean + rms > 0.75) {
    lines.push_back(
        print("the wind turns branches by %.2g rad and sways them by %.2g rad rms: too far for small "
              "displacements, so stretching may show; try less wind or stiffer wood",
              statistics.largest_lean_rotation, rms));
  }
  return lines;
}

}  // namespace tremula
