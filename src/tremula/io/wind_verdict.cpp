#include "tremula/io/wind_verdict.hpp"

#include "tremula/wind/check_field.hpp"
#include "tremula/wind/synthesis.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

namespace tremula {
namespace {

constexpr const char* names[] = {"u", "v", "w"};
constexpr int enough_bins = 8;

template <class... Numbers>
std::string print(const char* format, Numbers... numbers) {
  char text[300];
  std::snprintf(text, sizeof text, format, numbers...);
  return text;
}

std::string print(const char* format, const std::array<double, 2>& range) {
  return print(format, range[0], range[1]);
}

double seam_of(const WindField& field, std::size_t component) {
  const std::vector<float>& values = field.velocity[component];
  const std::size_t points = field.grid.point_count(),
                    steps = static_cast<std::size_t>(field.grid.step_count);
  const auto change = [&](std::size_t from, std::size_t to) {
    double sum = 0;
    for (std::size_t p = 0; p < points; ++p) {
      const auto difference = static_cast<double>(values[to * points + p] - values[from * points + p]);
      sum += difference * difference;
    }
    return sum;
  };
  double others = 0;
  for (std::size_t t = 1; t < steps; ++t) others += change(t - 1, t);
  return others > 0 ? std::sqrt(change(steps - 1, 0) * static_cast<double>(steps - 1) / others) : 0;
}

struct Range {
  double least = std::numeric_limits<double>::infinity(), most = 0;
  void add(double value) {
    least = std::min(least, value);
    most = std::max(most, value);
  }
  std::array<double, 2> values() const { return most > 0 ? std::array{least, most} : std::array{0.0, 0.0}; }
};

void compare_rows(const WindReport& report, WindVerdict& verdict) {
  const std::vector<RowStatistics>& rows = report.statistics.rows;
  const double hub_speed = report.targets.mean.y[verdict.hub_row];
  for (std::size_t i = 0; i < rows.size() && hub_speed > 0; ++i)
    verdict.mean_error =
        std::max(verdict.mean_error, std::abs(rows[i].mean[0] - report.targets.mean.y[i]) / hub_speed);
  for (std::size_t c = 0; c < 3; ++c) {
    Range range;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const double wanted = report.targets.deviation[c].y[i];
      if (wanted > 0) range.add(rows[i].deviation[c] / wanted);
    }
    verdict.deviation[c] = range.values();
  }
}

void compare_spectra(const WindReport& report, WindVerdict& verdict) {
  const FieldStatistics& statistics = report.statistics;
  std::array<Range, 3> ranges;
  for (std::size_t b = 0; b < statistics.bands.size(); ++b) {
    if (statistics.bands[b].bin_count() < enough_bins) continue;
    std::array<double, 3> measured = {}, wanted = {};
    for (const WindTargets::Spectrum& target : report.targets.spectra) {
      measured[target.component] += statistics.spectra[target.row][target.component].value[b];
      wanted[target.component] += target.curve.y[b];
    }
    for (std::size_t c = 0; c < 3; ++c) {
      if (wanted[c] > 0) ranges[c].add(measured[c] / wanted[c]);
    }
  }
  for (std::size_t c = 0; c < 3; ++c) verdict.spectrum[c] = ranges[c].values();
  // The power of a bin is exponential: a sum over bins scatters by the root of the sum of squares, and a
  // deviation by half of that.
  for (const WindTargets::Spectrum& target : report.targets.spectra) {
    if (target.row != verdict.hub_row) continue;
    double sum = 0, squares = 0;
    for (std::size_t b = 0; b < statistics.bands.size(); ++b) {
      const double power = target.curve.y[b], bins = statistics.bands[b].bin_count();
      sum += bins * power;
      squares += bins * power * power;
    }
    if (sum > 0) verdict.deviation_scatter[target.component] = 0.5 * std::sqrt(squares) / sum;
  }
}

void compare_coherence(const WindReport& report, WindVerdict& verdict) {
  const FieldStatistics& statistics = report.statistics;
  std::array<double, 3> squares = {}, counts = {};
  for (std::size_t k = 0; k < std::min(statistics.coherence.size(), report.targets.coherence.size()); ++k) {
    const FieldCoherence& measured = statistics.coherence[k];
    const WindTargets::Coherence& wanted = report.targets.coherence[k];
    for (std::size_t b = 0; b < statistics.bands.size(); ++b) {
      if (statistics.bands[b].bin_count() < enough_bins) continue;
      const double error = measured.real[b] - wanted.curve.y[b];
      squares[measured.component] += error * error;
      counts[measured.component] += 1;
    }
  }
  for (std::size_t c = 0; c < 3; ++c)
    verdict.coherence_rms[c] = counts[c] > 0 ? std::sqrt(squares[c] / counts[c]) : 0;
}

void find_faults(const WindField& field, WindVerdict& verdict) {
  const auto add = [&](const std::string& fault) { verdict.faults.push_back(fault); };
  if (verdict.mean_error > 0.02) add(print("the mean is up to %.0f %% off", 100 * verdict.mean_error));
  for (std::size_t c = 0; c < 3; ++c) {
    const double allowed = 0.02 + 3 * verdict.deviation_scatter[c];
    const auto [least, most] = verdict.deviation[c];
    if (most > 0 && (least < 1 - allowed || most > 1 + allowed))
      add(print("the deviation of %s is %.2f to %.2f of that wanted", names[c], least, most));
  }
  for (std::size_t c = 0; c < 3; ++c) {
    if (verdict.coherence_rms[c] > 0.1)
      add(print("the coherence of %s is off by %.2f rms", names[c], verdict.coherence_rms[c]));
  }
  const double seam = *std::max_element(verdict.seam.begin(), verdict.seam.end());
  if (field.grid.periodic && seam > 2)
    add(print("it says that it is periodic, but jumps by %.1f steps where it closes", seam));
}

std::string row_text(const WindReport& report, std::size_t i, bool with_targets) {
  const RowStatistics& row = report.statistics.rows[i];
  std::string text = print("%10.3f %8.3f", row.height, row.mean[0]);
  if (with_targets) text += print(" %8.3f", report.targets.mean.y[i]);
  for (std::size_t c = 0; c < 3; ++c) {
    text += print(" %8.3f", row.deviation[c]);
    if (with_targets) text += print(" %8.3f", report.targets.deviation[c].y[i]);
  }
  text += print(" %8.4f %8.3f", row.turbulence_intensity, row.covariance_uw);
  if (with_targets) text += print(" %8.3f", report.targets.covariance.y[i]);
  return text + "\n";
}

std::string table(const WindReport& report, bool with_targets, std::size_t most_rows) {
  const char* wanted = with_targets ? "   wanted" : "";
  std::string text = print("height [m]  U [m/s]%s  sigma_u%s  sigma_v%s  sigma_w%s  sigma/U       uw%s\n",
                           wanted, wanted, wanted, wanted, wanted);
  const std::size_t count = report.statistics.rows.size(),
                    shown = std::min(count, std::max<std::size_t>(most_rows, 2));
  for (std::size_t k = 0; k < shown; ++k) {
    const std::size_t from_top = shown > 1 ? k * (count - 1) / (shown - 1) : 0;
    text += row_text(report, count - 1 - from_top, with_targets);
  }
  return text;
}

template <class Value>
std::string by_component(const char* format, const std::array<Value, 3>& values) {
  std::string text;
  for (std::size_t c = 0; c < 3; ++c) text += (c > 0 ? ", " : "") + (names[c] + print(format, values[c]));
  return text;
}

// Of the point itself, not of its row: what Match::hub makes exact.
std::string hub_text(const WindGrid& grid, const FieldStatistics& statistics) {
  const auto [row, column] = hub_point(grid);
  const auto at = static_cast<std::size_t>(row * grid.y_count + column);
  const double mean = statistics.point_mean[0][at];
  std::string text =
      print("hub        y %.6g m, z %.6g m: U %.3f m/s, sigma", grid.y(column), grid.z(row), mean);
  for (std::size_t c = 0; c < 3; ++c) text += print(" %.3f", statistics.point_deviation[c][at]);
  if (mean > 0) {
    text += " m/s, intensity";
    for (std::size_t c = 0; c < 3; ++c) text += print(" %.4f", statistics.point_deviation[c][at] / mean);
  }
  return text + "\n";
}

}  // namespace

