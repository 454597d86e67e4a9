#include "tremula/dynamics/response_field.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/types.hpp"
#include "tremula/numerics/fft.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>

#include <tbb/parallel_for.h>

namespace tremula {
namespace {

using Complex = std::complex<double>;
using std::numbers::pi;

// Of an oscillator of the frequency 1 and the static response 1, the integral of |h|^2 from 0 to x (Crandall
// and Mark 1963), for any damping.
double power_below(double x, double zeta) {
  const double angle = std::atan2(2 * zeta * x, 1 - x * x), sum = 1 + x * x;
  const double bow = std::sqrt(std::abs(1 - zeta * zeta));
  double rest = 2 * x / sum;
  if (zeta < 1 && bow > 1e-4) {
    const double near = (1 - x) * (1 - x) + 2 * x * zeta * zeta / (1 + bow);
    rest = std::log((sum + 2 * bow * x) / near) / (2 * bow);
  } else if (bow > 1e-4) {
    rest = std::atan(2 * bow * x / sum) / bow;
  }
  return (angle + zeta * rest) / (4 * zeta);
}

double power_at(double x, double zeta) {
  const double spring = 1 - x * x, dashpot = 2 * zeta * x;
  return 1 / (spring * spring + dashpot * dashpot);
}

double mean_power_between(double low, double high, double zeta) {
  const double width = high - low, middle = 0.5 * (low + high);
  // Far above the resonance nothing would be left of the difference, and there |h|^2 is nearly straight.
  if (!(width > 0) || middle > 1 + zeta + 8 * width) {
    return (power_at(low, zeta) + 4 * power_at(middle, zeta) + power_at(high, zeta)) / 6;
  }
  return (power_below(high, zeta) - power_below(low, zeta)) / width;
}

// h_x at one frequency, transformed along the wind at a wave number.
struct Kernel {
  SpatialResponse::Kind kind;
  double length;       // s [m]
  double wave_number;  // [1/m]

