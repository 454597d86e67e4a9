#include "tremula/wind/waves.hpp"

#include "tremula/base/error.hpp"
#include "tremula/base/number_text.hpp"
#include "tremula/numerics/quadrature.hpp"
#include "tremula/numerics/random.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace tremula {
namespace {

using std::numbers::pi;
constexpr double gravity = 9.81;  // [m/s^2]

double shape_of(double frequency, double peak_frequency, double enhancement) {
  if (!(frequency > 0)) return 0;
  const double ratio = frequency / peak_frequency, width = ratio <= 1 ? 0.07 : 0.09;
  const double distance = (ratio - 1) / width;
  const double tail = std::exp(-1.25 * std::pow(ratio, -4)) * std::pow(ratio, -5);
  return tail * std::pow(enhancement, std::exp(-0.5 * distance * distance));
}

// Where waves have their energy, in times the peak frequency, and how much of an integral over the frequency
// each stands for: panels fine at the peak, up to where a ten-thousandth is left even of the velocity in the
// surface, which falls with f^-3.
const std::vector<QuadraturePoint>& spectral_points() {
  static const std::vector<QuadraturePoint> points = [] {
    constexpr double edges[] = {0.3, 0.6, 0.8, 0.9, 1, 1.1, 1.25, 1.5, 2, 3, 5, 10, 30, 100};
    std::vector<QuadraturePoint> all;
    for (std::size_t i = 0; i + 1 < std::size(edges); ++i) {
      for (const QuadraturePoint& point : gauss_legendre(16)) {
        const double width = edges[i + 1] - edges[i];
        all.push_back({edges[i] + width * point.position, width * point.weight});
      }
    }
    return all;
  }();
  return points;
}

Vec3 direction_of(double heading) {
  const double angle = heading * pi / 180;
  return {std::cos(angle), std::sin(angle), 0};
}

// What all places share: frequencies, numbers and energies of the waves.
struct SeaState {
  Waves waves;
  Vec3 along;
  WaveSpectrum spectrum;
  struct Component {
    double omega, wave_number, variance;  // [rad/s, 1/m, m^2]
  };
  std::vector<Component> components;

  explicit SeaState(const Waves& of) : waves(of), along(direction_of(of.heading)), spectrum(of) {
    for (const QuadraturePoint& point : spectral_points()) {
      const double frequency = point.position / waves.peak_period, omega = 2 * pi * frequency;
      components.push_back({omega, wave_number(omega, waves.water_depth),
                            spectrum(frequency) * point.weight / waves.peak_period});
    }
  }

  GustStatistics statistics(double z) const {
    double variance_along = 0, variance_up = 0;
    for (const Component& one : components) {
      const OrbitalMotion motion = orbital_motion(one.omega, one.wave_number, waves.water_depth, z);
      variance_along += one.variance * motion.along * motion.along;
      variance_up += one.variance * motion.up * motion.up;
    }
    // A quarter of a period apart, they do not go together.
    GustStatistics result;
    result.covariance = variance_along * along * along.transpose();
    result.covariance(2, 2) += variance_up;
    return result;
  }

