#include "wind_report.hpp"

namespace tremula::cli {
namespace {

constexpr const char* component_names[] = {"u", "v", "w"};

}  // namespace

Json describe(const WindGrid& grid) {
  return {
      {"points", {{"y", grid.y_count}, {"z", grid.z_count}}},
      {"spacing_m", {{"y", grid.y_spacing}, {"z", grid.z_spacing}}},
      {"size_m", {{"y", (grid.y_count - 1) * grid.y_spacing}, {"z", (grid.z_count - 1) * grid.z_spacing}}},
      {"bottom_m", grid.bottom},
      {"steps", grid.step_count},
      {"step_s", grid.step},
      {"period_s", grid.period()},
      {"periodic", grid.periodic},
      {"mean_speed_m_s", grid.mean_speed},
      {"reference_height_m", grid.reference_height}};
}

Json describe(const FieldStatistics& statistics, const WindTargets& targets) {
  Json rows = Json::array(), bands = Json::array(), spectra = Json::array(), coherence = Json::array();
  for (std::size_t i = 0; i < statistics.rows.size(); ++i) {
    const RowStatistics& row = statistics.rows[i];
    Json json = {{"height_m", row.height},
                 {"mean_m_s", by_component(row.mean)},
                 {"deviation_m_s", by_component(row.deviation)},
                 {"turbulence_intensity", row.turbulence_intensity},
                 {"covariance_uw_m2_s2", row.covariance_uw}};
    if (i < targets.mean.y.size()) {
      json["target_mean_m_s"] = by_component(std::array{targets.mean.y[i], targets.mean_across.y[i], 0.0});
      json["target_covariance_uw_m2_s2"] = targets.covariance.y[i];
      json["target_deviation_m_s"] = by_component(
          std::array{targets.deviation[0].y[i], targets.deviation[1].y[i], targets.deviation[2].y[i]});
    }
    rows.push_back(std::move(json));
  }
  for (const FrequencyBand& band : statistics.bands) {
    bands.push_back(
        {{"frequency_hz", band.frequency}, {"first_bin", band.first_bin}, {"last_bin", band.last_bin}});
  }
  for (std::size_t i = 0; i < statistics.spectra.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      spectra.push_back({{"height_m", statistics.rows[i].height},
                         {"component", component_names[c]},
                         {"measured_m2_s2_per_hz", statistics.spectra[i][c].value},
                         {"standard_error_m2_s2_per_hz", statistics.spectra[i][c].standard_error}});
      for (const WindTargets::Spectrum& wanted : targets.spectra) {
        if (wanted.row == i && wanted.component == c) spectra.back()["target_m2_s2_per_hz"] = wanted.curve.y;
      }
    }
  }
  for (const FieldCoherence& pair : statistics.coherence) {
    coherence.push_back({{"direction", pair.vertical ? "z" : "y"},
                         {"cells", pair.cells},
                         {"distance_m", pair.distance},
                         {"component", component_names[pair.component]},
                         {"pairs", pair.pair_count},
                         {"measured_root", pair.root},
                         {"measured_real", pair.real}});
    for (const WindTargets::Coherence& wanted : targets.coherence) {
      if (wanted.vertical == pair.vertical && wanted.cells == pair.cells &&
          wanted.component == pair.component)
        coherence.back()["target_root"] = wanted.curve.y;
    }
  }
  return {{"rows", rows},
          {"resolution_hz", statistics.resolution},
          {"segments", statistics.segment_count},
          {"segment_steps", statistics.segment_length},
          {"bands", bands},
          {"spectra", spectra},
          {"coherence", coherence}};
}

Json describe(const WindVerdict& verdict) {
  Json json = {{"seam", by_component(verdict.seam)}};
  if (verdict.has_targets) {
    json.update({{"mean_error", verdict.mean_error},
                 {"deviation", by_component(verdict.deviation)},
                 {"deviation_scatter", by_component(verdict.deviation_scatter)},
                 {"spectrum", by_component(verdict.spectrum)},
                 {"coherence_rms", by_component(verdict.coherence_rms)}});
  }
  json["faults"] = verdict.faults;
  return json;
}

Json describe(const SynthesisReport& report, std::size_t row) {
  return {
      {"resolved_share", by_component(std::array{report.resolved_share[0][row], report.resolved_share[1][row],
                                                 report.resolved_share[2][row]})},
      {"clipped_share", by_component(report.clipped_share)},
      {"mean_clipped_share", by_component(report.mean_clipped_share)},
      {"coherence_error", by_component(report.coherence_error)},
      {"match_factor", by_component(report.match_factor)},
      {"largest_domain", {{"y", report.largest_columns}, {"z", report.largest_rows}}}};
}

}  // namespace tremula::cli
