#include "tremula/io/wind_plot.hpp"

#include "tremula/base/error.hpp"
#include "tremula/io/atomic_file.hpp"
#include "tremula/io/svg.hpp"

#include <algorithm>
#include <cstdio>
#include <limits>

namespace tremula {
namespace {

constexpr const char* colors[] = {"#0b6e99", "#d9730d", "#4d7c38"};
constexpr const char* component_names[] = {"u", "v", "w"};
constexpr double panel_width = 400, panel_height = 300, top = 44;

std::string length_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g m", value);
  return text;
}

Series measured(const std::string& name, std::size_t color, std::vector<double> x, std::vector<double> y) {
  return {.name = name, .color = colors[color % 3], .x = std::move(x), .y = std::move(y), .width = 1.3};
}

Series target(std::size_t color, std::vector<double> x, std::vector<double> y) {
  return {.name = "",
          .color = colors[color % 3],
          .x = std::move(x),
          .y = std::move(y),
          .width = 2,
          .dashed = true};
}

std::string panel(int column, int row, Plot plot, const std::string& x_label, const std::string& y_label,
                  bool x_log, bool y_log) {
  std::vector<double> xs, ys;
  for (const Series& series : plot.series) {
    xs.insert(xs.end(), series.x.begin(), series.x.end());
    ys.insert(ys.end(), series.y.begin(), series.y.end());
  }
  plot.x = axis_around(x_label, xs, x_log);
  plot.y = axis_around(y_label, ys, y_log);
  return svg_plot(
      plot, {column * panel_width + 68, top + row * panel_height + 30, panel_width - 90, panel_height - 90});
}

// The first, the middle and the last of so many.
std::vector<std::size_t> three_of(std::size_t count) {
  std::vector<std::size_t> picked;
  for (const std::size_t i : {std::size_t{0}, (count - 1) / 2, count - 1}) {
    if (count > 0 && (picked.empty() || picked.back() != i)) picked.push_back(i);
  }
  return picked;
}

template <typename Value>
std::vector<double> by_row(const FieldStatistics& statistics, Value value) {
  std::vector<double> values;
  for (const RowStatistics& row : statistics.rows) values.push_back(value(row));
  return values;
}

std::string profiles(const WindReport& report) {
  const FieldStatistics& statistics = report.statistics;
  const std::vector<double> heights = by_row(statistics, [](const RowStatistics& row) { return row.height; });
  Plot mean{.title = "Mean wind", .x = {}, .y = {}, .series = {}},
      deviation{.title = "Deviation", .x = {}, .y = {}, .series = {}},
      covariance{.title = "Covariance of u and w", .x = {}, .y = {}, .series = {}};
  mean.series.push_back(
      measured("", 0, by_row(statistics, [](const RowStatistics& row) { return row.mean[0]; }), heights));
  mean.series.push_back(target(0, report.targets.mean.y, report.targets.mean.x));
  const std::vector<double>& across = report.targets.mean_across.y;
  if (std::any_of(across.begin(), across.end(), [](double speed) { return speed != 0; })) {
    mean.series.front().name = "u";
    mean.series.push_back(
        measured("v", 1, by_row(statistics, [](const RowStatistics& row) { return row.mean[1]; }), heights));
    mean.series.push_back(target(1, across, report.targets.mean_across.x));
  }
  for (std::size_t c = 0; c < 3; ++c) {
    deviation.series.push_back(
        measured(component_names[c], c,
                 by_row(statistics, [c](const RowStatistics& row) { return row.deviation[c]; }), heights));
    deviation.series.push_back(target(c, report.targets.deviation[c].y, report.targets.deviation[c].x));
  }
  covariance.series.push_back(measured(
      "", 0, by_row(statistics, [](const RowStatistics& row) { return row.covariance_uw; }), heights));
  covariance.series.push_back(target(0, report.targets.covariance.y, report.targets.covariance.x));
  return panel(0, 0, mean, "m/s", "height [m]", false, false) +
         panel(1, 0, deviation, "m/s", "height [m]", false, false) +
         panel(2, 0, covariance, "m²/s²", "height [m]", false, false);
}

std::vector<double> times(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> product;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) product.push_back(a[i] * b[i]);
  return product;
}

std::vector<double> frequencies(const FieldStatistics& statistics) {
  std::vector<double> values;
  for (const FrequencyBand& band : statistics.bands) values.push_back(band.frequency);
  return values;
}