  Eigen::Matrix3Xcd velocity(const TimeAxis& loop, const Eigen::Matrix3Xd& points, int bin, int draw) const {
    Eigen::Matrix3Xcd result = Eigen::Matrix3Xcd::Zero(3, points.cols());
    if (bin == 0) return result;
    const double omega = loop.omega(bin), number = wave_number(omega, waves.water_depth);
    const double deviation = std::sqrt(spectrum(loop.frequency(bin)) / (2 * loop.period));
    if (!(deviation > 0)) return result;
    const std::complex<double> surface =
        deviation * complex_gaussian({waves.seed, RandomStream::waves, bin_of_draw(bin, draw), 0});
    for (Eigen::Index k = 0; k < points.cols(); ++k) {
      const Vec3 place = points.col(k);
      const OrbitalMotion motion = orbital_motion(omega, number, waves.water_depth, place.z());
      const std::complex<double> here = surface * std::polar(1.0, -number * along.dot(place));
      result.col(k) = (motion.along * here) * along.cast<std::complex<double>>();
      result(2, k) += std::complex<double>(0, motion.up) * here;
    }
    return result;
  }
};

PointWind at_points(const std::shared_ptr<const SeaState>& sea, const TimeAxis& loop,
                    const Eigen::Matrix3Xd& points) {
  const Waves& waves = sea->waves;
  if (waves.significant_height > 0 && waves.peak_period >= loop.period) {
    throw InputError("peak period of the waves", number_text(waves.peak_period) + " s",
                     "less than the period of the loop, " + number_text(loop.period) + " s");
  }
  PointWind result{
      .mean = Eigen::Matrix3Xd::Zero(3, points.cols()),
      .velocity = [sea, loop, points](int bin, int draw) { return sea->velocity(loop, points, bin, draw); },
      .has_slow_gusts = false,
      .is_checked = true};
  const double highest = points.cols() > 0 ? points.row(2).maxCoeff() : 0;
  if (highest > waves.water_depth) {
    char text[160];
    std::snprintf(text, sizeof text,
                  "the plant reaches %.3g m above the ground and the water is %.3g m deep: what stands above "
                  "it moves as if it stood in the surface",
                  highest, waves.water_depth);
    result.warnings.emplace_back(text);
  }
  return result;
}

// Miche's limit is 0.14 of the length in deep water; in shallow water single waves break at 0.78 of the
// depth, and the highest of a sea have nearly twice H_s.
double breaking_height(const Waves& waves) {
  const double length = 2 * pi / wave_number(2 * pi / waves.peak_period, waves.water_depth);
  return std::min(0.6 * waves.water_depth, length / 7);
}

}  // namespace

void check_waves(const Waves& waves) {
  const auto check = [](bool good, const char* what, double value, const std::string& wanted) {
    if (!good || !std::isfinite(value)) throw InputError(what, number_text(value), wanted);
  };
  check(waves.significant_height >= 0, "significant height of the waves", waves.significant_height,
        "0 m or more");
  check(waves.peak_period > 0, "peak period of the waves", waves.peak_period, "above 0 s");
  check(waves.water_depth > 0, "depth of the water", waves.water_depth, "above 0 m");
  check(waves.peak_enhancement >= 1 && waves.peak_enhancement <= 10, "peak enhancement of the waves",
        waves.peak_enhancement, "1 to 10");
  check(true, "heading of the waves", waves.heading, "an angle in degrees");
  const double highest = breaking_height(waves);
  check(waves.significant_height <= highest, "significant height of the waves", waves.significant_height,
        "at most " + number_text(highest) + " m: higher ones break in " + number_text(waves.water_depth) +
            " m of water at a peak period of " + number_text(waves.peak_period) + " s");
}

Waves wind_waves(double wind_speed, double water_depth) {
  for (const auto& [what, value] :
       {std::pair{"wind over the water", wind_speed}, std::pair{"depth of the water", water_depth}}) {
    if (!(value > 0 && std::isfinite(value))) throw InputError(what, number_text(value), "above 0");
  }
  const double depth = gravity * water_depth / (wind_speed * wind_speed);
  Waves waves{.water_depth = water_depth};
  waves.significant_height =
      wind_speed * wind_speed / gravity * 0.283 * std::tanh(0.530 * std::pow(depth, 0.75));
  waves.peak_period = wind_speed / gravity * 7.54 * std::tanh(0.833 * std::pow(depth, 0.375));
  waves.significant_height = std::min(waves.significant_height, breaking_height(waves));
  return waves;
}