  bool is_exponential() const { return kind == SpatialResponse::Kind::exponential; }
};

Kernel kernel_of(const SpatialResponse& spatial, double frequency, double wave_number) {
  const bool of_frequency = spatial.kind == SpatialResponse::Kind::shinya_fournier;
  return {spatial.kind, of_frequency ? spatial.length / std::sqrt(frequency) : spatial.length, wave_number};
}

// Its integral across.
double gain_of(const Kernel& kernel) {
  const double phase = kernel.wave_number * kernel.length;
  if (kernel.wave_number == 0 || kernel.kind == SpatialResponse::Kind::none) return 1;
  if (kernel.is_exponential()) return std::pow(1 + phase * phase, -1.5);
  return std::exp(-phase * phase / 4);
}

// The integral of (t - u) t K_1(t)/pi from u >= 0 on. K_1 is an integral over exp(-t cosh a), which leaves
// one that the trapezoidal rule sums to all digits, for it has no end within reach.
double exponential_tail(double u) {
  constexpr double step = 0.3, end = 18;
  double sum = 0;
  for (int i = 0; i * step < end; ++i) {
    const double c = std::cosh(i * step);
    if (u * c > 45) break;
    sum += (i == 0 ? 0.5 : 1) * (u + 2 / c) / c * std::exp(-u * c);
  }
  return sum * step / pi;
}

// D(eta), the integral of (t - eta) G(t) from eta >= 0 on, for the kernel across G: exp(-eta^2/s^2) for
// gaussians; for the exponential eta K_1(kappa eta), kappa^2 = 1/s^2 + k^2.
double tail_of(const Kernel& kernel, double eta) {
  const double s = kernel.length;
  if (kernel.is_exponential()) {
    const double kappa = std::hypot(1 / s, kernel.wave_number);
    return gain_of(kernel) / kappa * exponential_tail(kappa * eta);
  }
  return gain_of(kernel) *
         (s * std::exp(-eta * eta / (s * s)) / (2 * std::sqrt(pi)) - eta / 2 * std::erfc(eta / s));
}

// What the columns j to the left and to the right give to a column, for gusts that are straight between
// columns: hats against G, which are second differences of D. The last stands for all beyond it.
std::vector<float> weights_of(const Kernel& kernel, double spacing, int columns) {
  const double gain = gain_of(kernel);
  if (kernel.kind == SpatialResponse::Kind::none || columns == 1 || !(gain > 0))
    return {static_cast<float>(gain)};
  constexpr double negligible = 1e-7;
  double here = tail_of(kernel, 0), next = tail_of(kernel, spacing);
  std::vector<float> weights = {static_cast<float>(gain + 2 * (next - here) / spacing)};
  for (int j = 1; j < columns; ++j) {
    const double rest = (here - next) / spacing;  // from column j on
    const double after = tail_of(kernel, (j + 1) * spacing);
    const bool is_last = j == columns - 1 || (next - after) / spacing < negligible * gain;
    weights.push_back(static_cast<float>(is_last ? rest : rest - (next - after) / spacing));
    if (is_last) break;
    here = next;
    next = after;
  }
  return weights;
}

// A row of columns under symmetric weights; what lies beyond its ends is as there.
void spread(const std::vector<float>& weights, std::complex<float>* row, int columns) {
  const int reach = static_cast<int>(weights.size()) - 1;
  std::vector<std::complex<float>> wide(index_of(columns + 2 * reach));
  std::fill_n(wide.begin(), reach, row[0]);
  std::copy_n(row, columns, wide.begin() + reach);
  std::fill_n(wide.end() - reach, reach, row[columns - 1]);
  for (int i = 0; i < columns; ++i) row[i] *= weights[0];
  for (int j = 1; j <= reach; ++j) {
    const std::complex<float>*left = wide.data() + reach - j, *right = wide.data() + reach + j;
    for (int i = 0; i < columns; ++i) row[i] += weights[index_of(j)] * (left[i] + right[i]);
  }
}

// One component of one layer: series at the columns, to spectra and back.
struct LayerComponent {
  const TravellingField& field;
  int layer;
  std::size_t component;
};

constexpr int columns_at_once = 8;

// (bins x columns), columns side by side.
std::vector<std::complex<float>> spectra_of(const LayerComponent& part) {
  const auto& [field, layer, component] = part;
  const int columns = field.plane.columns, samples = field.loop.sample_count, bins = field.loop.bin_count();
  std::vector<std::complex<float>> spectra(index_of(bins) * index_of(columns));
  tbb::parallel_for(0, (columns + columns_at_once - 1) / columns_at_once, [&](int block) {
    const int first = block * columns_at_once, count = std::min(columns_at_once, columns - first);
    Eigen::MatrixXd series(samples, count);
    for (int p = 0; p < samples; ++p) {
      for (int j = 0; j < count; ++j)
        series(p, j) = static_cast<double>(field.values[field.index(layer, p, first + j)][component]);
    }
    if (!series.allFinite()) throw InputError("gusts of the field", "one that is not finite", "numbers");
    const Eigen::MatrixXcd half = half_spectra_from_samples(series);
    for (int bin = 0; bin < bins; ++bin) {
      for (int j = 0; j < count; ++j)
        spectra[index_of(bin) * index_of(columns) + index_of(first + j)] =
            static_cast<std::complex<float>>(half(bin, j));
    }
  });
  return spectra;
}

void write_series(const std::vector<std::complex<float>>& spectra, TravellingField& field, int layer,
                  std::size_t component) {
  const int columns = field.plane.columns, samples = field.loop.sample_count, bins = field.loop.bin_count();
  const RealSeries series(samples, columns_at_once);
  tbb::parallel_for(0, (columns + columns_at_once - 1) / columns_at_once, [&](int block) {
    const int first = block * columns_at_once, count = std::min(columns_at_once, columns - first);
    FftArray<std::complex<float>> half(index_of(columns_at_once) * index_of(bins));
    FftArray<float> values(index_of(columns_at_once) * index_of(series.pitch()));
    for (int bin = 0; bin < bins; ++bin) {
      for (int j = 0; j < count; ++j)
        half[index_of(j) * index_of(bins) + index_of(bin)] =
            spectra[index_of(bin) * index_of(columns) + index_of(first + j)];
    }
    series.sum(half.data(), values.data());
    for (int p = 0; p < samples; ++p) {
      for (int j = 0; j < count; ++j) {
        const float value = values[index_of(j) * index_of(series.pitch()) + index_of(p)];
        if (!std::isfinite(value))
          throw InputError("response of the field", "one beyond what numbers hold", "a smaller impedance");
        field.values[field.index(layer, p, first + j)][component] = value;
      }
    }
  });
}

void check_gusts(const TravellingField& gusts) {
  check_plane(gusts.plane, gusts.loop);
  const std::size_t layers = gusts.plane.heights.size();
  const std::size_t values =
      layers * index_of(gusts.loop.sample_count) * static_cast<std::size_t>(gusts.plane.columns);
  check_equal("values of the field", static_cast<std::ptrdiff_t>(gusts.values.size()),
              static_cast<std::ptrdiff_t>(values));
  check_equal("layers of the field's mean", static_cast<std::ptrdiff_t>(gusts.mean.size()),
              static_cast<std::ptrdiff_t>(layers));
  if (!(gusts.speed >= 0) || !std::isfinite(gusts.speed) || !std::isfinite(gusts.heading))
    throw InputError("speed of the field", number_text(gusts.speed) + " m/s", "one from 0 on, and a heading");
  for (const Vec3& mean : gusts.mean) {
    if (!mean.allFinite()) throw InputError("mean of the field", "one that is not finite", "numbers");
  }
}

void check_spatial(const SpatialResponse& spatial) {
  if (spatial.kind != SpatialResponse::Kind::none)
    check_positive("length of the spatial response", spatial.length, " m");
}

double wave_number_of(double frequency, double speed) { return speed > 0 ? 2 * pi * frequency / speed : 0; }

Complex response_at(const Impedance& impedance, double frequency) {
  const Complex response = impedance(frequency);
  if (std::isfinite(response.real()) && std::isfinite(response.imag())) return response;
  throw InputError("impedance at " + number_text(frequency) + " Hz", "one that is not finite", "a number");
}

}  // namespace

Impedance oscillator_impedance(double natural_frequency, double damping_ratio, double static_response,
                               Transfer kind) {
  check_positive("natural frequency", natural_frequency, " Hz");
  check_positive("damping ratio", damping_ratio);
  if (!std::isfinite(static_response))
    throw InputError("static response", number_text(static_response), "a finite number");
  Impedance impedance([=](double frequency) {
    const double x = frequency / natural_frequency;
    return static_response / Complex(1 - x * x, 2 * damping_ratio * x);
  });
  if (kind == Transfer::bin_averaged) {
    impedance.mean_power = [=](double low, double high) {
      return static_response * static_response *
             mean_power_between(low / natural_frequency, high / natural_frequency, damping_ratio);
    };
  }
  return impedance;
}

Impedance impedance_from_table(std::vector<ImpedanceRow> rows) {
  if (rows.empty()) throw InputError("impedance", "a table of no rows", "one or more");
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const ImpedanceRow& row = rows[i];
    if (!std::isfinite(row.frequency) || row.frequency < 0 || !std::isfinite(row.response.real()) ||
        !std::isfinite(row.response.imag()) || (i > 0 && !(row.frequency > rows[i - 1].frequency))) {
      throw InputError("impedance: row " + std::to_string(i + 1), number_text(row.frequency) + " Hz",
                       "finite numbers, and frequencies from 0 on that rise");
    }
  }
  return [rows = std::move(rows)](double frequency) {
    const auto above = std::ranges::upper_bound(rows, frequency, {}, &ImpedanceRow::frequency);
    if (above == rows.begin()) return rows.front().response;
    if (above == rows.end()) return rows.back().response;
    const ImpedanceRow& below = *(above - 1);
    const double share = (frequency - below.frequency) / (above->frequency - below.frequency);
    return (1 - share) * below.response + share * above->response;
  };
}