std::string spectra(const WindReport& report, std::size_t component) {
  const std::vector<double> frequency = frequencies(report.statistics);
  Plot plot{.title = std::string("f S of ") + component_names[component], .x = {}, .y = {}, .series = {}};
  const std::vector<std::size_t> rows = three_of(report.statistics.rows.size());
  for (std::size_t k = 0; k < rows.size(); ++k) {
    plot.series.push_back(measured(length_text(report.statistics.rows[rows[k]].height), k, frequency,
                                   times(frequency, report.statistics.spectra[rows[k]][component].value)));
    for (const WindTargets::Spectrum& wanted : report.targets.spectra) {
      if (wanted.row == rows[k] && wanted.component == component)
        plot.series.push_back(target(k, wanted.curve.x, times(wanted.curve.x, wanted.curve.y)));
    }
  }
  return panel(static_cast<int>(component), 1, plot, "frequency [Hz]", "f S [m²/s²]", true, true);
}

std::string coherence(const WindReport& report, std::size_t component, bool vertical) {
  const std::vector<double> frequency = frequencies(report.statistics);
  std::vector<const FieldCoherence*> pairs;
  for (const FieldCoherence& pair : report.statistics.coherence) {
    if (pair.component == component && pair.vertical == vertical) pairs.push_back(&pair);
  }
  Plot plot{.title = std::string(component_names[component]) + (vertical ? " upward" : " across"),
            .x = {},
            .y = {},
            .series = {}};
  const std::vector<std::size_t> shown = three_of(pairs.size());
  for (std::size_t k = 0; k < shown.size(); ++k) {
    const FieldCoherence& pair = *pairs[shown[k]];
    plot.series.push_back(measured(length_text(pair.distance), k, frequency, pair.root));
    for (const WindTargets::Coherence& wanted : report.targets.coherence) {
      if (wanted.component == component && wanted.vertical == vertical && wanted.cells == pair.cells)
        plot.series.push_back(target(k, wanted.curve.x, wanted.curve.y));
    }
  }
  // The axis always shows 0 to 1.
  plot.series.push_back({.name = "", .color = colors[0], .x = {}, .y = {0, 1}});
  plot.series.back().x.assign(2, std::numeric_limits<double>::quiet_NaN());
  return panel(static_cast<int>(component), vertical ? 3 : 2, plot, "frequency [Hz]", "root-coherence", true,
               false);
}

bool has_targets(const WindTargets& targets) {
  return !targets.mean.x.empty() || !targets.spectra.empty() || !targets.coherence.empty() ||
         std::any_of(targets.deviation.begin(), targets.deviation.end(),
                     [](const Curve& curve) { return !curve.x.empty(); });
}

}  // namespace

std::string plot_wind(const WindReport& report) {
  std::string body = svg_text(20, 30, report.title, {.size = 18, .bold = true});
  if (has_targets(report.targets)) {
    body += svg_text(3 * panel_width - 22, 30, "measured: full lines; target: dashed", {.anchor = "end"});
  }
  body += profiles(report);
  for (std::size_t c = 0; c < 3; ++c)
    body += spectra(report, c) + coherence(report, c, false) + coherence(report, c, true);
  return svg_document(3 * panel_width, top + 4 * panel_height, report.title, body);
}

std::string plot_spectra(const WindReport& report, std::size_t row) {
  if (row >= report.statistics.spectra.size()) {
    throw InputError("row of the spectra", std::to_string(row),
                     "less than " + std::to_string(report.statistics.spectra.size()));
  }
  const std::vector<double> frequency = frequencies(report.statistics);
  Plot plot{.title = "", .x = {}, .y = {}, .series = {}};
  std::vector<double> values;
  const auto add = [&](Series series) {
    values.insert(values.end(), series.y.begin(), series.y.end());
    plot.series.push_back(std::move(series));
  };
  for (std::size_t c = 0; c < 3; ++c) {
    add(measured(component_names[c], c, frequency, report.statistics.spectra[row][c].value));
    for (const WindTargets::Spectrum& wanted : report.targets.spectra) {
      if (wanted.row == row && wanted.component == c) add(target(c, wanted.curve.x, wanted.curve.y));
    }
  }
  plot.x = axis_around("frequency [Hz]", frequency, true);
  plot.y = axis_around("S [m²/s² / Hz]", values, true);
  const std::string title =
      "Power spectra " + length_text(report.statistics.rows[row].height) + " above the ground";
  std::string body = svg_text(20, 30, title, {.size = 16, .bold = true});
  if (has_targets(report.targets))
    body += svg_text(76, 60, "measured: full lines; target: dashed", {.size = 12});
  return svg_document(640, 460, title, body + svg_plot(plot, {76, 70, 540, 330}));
}

void write_wind_plot(const std::string& path, const WindReport& report) {
  write_file_atomically(path, plot_wind(report));
}

}  // namespace tremula
