// What blows, as flags and the files they name say.
#include "tremula/io/gust_table.hpp"
#include "tremula/io/turbsim.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <utility>

#include "plant_in_wind.hpp"

namespace tremula::cli {
namespace {

// AMPLITUDE:DURATION or AMPLITUDE:DURATION:START, of a whole text.
OneMinusCosine parse_gust(const std::string& text, const std::string& numbers) {
  double values[3] = {};
  std::size_t count = 0;
  const char *at = numbers.data(), *end = at + numbers.size();
  while (count < 3) {
    const auto read = std::from_chars(at, end, values[count]);
    if (read.ec != std::errc{} || !std::isfinite(values[count])) break;
    ++count;
    at = read.ptr;
    if (at == end || *at != ':') break;
    ++at;
  }
  if (at != end || count < 2 || numbers.ends_with(':')) {
    throw InputError("--gust", "'" + text + "'",
                     "an amplitude [m/s], a duration [s] and perhaps a start [s], such as 1-cosine:8:2.5");
  }
  return {values[0], values[1], values[2]};
}

}  // namespace

void PlantInWind::settle(const CLI::App& flags) {
  settle_in(habitat_of(input), flags);
  check(flags);
  read_gust(flags);
}

// A plant that lives in water has the wind over it: that makes waves, and drifts the water besides the
// current that there is anyway. Any other may be put into a current.
void PlantInWind::settle_in(const Habitat& habitat, const CLI::App& flags) {
  structure.settle_in(habitat);
  if (habitat.in_water && structure.medium == "water") {
    under_water = habitat;
    if (water_depth) under_water->water_depth = *water_depth;
    wind_over_water = wind_flags.speed;
    wind_flags.speed = current_under(wind_over_water);
    if (flags.count("--reference-height") == 0) wind_flags.reference_height = under_water->water_depth;
  } else if (current) {
    if (flags.count("--wind-speed") > 0)
      throw InputError("--current", "given with --wind-speed",
                       "one of them, but for plants that live in water");
    wind_flags.speed = *current;
  }
}

double PlantInWind::current_under(double wind_speed) const {
  return current.value_or(under_water->current + wind_drift * wind_speed);
}

// A pull is let go in still air, and what a script says blows smoothly, unless flags want more.
WindFlags PlantInWind::flags_of_wind() const {
  WindFlags flags = wind_flags;
  if (pull.empty() && gust.empty()) return flags;
  if (!pull.empty() && flags.speed_option->count() == 0) flags.speed = 0;
  if (!asks_for_turbulence()) flags.turbulence_intensity = 0;
  return flags;
}

// A clip is as long as the table, unless somebody says how long; what blows is the script's wind on the
// average.
void PlantInWind::read_gust(const CLI::App& flags) {
  if (gust.empty()) return;
  constexpr std::string_view discrete = "1-cosine:";
  if (gust.starts_with(discrete)) {
    const double speed = flags_of_wind().mean_wind().speed;
    script = GustScript{{{0, speed, wind_flags.heading}}, parse_gust(gust, gust.substr(discrete.size()))};
  } else if (std::filesystem::exists(gust)) {
    script = read_gust_table(gust, wind_flags.heading);
    if (flags.count("--period") == 0 && script->rows.back().time > 0) period = script->rows.back().time;
  } else {
    throw InputError("--gust", "'" + gust + "'", "1-cosine:AMPLITUDE:DURATION[:START] or a table FILE.csv");
  }
  const GustRow mean = mean_of(*script, weather({}).loop);
  if (!(mean.speed > 0))
    throw InputError("--gust", "no wind while the clip lasts", "a gust or a --wind-speed above 0 m/s");
  wind_flags.speed = mean.speed;
  wind_flags.heading = mean.heading;
}

ChosenWind PlantInWind::chosen_wind() const {
  if (wind == "turbulent") {
    const WindFlags flags = flags_of_wind();
    const TurbulentWind turbulent = flags.wind();
    // A plant alone has the gusts that it would have in a scene; but those of phases only none can share.
    const bool of_world = shares_wind || turbulent.amplitudes == Amplitudes::gaussian;
    const Realisation realisation = of_world ? Realisation::of_world : Realisation::of_points;
    return {moved_across(Wind(turbulent, realisation), across), describe(flags, turbulent)};
  }
  if (is_stam()) {
    const StamWind stam = stam_wind();
    return {moved_across(stam, across),
            {{"wind_speed_m_s", stam.mean.speed},
             {"reference_height_m", stam.mean.reference_height},
             {"profile", wind_flags.profile},
             {"roughness_length_m", stam.mean.roughness_length},
             {"heading_deg", stam.mean.heading},
             {"turbulence_intensity", stam.turbulence_intensity},
             {"correlation_time_s", stam.correlation_time},
             {"correlation_length_m", stam.correlation_length}}};
  }
  if (is_field()) {
    const auto field = std::make_shared<const WindField>(wind_field(read_turbsim(wind)));
    const Wind given = GivenWind{field, wind_flags.heading};
    const std::optional<double> intensity = given.reference.intensity;
    return {moved_across(given, across),
            {{"wind_speed_m_s", given.reference.speed},
             {"reference_height_m", given.reference.height},
             {"heading_deg", given.reference.heading},
             {"turbulence_intensity", intensity ? Json(*intensity) : Json()},
             {"period_s", field->grid.period()},
             {"points", {field->grid.y_count, field->grid.z_count}}}};
  }
  throw InputError("--wind", "'" + wind + "'", "turbulent, stam, stam-printed or a field FILE.bts");
}

PlantInWind PlantInWind::in_wind_of(double wind_speed) const {
  PlantInWind other = *this;
  if (under_water) other.wind_over_water = wind_speed;
  other.wind_flags.speed = under_water ? current_under(wind_speed) : wind_speed;
  return other;
}

PlantInWind PlantInWind::turned_by(double degrees) const {
  PlantInWind other = *this;
  other.wind_flags.heading += degrees;
  if (other.script) {
    for (GustRow& row : other.script->rows) row.heading += degrees;
  }
  return other;
}

StamWind PlantInWind::stam_wind() const {
  const MeanWind mean = wind_flags.mean_wind();
  StamWind stam{.mean = mean,
                .turbulence_intensity = wind_flags.intensity(mean),
                .correlation_time = correlation_time.value_or(StamWind{}.correlation_time),
                .correlation_length = correlation_length.value_or(StamWind{}.correlation_length),
                .seed = wind_flags.seed};
  if (wind == "stam-printed") {
    stam.rows = StamRows::as_printed;
    stam.cutoff = 1e-4;  // its tails are not normalised away
  }
  return stam;
}

std::optional<Waves> PlantInWind::chosen_waves() const {
  if (waves.empty() && under_water && wind_over_water > 0 && loads.model != "paper") {
    Waves sea = wind_waves(wind_over_water, under_water->water_depth);
    sea.heading = wind_flags.heading;
    sea.seed = wind_flags.seed;
    return sea;
  }
  if (waves.empty()) return {};
  Waves sea{.water_depth = 0, .heading = wind_flags.heading, .seed = wind_flags.seed};
  const char *begin = waves.data(), *end = begin + waves.size();
  const auto height = std::from_chars(begin, end, sea.significant_height);
  const bool parts = height.ec == std::errc{} && height.ptr != end && *height.ptr == ':';
  const auto last = parts ? std::from_chars(height.ptr + 1, end, sea.peak_period) : height;
  if (!parts || last.ec != std::errc{} || last.ptr != end) {
    throw InputError("--waves", "'" + waves + "'",
                     "a significant height [m] and a peak period [s], such as 0.5:4");
  }
  if (water_depth || under_water) {
    sea.water_depth = under_water ? under_water->water_depth : *water_depth;
    check_waves(sea);
  }
  return sea;
}

Weather PlantInWind::weather(const Wind& blowing) const {
  Weather weather;
  weather.wind = blowing;
  loads.set(structure, weather);
  weather.damping = {.ratio = damping_ratio,
                     .ratios = Eigen::VectorXd::Map(mode_damping.data(), std::ssize(mode_damping)),
                     .mass_proportional = mass_damping,
                     .stiffness_proportional = stiffness_damping,
                     .decay_time = decay_time,
                     .aerodynamic = !no_aerodynamic_damping};
  weather.transfer = transfer == "sampled" ? Transfer::sampled : Transfer::bin_averaged;
  weather.static_correction = !no_static_correction;
  weather.dynamics = kinds_of_dynamics.at(dynamics);
  weather.oscillators = {.modes = oscillator_modes, .carried_mass = carried_mass};
  weather.script = script;
  weather.from_rest = from_rest;
  const double samples = period * frames_per_second;
  if (!(samples >= 1 && samples <= 1 << 24)) {
    throw InputError("--period " + std::to_string(period) + " at --fps " + std::to_string(frames_per_second),
                     std::to_string(samples) + " frames", "1 to 16777216");
  }
  weather.loop = {period, static_cast<int>(std::lround(samples))};
  return weather;
}

Conditions PlantInWind::conditions() const {
  ChosenWind blowing = chosen_wind();
  return {weather(blowing.wind), chosen_waves(), std::move(blowing.described)};
}

std::vector<Place> PlantInWind::input_places() const {
  return {{"INPUT", input},
          {"--wind", wind},
          {"--spectrum", wind_flags.spectrum},
          {"--profile", wind_flags.profile},
          {"--gust", gust}};
}

}  // namespace tremula::cli