Complex bin_response(const Impedance& impedance, const TimeAxis& loop, int bin) {
  const double frequency = loop.frequency(bin), half = 0.5 / loop.period;
  Complex response = response_at(impedance, frequency);
  if (bin == 0) response = response.real();
  if (!impedance.mean_power) return response;
  const double low = bin == 0 ? 0 : frequency - half,
               high = 2 * bin == loop.sample_count ? frequency : frequency + half;
  const double size = std::sqrt(impedance.mean_power(low, high)), at_middle = std::abs(response);
  if (!std::isfinite(size)) {
    throw InputError("impedance at " + number_text(frequency) + " Hz", "a mean power that is not finite",
                     "a number from 0 on");
  }
  return at_middle > 0 ? size * (response / at_middle) : size;
}

double spatial_gain(const SpatialResponse& spatial, double frequency, double speed) {
  check_spatial(spatial);
  const double wave_number = wave_number_of(frequency, speed);
  return wave_number > 0 ? gain_of(kernel_of(spatial, frequency, wave_number)) : 1;
}

TravellingField respond(const TravellingField& gusts, const FieldResponse& response) {
  check_gusts(gusts);
  check_spatial(response.spatial);
  const int columns = gusts.plane.columns, layers = static_cast<int>(gusts.plane.heights.size()),
            bins = gusts.loop.bin_count();
  const std::array<const Impedance*, 3> impedances = {&response.along, &response.across, &response.up};

  const double angle = gusts.heading * pi / 180;
  const Eigen::Matrix3d axes = Eigen::AngleAxisd(angle, Vec3::UnitZ()).toRotationMatrix();
  Vec3 at_rest = Vec3::Zero();
  for (int c = 0; c < 3; ++c) {
    if (*impedances[index_of(c)]) at_rest[c] = response_at(*impedances[index_of(c)], 0).real();
  }
  TravellingField answer;
  answer.loop = gusts.loop;
  answer.heading = gusts.heading;
  answer.speed = gusts.speed;
  answer.plane = gusts.plane;
  answer.ground = gusts.ground;
  for (const Vec3& mean : gusts.mean)
    answer.mean.emplace_back(axes * at_rest.cwiseProduct(axes.transpose() * mean));
  answer.values.resize(gusts.values.size());

  std::vector<std::vector<float>> weights(index_of(bins));
  tbb::parallel_for(0, bins, [&](int bin) {
    const double wave_number = wave_number_of(gusts.loop.frequency(bin), gusts.speed);
    weights[index_of(bin)] =
        weights_of(kernel_of(response.spatial, gusts.loop.middle_frequency(bin), wave_number),
                   gusts.plane.spacing, columns);
  });
  for (std::size_t c = 0; c < impedances.size(); ++c) {
    if (!*impedances[c]) continue;
    std::vector<std::complex<float>> factors;
    for (int bin = 0; bin < bins; ++bin)
      factors.push_back(static_cast<std::complex<float>>(bin_response(*impedances[c], gusts.loop, bin)));
    for (int layer = 0; layer < layers; ++layer) {
      std::vector<std::complex<float>> spectra = spectra_of({gusts, layer, c});
      tbb::parallel_for(0, bins, [&](int bin) {
        std::complex<float>* row = spectra.data() + index_of(bin) * index_of(columns);
        spread(weights[index_of(bin)], row, columns);
        for (int j = 0; j < columns; ++j) row[j] *= factors[index_of(bin)];
      });
      write_series(spectra, answer, layer, c);
    }
  }
  return answer;
}

}  // namespace tremula
