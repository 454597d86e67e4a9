// What tremula animate tells of a run, as JSON.

#include "tremula/dynamics/gauge.hpp"
#include "tremula/dynamics/motion_statistics.hpp"

#include <algorithm>
#include <numbers>

#include "animate.hpp"

namespace tremula::cli {
namespace {

Json describe(const Sway& sway) {
  return {{"largest_m", sway.displacement},
          {"largest_rotation_rad", sway.rotation},
          {"most_moved_branch", sway.branch},
          {"coordinates_m_sqrt_kg", std::vector<double>(sway.coordinates.begin(), sway.coordinates.end())}};
}

Json describe(const MotionStatistics& statistics) {
  return {{"largest_lean_m", statistics.largest_lean},
          {"largest_lean_rotation_rad", statistics.largest_lean_rotation},
          {"rms_about_lean", describe(statistics.about_lean)},
          {"rms_about_loop_mean", describe(statistics.about_mean)},
          {"largest_stretch", statistics.largest_stretch},
          {"most_stretched_branch", statistics.most_stretched_branch}};
}

// What a clip shows once is no process whose peaks could be expected.
Json describe(const Extremes& of, bool repeats) {
  return {{"mean", of.mean},
          {"rms", of.rms},
          {"peak", of.peak},
          {"skewness", of.skewness},
          {"peak_factor_of_600_s", repeats ? Json(of.peak_factor) : Json()},
          {"expected_peak_of_600_s", repeats ? Json(of.expected_peak) : Json()}};
}

Json describe(const std::vector<GaugeSeries>& gauges, bool repeats) {
  Json list = Json::array();
  for (const GaugeSeries& series : gauges) {
    const auto of = [&](const Eigen::VectorXd& values) {
      return describe(extremes_of(values, series.period), repeats);
    };
    list.push_back({{"gauge", series.gauge},
                    {"bending_moment_n_m", of(series.bending_moment)},
                    {"along_n_m", of(series.along_wind)},
                    {"across_n_m", of(series.across_wind)},
                    {"shear_n", of(series.shear)},
                    {"axial_n", of(series.axial)},
                    {"torsion_n_m", of(series.torsion)},
                    {"strain", of(series.strain)}});
  }
  return list;
}

Json describe(const std::optional<WrittenModel>& model) {
  if (!model) return {};
  return {{"form", model->form},
          {"joints", model->joints},
          {"clips", model->clips},
          {"keys", model->keys},
          {"largest_error_m", model->largest_error},
          {"bytes", model->bytes}};
}

// Of every mode by what damps it, as shares of critical damping; nothing where branches move, not modes.
Json describe(const DampingBySource& damping, const Loop& loop) {
  if (damping.structure.size() == 0) return {};
  Json list = Json::array();
  for (std::size_t c = 1; c < loop.kind.size(); ++c) {
    if (loop.kind[c] != ShapeKind::mode) continue;
    const auto r = static_cast<Eigen::Index>(c);
    const double critical = 4 * std::numbers::pi * loop.frequency[r];
    const double structure = damping.structure[r - 1] / critical, medium = damping.medium[r - 1] / critical;
    list.push_back({{"frequency_hz", loop.frequency[r]},
                    {"damping_ratio", structure + medium},
                    {"of_structure", structure},
                    {"of_medium", medium}});
  }
  return list;
}

Json describe(const std::optional<FreeDecay>& decay) {
  if (!decay) return {};
  return {{"frequency_hz", decay->frequency},
          {"damping_ratio", decay->damping_ratio},
          {"cycles", decay->cycles},
          {"scatter", decay->scatter}};
}

Json describe(const std::optional<GustScript>& script) {
  if (!script) return {};
  Json rows = Json::array();
  for (const GustRow& row : script->rows)
    rows.push_back({{"time_s", row.time}, {"speed_m_s", row.speed}, {"heading_deg", row.heading}});
  Json discrete;
  if (script->gust) {
    discrete = {{"amplitude_m_s", script->gust->amplitude},
                {"duration_s", script->gust->duration},
                {"start_s", script->gust->start}};
  }
  return {{"rows", std::move(rows)}, {"one_minus_cosine", std::move(discrete)}};
}

// Of the plant as it stands in the mean wind.
std::vector<double> frequencies_of_modes(const Loop& loop) {
  std::vector<double> frequencies;
  for (std::size_t c = 0; c < loop.kind.size(); ++c) {
    if (loop.kind[c] == ShapeKind::mode) frequencies.push_back(loop.frequency[static_cast<Eigen::Index>(c)]);
  }
  return frequencies;
}

}  // namespace

Json describe(const PullTest& test) {
  const auto vector = [](const Vec3& v) { return Json{v.x(), v.y(), v.z()}; };
  return {{"place", test.pull.place.name},
          {"branch", test.pull.place.branch},
          {"along_branch", test.pull.place.place},
          {"force_n", vector(test.pull.force)},
          {"pulled_by_m", vector(test.released_from)},
          {"by_logarithmic_decrement", describe(test.of_mode)},
          {"by_logarithmic_decrement_at_the_place", describe(test.of_place)},
          {"mode", test.mode + 1},
          {"share_of_energy", test.energy},
          {"modal",
           {{"frequency_hz", test.frequency},
            {"damping_ratio", test.of_structure + test.of_medium},
            {"of_structure", test.of_structure},
            {"of_medium", test.of_medium}}}};
}

std::string told(const PullTest& test) {
  const auto of = [](double frequency, double ratio) {
    return printed("%.4g Hz and %.3g %% damping", frequency, 100 * ratio);
  };
  std::string text =
      printed("pulled by %.3g m at %s and let go: ", test.released_from.norm(), test.pull.place.name.c_str());
  if (test.of_mode) {
    text += printed("over %.3g cycles ", test.of_mode->cycles) +
            of(test.of_mode->frequency, test.of_mode->damping_ratio) + " by logarithmic decrement, ";
  } else {
    text += "too few cycles for a logarithmic decrement (a longer --period shows more), ";
  }
  text += printed("mode %d is ", test.mode + 1) + of(test.frequency, test.of_structure + test.of_medium);
  if (test.of_place) {
    text += "; the place itself " + of(test.of_place->frequency, test.of_place->damping_ratio) +
            printed(", peaks %.2g %% off their line", 100 * test.of_place->scatter);
  }
  return text;
}

Json stresses(const Motion& motion, const Skeleton& skeleton, const Material& material, double heading) {
  Json list = Json::array();
  for (const GaugeReading& reading : motion.most_strained) {
    const Eigen::VectorXd stress = material.youngs_modulus * gauge_series(reading, motion, heading).strain;
    const Extremes extremes = extremes_of(stress, motion.period);
    const double strength = material.modulus_of_rupture;
    const double peak = motion.repeats ? extremes.expected_peak : extremes.peak;
    const Vec3& foot = skeleton.branches[index_of(reading.gauge.branch)].start;
    list.push_back({{"branch", reading.gauge.branch},
                    {"foot_m", {foot.x(), foot.y(), foot.z()}},
                    {"radius_m", reading.radius},
                    {"stress_pa", describe(extremes, motion.repeats)},
                    {"share_of_modulus_of_rupture", strength > 0 ? Json(peak / strength) : Json()}});
  }
  return list;
}

namespace {

std::string name_of(Dynamics dynamics) {
  return std::ranges::find(kinds_of_dynamics, dynamics, [](const auto& kind) { return kind.second; })->first;
}

}  // namespace

Json AnimateCommand::report_of(const Done& done, const StageLog& log) const {
  const Eigen::VectorXd& frequency = done.subject.modes.frequency;
  const Conditions& conditions = done.prepared.conditions;
  Json settings = {{"wind", plant.wind}, {"wind_settings", conditions.described_wind}};
  settings.update(cli::describe(plant.loads));
  if (plant.under_water) settings["wind_over_water_m_s"] = plant.wind_over_water;
  if (conditions.sea) {
    settings["waves"] = {{"significant_height_m", conditions.sea->significant_height},
                         {"peak_period_s", conditions.sea->peak_period},
                         {"water_depth_m", conditions.sea->water_depth}};
  }
  settings.update(Json(
      {{"damping_ratio", plant.is_damped_by_ratio() ? Json(plant.damping_ratio) : Json()},
       {"mode_damping", plant.mode_damping.empty() ? Json() : Json(plant.mode_damping)},
       {"decay_time_s", plant.decay_time ? Json(*plant.decay_time) : Json()},
       {"mass_damping_per_s", plant.mass_damping ? Json(*plant.mass_damping) : Json()},
       {"stiffness_damping_s", plant.stiffness_damping ? Json(*plant.stiffness_damping) : Json()},
       {"aerodynamic_damping", !plant.no_aerodynamic_damping},
       {"dynamics", name_of(conditions.weather.dynamics)},
       {"oscillator_modes", plant.dynamics == "oscillators" ? Json(plant.oscillator_modes) : Json()},
       {"carried_mass", plant.dynamics == "oscillators" ? Json(plant.carried_mass) : Json()},
       {"transfer", conditions.weather.dynamics == Dynamics::modal ? Json(plant.transfer) : Json()},
       {"gust", describe(conditions.weather.script)},
       {"from_rest", plant.from_rest},
       {"repeats", done.loop.repeats},
       {"static_shapes", std::count(done.loop.kind.begin(), done.loop.kind.end(), ShapeKind::static_shape)},
       {"period_s", plant.period},
       {"frames_per_second", plant.frames_per_second},
       {"samples", conditions.weather.loop.sample_count},
       {"seed", plant.wind_flags.seed}}));
  return {{"tremula", TREMULA_VERSION},
          {"input", plant.input},
          {"plant", cli::describe(done.prepared.plant)},
          {"structure",
           done.prepared.plant.is_tree()
               ? cli::describe(done.prepared.bake.structure, done.subject.structure.find_load_margin())
               : Json()},
          {"settings", settings},
          {"warnings", done.warnings},
          {"mode_count", done.subject.modes.count()},
          {"frequencies_hz", std::vector<double>(frequency.begin(), frequency.end())},
          {"frequencies_in_wind_hz", frequencies_of_modes(done.loop)},
          {"damping", describe(done.damping, done.loop)},
          {"mean_drag_n", {done.mean_drag.x(), done.mean_drag.y(), done.mean_drag.z()}},
          {"pull", done.pull ? cli::describe(*done.pull) : Json()},
          {"motion", describe(done.statistics)},
          {"gauges", describe(done.gauges, done.loop.repeats)},
          {"most_stressed_branches", done.most_stressed},
          {"glb", describe(done.model)},
          {"clips", clip_texts},
          {"outputs", outputs},
          {"stages", log.json()},
          {"peak_bytes", peak_bytes()}};
}

}  // namespace tremula::cli
