#include "tremula/wind/spectrum.hpp"

#include "tremula/base/error.hpp"
#include "tremula/base/number_text.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace tremula {
namespace {

constexpr std::pair<const char*, SpectrumKind> names[] = {{"simiu-scanlan", SpectrumKind::simiu_scanlan},
                                                          {"iec-kaimal", SpectrumKind::iec_kaimal},
                                                          {"von-karman", SpectrumKind::von_karman},
                                                          {"table", SpectrumKind::table}};

// The a of S_u ~ (1 + a (f L/U)^2)^(-5/6) with which 4 L/U times that integrates to 1: (2 B(1/2, 1/3))^2
// = 70.78. The standard rounds it to 71 and loses 0.15 % of the variance.
const double von_karman_constant =
    std::pow(2 * std::sqrt(std::numbers::pi) * std::tgamma(1.0 / 3) / std::tgamma(5.0 / 6), 2);

Vec3 iec_kaimal(const SpectrumModel& m, double frequency) {
  const Vec3 period = m.length / m.reference_speed;  // L/U [s]
  Vec3 s;
  for (int c = 0; c < 3; ++c) {
    s[c] = m.deviation[c] * m.deviation[c] * 4 * period[c] / std::pow(1 + 6 * frequency * period[c], 5.0 / 3);
  }
  return s;
}

Vec3 von_karman(const SpectrumModel& m, double frequency) {
  Vec3 s;
  for (int c = 0; c < 3; ++c) {
    const double period = m.length[c] / m.reference_speed, n = frequency * period;
    const double ax = von_karman_constant * n * n;
    const double shape =
        c == 0 ? 4 / std::pow(1 + ax, 5.0 / 6) : 2 * (1 + 8.0 / 3 * ax) / std::pow(1 + ax, 11.0 / 6);
    s[c] = m.deviation[c] * m.deviation[c] * period * shape;
  }
  return s;
}

Vec3 from_table(const SpectrumTable& table, double at) {
  if (at <= table.at.front()) return table.values.front();
  if (at >= table.at.back()) return table.values.back() * std::pow(at / table.at.back(), -5.0 / 3);
  const auto next =
      static_cast<std::size_t>(std::upper_bound(table.at.begin(), table.at.end(), at) - table.at.begin());
  const double share = std::log(at / table.at[next - 1]) / std::log(table.at[next] / table.at[next - 1]);
  return (table.values[next - 1].array().log() * (1 - share) + table.values[next].array().log() * share)
      .exp();
}

Vec3 table_variance(const SpectrumTable& table) {
  Vec3 sum = table.at.front() * table.values.front() + 1.5 * table.at.back() * table.values.back();
  for (std::size_t i = 1; i < table.at.size(); ++i) {
    const double log_ratio = std::log(table.at[i] / table.at[i - 1]);
    for (int c = 0; c < 3; ++c) {
      // S f = S_0 f_0 (f/f_0)^n over d ln f, n one more than the slope; n may be 0.
      const double growth = log_ratio + std::log(table.values[i][c] / table.values[i - 1][c]);
      const double mean = std::abs(growth) < 1e-9 ? 1 + growth / 2 : std::expm1(growth) / growth;
      sum[c] += table.at[i - 1] * table.values[i - 1][c] * log_ratio * mean;
    }
  }
  return sum;
}

// As the model itself has it.
Vec3 own_spectrum(const SpectrumModel& model, double frequency, double height, double speed) {
  switch (model.kind) {
    case SpectrumKind::simiu_scanlan:
      return simiu_scanlan_spectrum(frequency, height, speed, model.friction_velocity);
    case SpectrumKind::iec_kaimal:
      return iec_kaimal(model, frequency);
    case SpectrumKind::von_karman:
      return von_karman(model, frequency);
    case SpectrumKind::table: {
      const double per_speed = 2 * std::numbers::pi / speed;
      if (!model.table.by_wave_number) return from_table(model.table, frequency);
      return per_speed * from_table(model.table, per_speed * frequency);
    }
  }
  return Vec3::Zero();
}

Vec3 own_variance(const SpectrumModel& model) {
  switch (model.kind) {
    case SpectrumKind::simiu_scanlan: {
      const double w = 3.36 * std::pow(10, -0.6) * 0.6 * std::numbers::pi / std::sin(0.6 * std::numbers::pi);
      return model.friction_velocity * model.friction_velocity * Vec3(6, 1.5 * 15 / 9.5, w);
    }
    case SpectrumKind::iec_kaimal:
    case SpectrumKind::von_karman:
      return model.deviation.cwiseAbs2();
    case SpectrumKind::table:
      return table_variance(model.table);
  }
  return Vec3::Zero();
}

}  // namespace

SpectrumKind spectrum_named(const std::string& name) {
  for (const auto& [known, kind] : names) {
    if (name == known) return kind;
  }
  throw InputError("spectrum", name, "simiu-scanlan, iec-kaimal, von-karman or table");
}