double wave_number(double omega, double water_depth) {
  if (!(omega > 0)) return 0;
  // In units of the depth: x tanh x = d. From above in deep water, from the long wave else; Newton's steps
  // double the digits and do not leave the root's side, as x tanh x is convex.
  const double d = omega * omega * water_depth / gravity;
  double x = d > 1 ? d * (1 + 1 / std::exp(d)) : std::sqrt(d) * (1 + d / 6);
  for (int step = 0; step < 8; ++step) {
    const double t = std::tanh(x), change = (x * t - d) / (t + x * (1 - t * t));
    x -= change;
    if (std::abs(change) <= 1e-16 * x) break;
  }
  return x / water_depth;
}

WaveSpectrum::WaveSpectrum(const Waves& waves)
    : peak_frequency_(1 / waves.peak_period), enhancement_(waves.peak_enhancement) {
  check_waves(waves);
  double sum = 0;
  for (const QuadraturePoint& point : spectral_points())
    sum += point.weight * shape_of(point.position, 1, enhancement_);
  // Beyond the last point exp(...) is 1 to four digits, and f^-5 has a closed form.
  sum += 0.25 * std::pow(100, -4);
  const double deviation = waves.significant_height / 4;
  scale_ = deviation * deviation / (sum * peak_frequency_);
}

double WaveSpectrum::operator()(double frequency) const {
  return scale_ * shape_of(frequency, peak_frequency_, enhancement_);
}

OrbitalMotion orbital_motion(double omega, double wave_number, double water_depth, double z) {
  if (!(omega > 0)) return {};
  const double kh = wave_number * water_depth, kz = wave_number * std::clamp(z, 0.0, water_depth);
  // cosh and sinh over sinh(kh), where these would overflow.
  const double down = std::exp(kz - kh), up = std::exp(-kz - kh), all = -std::expm1(-2 * kh);
  return {omega * (down + up) / all, omega * (down - up) / all};
}

Wind wind_of(const Waves& waves) {
  const auto sea = std::make_shared<const SeaState>(waves);
  Wind wind;
  wind.reference = {.heading = waves.heading};
  wind.spectrum = [sea](double height, double frequency) {
    const double omega = 2 * pi * frequency, depth = sea->waves.water_depth;
    const double along = orbital_motion(omega, wave_number(omega, depth), depth, height).along;
    return along * along * sea->spectrum(frequency);
  };
  wind.statistics = [sea](const Vec3& place) { return sea->statistics(place.z()); };
  wind.at_points = [sea](const TimeAxis& loop, const Eigen::Matrix3Xd& points) {
    return at_points(sea, loop, points);
  };
  return wind;
}

Wind add_waves(Wind current, const Waves& waves) {
  Wind under = wind_of(waves);
  Wind sum;
  sum.reference = current.reference;
  if (current.spectrum) {
    sum.spectrum = [one = current.spectrum, other = under.spectrum](double height, double frequency) {
      return one(height, frequency) + other(height, frequency);
    };
  }
  if (current.statistics) {
    sum.statistics = [one = current.statistics, other = under.statistics](const Vec3& place) {
      GustStatistics both = one(place);
      const GustStatistics more = other(place);
      both.mean += more.mean;
      both.covariance += more.covariance;
      return both;
    };
  }
  sum.at_points = [current = std::move(current), under = std::move(under)](const TimeAxis& loop,
                                                                           const Eigen::Matrix3Xd& points) {
    PointWind one = wind_at_points(current, loop, points);
    const PointWind other = wind_at_points(under, loop, points);
    one.velocity = [first = std::move(one.velocity), second = other.velocity](int bin,
                                                                              int draw) -> Eigen::Matrix3Xcd {
      if (bin == 0) return first(bin, draw);
      return first(bin, draw) + second(bin, draw);
    };
    // Two spectra of different shapes: within a bin neither counts.
    one.power = {};
    one.warnings.insert(one.warnings.end(), other.warnings.begin(), other.warnings.end());
    return one;
  };
  return sum;
}

}  // namespace tremula
