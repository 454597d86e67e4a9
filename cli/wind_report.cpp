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

Json describe(const FieldStatistics& statistics) {
  Json rows = Json::array(), bands = Json::array(), spectra = Json::array(), coherence = Json::array();
  for (const RowStatistics& row : statistics.rows) {
    const auto by_component = [](const std::array<double, 3>& values) {
      return Json{{"u", values[0]}, {"v", values[1]}, {"w", values[2]}};
    };
    rows.push_back({{"height_m", row.height},
                    {"mean_m_s", by_component(row.mean)},
                    {"deviation_m_s", by_component(row.deviation)},
                    {"turbulence_intensity", row.turbulence_intensity},
                    {"covariance_uw_m2_s2", row.covariance_uw}});
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
  }
  return {{"rows", rows},
          {"resolution_hz", statistics.resolution},
          {"segments", statistics.segment_count},
          {"segment_steps", statistics.segment_length},
          {"bands", bands},
          {"spectra", spectra},
          {"coherence", coherence}};
}

}  // namespace tremula::cli