WindVerdict judge_wind(const WindField& field, const WindReport& report) {
  check_wind_field(field);
  WindVerdict verdict{.hub_row = static_cast<std::size_t>(hub_point(field.grid)[0])};
  for (std::size_t c = 0; c < 3; ++c) verdict.seam[c] = seam_of(field, c);
  verdict.has_targets = report.targets.mean.y.size() == report.statistics.rows.size();
  if (verdict.has_targets) {
    compare_rows(report, verdict);
    compare_spectra(report, verdict);
    compare_coherence(report, verdict);
  }
  find_faults(field, verdict);
  return verdict;
}

std::string verdict_text(const WindField& field, const WindReport& report, const WindVerdict& verdict,
                         std::size_t most_rows) {
  const WindGrid& grid = field.grid;
  std::string text =
      print("field      %d x %d points (y x z), z %.6g to %.6g m, %d steps of %.6g s: %.6g s\n", grid.y_count,
            grid.z_count, grid.bottom, grid.z(grid.z_count - 1), grid.step_count, grid.step, grid.period());
  if (field.tower_count > 0)
    text += print("tower      %d points, from %.6g m down to %.6g m\n", field.tower_count, grid.bottom,
                  grid.bottom - (field.tower_count - 1) * grid.z_spacing);
  text += table(report, verdict.has_targets, most_rows);
  text += hub_text(grid, report.statistics);
  if (verdict.has_targets) {
    text += "resolved   of the variance wanted at all frequencies such a loop holds " +
            by_component(" %.2f", report.targets.resolved_share) + "\n";
    text += "deviation  measured over wanted: " + by_component(" %.2f to %.2f", verdict.deviation) +
            "; one loop scatters by" +
            print(" %.2f, %.2f, %.2f\n", verdict.deviation_scatter[0], verdict.deviation_scatter[1],
                  verdict.deviation_scatter[2]);
    text += "spectra    measured over wanted, in bands of 8 bins and more: " +
            by_component(" %.2f to %.2f", verdict.spectrum) + "\n";
    text += "coherence  measured minus wanted, rms: " + by_component(" %.3f", verdict.coherence_rms) + "\n";
  }
  text += std::string("periodic   ") + (grid.periodic ? "yes" : "no") +
          "; from the last step to the first it changes as from others times " +
          by_component(" %.2f", verdict.seam) + "\n";
  text += "verdict    ";
  if (verdict.faults.empty())
    return text + (verdict.has_targets
                       ? "as wanted\n"
                       : "nothing said what it should be (--spectrum, --turbulence-intensity, ...)\n");
  for (std::size_t i = 0; i < verdict.faults.size(); ++i) text += (i > 0 ? "; " : "") + verdict.faults[i];
  return text + "\n";
}

}  // namespace tremula
