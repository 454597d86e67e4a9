#include "tremula/wind/stam_wind.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/error.hpp"
#include "tremula/base/number_text.hpp"
#include "tremula/numerics/random.hpp"
#include "tremula/wind/spectrum.hpp"

#include <cmath>
#include <complex>
#include <numbers>
#include <string>

namespace tremula {
namespace {

constexpr double lowest_height = 0.5;
constexpr RandomStream streams[3] = {RandomStream::wind_u, RandomStream::wind_v, RandomStream::wind_w};

}  // namespace

void check_stam_wind(const StamWind& wind) {
  check_mean_wind(wind.mean);
  const auto check = [](bool good, const char* what, double value, const char* wanted) {
    if (!good || !std::isfinite(value)) throw InputError(what, number_text(value), wanted);
  };
  check(wind.turbulence_intensity >= 0 && wind.turbulence_intensity <= 2, "turbulence intensity",
        wind.turbulence_intensity, "0 to 2");
  check(wind.correlation_time >= 0, "correlation time", wind.correlation_time, "0 s or more");
  check(wind.correlation_length > 0, "correlation length", wind.correlation_length, "a length above 0 m");
  check(wind.cutoff >= 0 && wind.cutoff < 1, "filter cut-off", wind.cutoff, "0 to below 1");
}

StamWindAtPoints::StamWindAtPoints(const StamWind& wind, const TimeAxis& axis, const Eigen::Matrix3Xd& points)
    : wind_(wind),
      axis_(axis),
      friction_velocity_(friction_velocity_from_intensity(wind.turbulence_intensity, wind.mean.speed)),
      heights_(points.row(2).transpose().cwiseMax(lowest_height)),
      speeds_(points.cols()),
      filter_(points) {
  check_stam_wind(wind);
  check_at_least("samples of the loop", axis.sample_count, 1);
  if (!(std::isfinite(axis.period) && axis.period > 0)) {
    throw InputError("period of the loop", std::to_string(axis.period), "above 0 s");
  }
  for (Eigen::Index k = 0; k < points.cols(); ++k) speeds_[k] = mean_speed(wind.mean, heights_[k]);
}

Eigen::Matrix3Xcd StamWindAtPoints::velocity(int bin, int draw) const {
  const Eigen::Index count = speeds_.size();
  Eigen::Matrix3Xcd velocity = Eigen::Matrix3Xcd::Zero(3, count);
  const bool as_printed = wind_.rows == StamRows::as_printed;
  if (!as_printed && wind_.mean.speed == 0) return velocity;

  PairwiseFilter::Channels noise(count, PairwiseFilter::channels);
  for (Eigen::Index k = 0; k < count; ++k) {
    for (int c = 0; c < 3; ++c) {
      const auto w =
          complex_gaussian({wind_.seed, streams[c], bin_of_draw(bin, draw), static_cast<std::uint64_t>(k)});
      noise(k, 2 * c) = static_cast<float>(w.real());
      noise(k, 2 * c + 1) = static_cast<float>(w.imag());
    }
  }
  const double frequency = as_printed ? axis_.frequency(bin) : axis_.middle_frequency(bin);
  const double decay =
      2 * std::numbers::pi * frequency * wind_.correlation_time / wind_.correlation_length;  // [1/m]
  const auto [filtered, squared_weights] = filter_.apply(decay, wind_.cutoff, noise);

  for (Eigen::Index k = 0; k < count; ++k) {
    const Vec3 along = heading_direction(wind_.mean, heights_[k]), across(-along[1], along[0], 0);
    Vec3 amplitude = Vec3::Ones();
    if (!as_printed) {
      if (speeds_[k] <= 0) continue;
      const Vec3 spectrum = simiu_scanlan_spectrum(frequency, heights_[k], speeds_[k], friction_velocity_);
      amplitude = (spectrum / (2 * axis_.period * static_cast<double>(squared_weights[k]))).cwiseSqrt();
    }
    const auto component = [&, &filtered = filtered](int c) {
      return amplitude[c] * std::complex<double>(static_cast<double>(filtered(k, 2 * c)),
                                                 static_cast<double>(filtered(k, 2 * c + 1)));
    };
    velocity.col(k) = component(0) * along + component(1) * across + component(2) * Vec3::UnitZ();
  }
  return velocity;
}

}  // namespace tremula