std::string name_of(SpectrumKind kind) {
  for (const auto& [name, known] : names) {
    if (kind == known) return name;
  }
  return {};
}

SpectrumModel spectrum_model(SpectrumKind kind, const MeanWind& mean, double turbulence_intensity,
                             IecEdition edition) {
  if (!(turbulence_intensity >= 0 && turbulence_intensity <= 2)) {
    throw InputError("turbulence intensity", number_text(turbulence_intensity), "0 to 2");
  }
  const double deviation = turbulence_intensity * mean.speed;
  const double lambda = turbulence_scale(edition, mean.reference_height);
  SpectrumModel model{.kind = kind,
                      .friction_velocity = friction_velocity_from_intensity(turbulence_intensity, mean.speed),
                      .reference_speed = mean.speed};
  if (kind == SpectrumKind::iec_kaimal) {
    model.deviation = deviation * Vec3(1, 0.8, 0.5);
    model.length = lambda * Vec3(8.1, 2.7, 0.66);
  } else if (kind == SpectrumKind::von_karman) {
    model.deviation = deviation * Vec3::Ones();
    model.length = 3.5 * lambda * Vec3::Ones();
  }
  return model;
}

SpectrumModel table_spectrum(SpectrumTable table) {
  SpectrumModel model{.kind = SpectrumKind::table, .table = std::move(table)};
  check_spectrum(model);
  return model;
}

void check_spectrum(const SpectrumModel& model) {
  const auto check = [](bool good, const char* what, double value, const char* wanted) {
    if (!good || !std::isfinite(value)) throw InputError(what, number_text(value), wanted);
  };
  for (int c = 0; c < 3; ++c)
    check(model.power_factor[c] >= 0, "factor of a spectrum", model.power_factor[c], "0 or more");
  switch (model.kind) {
    case SpectrumKind::simiu_scanlan:
      check(model.friction_velocity >= 0, "friction velocity", model.friction_velocity, "0 m/s or more");
      return;
    case SpectrumKind::iec_kaimal:
    case SpectrumKind::von_karman:
      for (int c = 0; c < 3; ++c) {
        check(model.deviation[c] >= 0, "deviation of the wind", model.deviation[c], "0 m/s or more");
        check(model.length[c] > 0, "length scale of the wind", model.length[c], "above 0 m");
      }
      check(model.reference_speed >= 0, "reference speed", model.reference_speed, "0 m/s or more");
      return;
    case SpectrumKind::table:
      break;
  }
  const SpectrumTable& table = model.table;
  if (table.at.size() < 2 || table.at.size() != table.values.size()) {
    throw InputError("spectrum table", std::to_string(table.at.size()) + " rows",
                     "at least two, with values");
  }
  for (std::size_t i = 0; i < table.at.size(); ++i) {
    check(table.at[i] > (i == 0 ? 0 : table.at[i - 1]), "frequency in the spectrum table", table.at[i],
          "above 0 and above the one before");
    for (int c = 0; c < 3; ++c) {
      check(table.values[i][c] > 0, "value in the spectrum table", table.values[i][c], "above 0");
    }
  }
}

Vec3 spectrum(const SpectrumModel& model, double frequency, double height, double speed) {
  if (speed <= 0) return Vec3::Zero();
  return model.power_factor.cwiseProduct(own_spectrum(model, frequency, height, speed));
}

Vec3 spectrum_variance(const SpectrumModel& model) {
  return model.power_factor.cwiseProduct(own_variance(model));
}

SpectrumModel with_deviations(SpectrumModel model, const Vec3& deviation) {
  const Vec3 own = own_variance(model);
  for (int c = 0; c < 3; ++c) {
    if (own[c] > 0) model.power_factor[c] = deviation[c] * deviation[c] / own[c];
  }
  check_spectrum(model);
  return model;
}

double largest_covariance_uw(const SpectrumModel& model, double height, double speed) {
  // Trapezoids over the logarithm of the frequency: f sqrt(S_u S_w) falls to both sides, as f and f^(-2/3).
  constexpr double lowest = -28, highest = 28, step = 0.02;
  double sum = 0;
  for (double x = lowest; x < highest; x += step) {
    const double frequency = std::exp(x);
    const Vec3 s = spectrum(model, frequency, height, speed);
    sum += step * frequency * std::sqrt(s[0] * s[2]);
  }
  return sum;
}

Vec3 simiu_scanlan_spectrum(double frequency, double height, double speed, double friction_velocity) {
  const double per_frequency = friction_velocity * friction_velocity * height / speed;  // C_0 nu / f
  const double nu = frequency * height / speed;
  return per_frequency * Vec3(200 / std::pow(1 + 50 * nu, 5.0 / 3), 15 / std::pow(1 + 9.5 * nu, 5.0 / 3),
                              3.36 / (1 + 10 * std::pow(nu, 5.0 / 3)));
}

double friction_velocity_from_intensity(double turbulence_intensity, double speed) {
  return turbulence_intensity * speed / std::sqrt(6.0);
}

}  // namespace tremula
