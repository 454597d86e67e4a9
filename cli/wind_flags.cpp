#include "wind_flags.hpp"

#include "tremula/base/error.hpp"
#include "tremula/base/number_text.hpp"
#include "tremula/io/profile_table.hpp"
#include "tremula/io/spectrum_table.hpp"
#include "tremula/wind/point_wind.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>

namespace tremula::cli {
namespace {

constexpr const char* profile_forms = "log, power, power:EXPONENT, constant or a table FILE.csv";

std::string lowered(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

struct Profile {
  ProfileKind kind = ProfileKind::logarithmic;
  std::optional<double> exponent;
};

Profile parse_profile(const std::string& given) {
  const std::string text = lowered(given);
  if (text == "log") return {};
  if (text == "constant") return {ProfileKind::constant, {}};
  if (text == "power") return {ProfileKind::power, {}};
  double exponent = 0;
  const std::string_view prefix = "power:";
  if (text.starts_with(prefix)) {
    const char *begin = text.data() + prefix.size(), *end = text.data() + text.size();
    const auto parsed = std::from_chars(begin, end, exponent);
    if (parsed.ec == std::errc{} && parsed.ptr == end && std::isfinite(exponent))
      return {ProfileKind::power, exponent};
  } else if (std::filesystem::exists(given)) {
    return {ProfileKind::table, {}};
  }
  throw InputError("--profile", "'" + given + "'", profile_forms);
}

const char* name_of(ProfileKind kind) {
  switch (kind) {
    case ProfileKind::constant:
      return "constant";
    case ProfileKind::logarithmic:
      return "log";
    case ProfileKind::power:
      return "power";
    case ProfileKind::table:
      return "table";
  }
  return "";
}

std::string terrain_names() {
  std::string names;
  for (const Terrain& terrain : terrains()) names += (names.empty() ? "" : ", ") + terrain.name;
  return names;
}

// Nothing where the name is not that of a model: then it is a file.
std::optional<SpectrumKind> model_named(const std::string& name) {
  for (const SpectrumKind kind :
       {SpectrumKind::simiu_scanlan, SpectrumKind::iec_kaimal, SpectrumKind::von_karman}) {
    if (lowered(name) == tremula::name_of(kind)) return kind;
  }
  return {};
}

SpectrumModel spectrum_from_file(const std::string& path) {
  if (!std::filesystem::exists(path)) {
    throw InputError("--spectrum " + path, "there is no such model or file",
                     "simiu-scanlan, iec-kaimal, von-karman or a table (.csv)");
  }
  return table_spectrum(read_spectrum_table(path));
}

bool takes_lengths(SpectrumKind kind) {
  return kind == SpectrumKind::iec_kaimal || kind == SpectrumKind::von_karman;
}

void override_decay(const std::vector<double>& given, const char* flag, CoherenceKind kind,
                    std::array<double, 3>& decay) {
  if (given.empty()) return;
  if (kind != CoherenceKind::shinya_fournier && kind != CoherenceKind::davenport) {
    throw InputError(flag, "given with --coherence " + tremula::name_of(kind),
                     "shinya-fournier or davenport, whose decays it changes");
  }
  std::copy_n(given.begin(), 3, decay.begin());
}

}  // namespace

void refuse_given(const std::vector<CLI::Option*>& options, const std::string& with,
                  const std::string& wanted) {
  for (const CLI::Option* option : options) {
    if (option->count() > 0)
      throw InputError("--" + option->get_lnames().front(), "given with " + with, wanted);
  }
}

void WindFlags::add_to(CLI::App& command, bool with_heading, bool with_speed) {
  const auto add = [&](std::vector<CLI::Option*>& options, const std::string& flag, auto& value,
                       const std::string& text) {
    options.push_back(command.add_option(flag, value, text)->group(wind_flag_group));
    return options.back();
  };
  if (with_speed) {
    speed_option = add(of_mean, "--wind-speed,--speed", speed,
                       "Mean wind speed at the reference height [m/s] (with a table as --profile: its own)")
                       ->capture_default_str();
  }
  add(of_mean, "--reference-height", reference_height, "Height of the given wind speed; the hub [m]")
      ->capture_default_str();
  if (with_heading) {
    command.add_option("--heading", heading, "Where the wind blows to, from +x towards +y [degrees]")
        ->group(wind_flag_group)
        ->capture_default_str();
  }
  add(of_turbulence, "--spectrum,--model", spectrum,
      "How the gusts spread over frequency: simiu-scanlan, iec-kaimal, von-karman, or a table FILE.csv with "
      "columns frequency,S_u,S_v,S_w [Hz, (m/s)^2/Hz] or k1_rad_per_m,Fu,Fv,Fw [rad/m, m^3/s^2]")
      ->capture_default_str();
  add(of_turbulence, "--coherence", coherence,
      "How far gusts reach: shinya-fournier, iec, davenport or none (default: iec with iec-kaimal and "
      "von-karman, else shinya-fournier)");
  add(of_turbulence, "--iec-edition", iec_edition,
      "Of IEC 61400-1, for the lengths of iec-kaimal and von-karman and the coherence iec: 2 or 3")
      ->default_str("3");
  add(of_mean, "--terrain", terrain,
      "What the ground is: " + terrain_names() +
          ". Sets roughness, displacement, canopy and with them the intensity, as far as they are not given");
  add(of_mean, "--profile", profile,
      std::string("How the mean wind grows with height: ") + profile_forms +
          " with columns height_m,speed_m_s and, where it veers, direction_deg (compass) or heading_deg "
          "(counter-clockwise)")
      ->capture_default_str();
  CLI::Option* intensity = command.add_option("--turbulence-intensity", turbulence_intensity,
                                              "Standard deviation of the wind along its mean over the mean, "
                                              "at the reference height (default: 0.2, or "
                                              "that of the terrain)");
  intensity->group(wind_flag_group);
  of_mean.push_back(intensity);
  CLI::Option* friction =
      command.add_option("--friction-velocity", friction_velocity,
                         "u* [m/s] instead of the intensity: sigma_u = sqrt(6) u*, whatever the spectrum");
  friction->group(wind_flag_group)->excludes(intensity);
  of_mean.push_back(friction);
  CLI::Option* intensity_v = add(of_turbulence, "--turbulence-intensity-v", turbulence_intensity_v,
                                 "Standard deviation across the wind over the mean (default: the model's)");
  add(of_turbulence, "--sigma-ratio-v", sigma_ratio_v, "or over that along the wind")->excludes(intensity_v);
  CLI::Option* intensity_w = add(of_turbulence, "--turbulence-intensity-w", turbulence_intensity_w,
                                 "Standard deviation up and down over the mean (default: the model's)");
  add(of_turbulence, "--sigma-ratio-w", sigma_ratio_w, "or over that along the wind")->excludes(intensity_w);
  add(of_turbulence, "--covariance-uw", covariance_uw,
      "Covariance of u and w, the Reynolds stress over the density [(m/s)^2]: -u*^2 over flat ground; at all "
      "heights, and spread over frequency as sqrt(S_u S_w)")
      ->capture_default_str();
  add(of_mean, "--power-exponent", power_exponent, "Exponent of the power profile")->default_str("0.2");
  add(of_mean, "--roughness-length", roughness_length, "z0 of the log profile [m]")->default_str("0.03");
  add(of_mean, "--displacement", displacement, "Height of the ground that the log profile stands on [m]")
      ->default_str("0");
  add(of_mean, "--canopy-height", canopy_height, "Below it the wind falls exponentially [m]; 0: no canopy")
      ->default_str("0");
  add(of_mean, "--canopy-decay", canopy_decay, "How steeply: a of exp(-a (1 - z/h))")->default_str("2");
  add(of_turbulence, "--decay-y", decay_y,
      "Coherence decay across the wind of u,v,w, in place of the model's")
      ->delimiter(',')
      ->expected(3);
  add(of_turbulence, "--decay-z", decay_z, "The same with height")->delimiter(',')->expected(3);
  of_realisation.push_back(
      command
          .add_option("--amplitudes", amplitudes,
                      "gaussian: of every wave the size is random too; phases: only its phase "
                      "is, the power is the spectrum's")
          ->transform(CLI::IsMember({"gaussian", "phases"}, CLI::ignore_case))
          ->capture_default_str()
          ->group(wind_flag_group));
  add(of_realisation, "--seed", seed,
      "Another seed gives another realisation of the same wind (0 or more); one seed the same gusts, "
      "stronger "
      "or weaker, at other speeds")
      ->capture_default_str();
}

MeanWind WindFlags::mean_wind() const {
  const Profile parsed = parse_profile(profile);
  const auto without_effect = [&](const char* flag, const std::string& wanted) {
    throw InputError(flag, "given with --profile " + profile, wanted);
  };
  if (parsed.kind != ProfileKind::power && power_exponent)
    without_effect("--power-exponent", "--profile power");
  if (parsed.exponent && power_exponent && *parsed.exponent != *power_exponent) {
    throw InputError("--power-exponent", number_text(*power_exponent) + " beside --profile " + profile,
                     "one exponent");
  }
  MeanWind mean{
      .speed = speed, .reference_height = reference_height, .heading = heading, .profile = parsed.kind};
  if (parsed.kind == ProfileKind::table) {
    const std::string wanted = "none: what the ground does is in the table";
    if (terrain) without_effect("--terrain", wanted);
    if (roughness_length) without_effect("--roughness-length", wanted);
    if (displacement) without_effect("--displacement", wanted);
    if (canopy_height) without_effect("--canopy-height", wanted);
    if (canopy_decay) without_effect("--canopy-decay", wanted);
    mean.table = read_profile_table(profile);
    if (speed_option != nullptr && speed_option->count() == 0)
      mean.speed = table_speed(mean.table, mean.reference_height);
  }
  if (terrain) {
    const Terrain ground = terrain_named(lowered(*terrain));
    mean.roughness_length = ground.roughness_length;
    mean.displacement = ground.displacement;
    mean.canopy_height = ground.canopy_height;
    mean.canopy_decay = ground.canopy_decay;
  }
  mean.power_exponent = parsed.exponent.value_or(power_exponent.value_or(mean.power_exponent));
  mean.roughness_length = roughness_length.value_or(mean.roughness_length);
  mean.displacement = displacement.value_or(mean.displacement);
  mean.canopy_height = canopy_height.value_or(mean.canopy_height);
  mean.canopy_decay = canopy_decay.value_or(mean.canopy_decay);
  check_mean_wind(mean);

  // The log law also makes the intensity over a terrain.
  const bool log_law = parsed.kind == ProfileKind::logarithmic ||
                       (terrain && !turbulence_intensity && !friction_velocity && model_named(spectrum));
  if (!log_law && roughness_length) without_effect("--roughness-length", "--profile log");
  if (!log_law && displacement) without_effect("--displacement", "--profile log");
  if (!log_law && terrain && terrain_named(lowered(*terrain)).canopy_height <= 0)
    without_effect("--terrain", "--profile log, or no intensity of your own");
  if (canopy_decay && mean.canopy_height <= 0)
    throw InputError("--canopy-decay", "given without a canopy",
                     "--canopy-height, or a terrain that has one");
  return mean;
}

double WindFlags::intensity(const MeanWind& mean) const {
  if (turbulence_intensity) return *turbulence_intensity;
  if (friction_velocity && *friction_velocity == 0) return 0;
  if (friction_velocity && !(mean.speed > 0))
    throw InputError("--friction-velocity", "given with a wind speed of 0", "a wind, or no turbulence");
  if (friction_velocity) return std::sqrt(6.0) * *friction_velocity / mean.speed;
  return terrain ? tremula::turbulence_intensity_of(mean) : default_turbulence_intensity;
}

TurbulentWind WindFlags::wind() const {
  const MeanWind mean = mean_wind();
  const std::optional<SpectrumKind> model = model_named(spectrum);
  const auto refuse_beside_table = [&](bool given, const char* flag) {
    if (!model && given) {
      throw InputError(flag, "given with the table " + spectrum, "none: measured spectra stay as they are");
    }
  };
  refuse_beside_table(turbulence_intensity.has_value(), "--turbulence-intensity");
  refuse_beside_table(friction_velocity.has_value(), "--friction-velocity");
  refuse_beside_table(turbulence_intensity_v.has_value(), "--turbulence-intensity-v");
  refuse_beside_table(turbulence_intensity_w.has_value(), "--turbulence-intensity-w");
  refuse_beside_table(sigma_ratio_v.has_value(), "--sigma-ratio-v");
  refuse_beside_table(sigma_ratio_w.has_value(), "--sigma-ratio-w");

  const IecEdition edition = tremula::iec_edition(iec_edition.value_or(3));
  TurbulentWind wind =
      turbulent_wind(mean, model ? intensity(mean) : 0, model.value_or(SpectrumKind::simiu_scanlan), edition);
  if (!model) wind.spectrum = spectrum_from_file(spectrum);
  const auto checked = [](const char* flag, double value) {
    if (!(value >= 0 && value <= 10)) throw InputError(flag, number_text(value), "0 to 10");
    return value;
  };
  Vec3 deviation = spectrum_variance(wind.spectrum).cwiseSqrt();
  if (sigma_ratio_v) deviation[1] = checked("--sigma-ratio-v", *sigma_ratio_v) * deviation[0];
  if (sigma_ratio_w) deviation[2] = checked("--sigma-ratio-w", *sigma_ratio_w) * deviation[0];
  if (turbulence_intensity_v)
    deviation[1] = checked("--turbulence-intensity-v", *turbulence_intensity_v) * mean.speed;
  if (turbulence_intensity_w)
    deviation[2] = checked("--turbulence-intensity-w", *turbulence_intensity_w) * mean.speed;
  const bool own = sigma_ratio_v || sigma_ratio_w || turbulence_intensity_v || turbulence_intensity_w;
  if (own) wind.spectrum = with_deviations(wind.spectrum, deviation);
  wind.covariance_uw = covariance_uw;
  if (coherence) wind.coherence = coherence_model(coherence_named(lowered(*coherence)), mean, edition);
  if (iec_edition && !takes_lengths(wind.spectrum.kind) && wind.coherence.kind != CoherenceKind::iec) {
    throw InputError("--iec-edition",
                     "given with " + spectrum + " and coherence " + tremula::name_of(wind.coherence.kind),
                     "iec-kaimal, von-karman or the coherence iec, whose lengths it sets");
  }
  override_decay(decay_y, "--decay-y", wind.coherence.kind, wind.coherence.decay_y);
  override_decay(decay_z, "--decay-z", wind.coherence.kind, wind.coherence.decay_z);
  wind.amplitudes = amplitudes == "phases" ? Amplitudes::phases_only : Amplitudes::gaussian;
  wind.seed = seed;
  check_turbulent_wind(wind);
  return wind;
}

std::string WindFlags::spectrum_name() const {
  const std::optional<SpectrumKind> model = model_named(spectrum);
  return model ? tremula::name_of(*model) : spectrum;
}

Json describe(const WindFlags& flags, const TurbulentWind& wind) {
  const MeanWind& mean = wind.mean;
  const Coherence& coherence = wind.coherence;
  Json json = {{"spectrum", flags.spectrum_name()},
               {"coherence", tremula::name_of(coherence.kind)},
               {"terrain", flags.terrain ? Json(*flags.terrain) : Json()},
               {"wind_speed_m_s", mean.speed},
               {"reference_height_m", mean.reference_height},
               {"heading_deg", mean.heading},
               {"profile", name_of(mean.profile)},
               {"power_exponent", mean.power_exponent},
               {"roughness_length_m", mean.roughness_length},
               {"displacement_m", mean.displacement},
               {"canopy_height_m", mean.canopy_height},
               {"canopy_decay", mean.canopy_decay},
               {"turbulence_intensity", Wind(wind).reference.intensity.value_or(0)},
               {"deviation_m_s", by_component(Vec3(spectrum_variance(wind.spectrum).cwiseSqrt()))},
               {"covariance_uw_m2_s2", wind.covariance_uw}};
  for (const ProfileRow& row : mean.table)
    json["profile_table"].push_back(
        {{"height_m", row.height}, {"speed_m_s", row.speed}, {"turn_deg", row.turn}});
  if (wind.spectrum.kind == SpectrumKind::simiu_scanlan)
    json["friction_velocity_m_s"] = wind.spectrum.friction_velocity;
  if (takes_lengths(wind.spectrum.kind)) json["length_m"] = by_component(wind.spectrum.length);
  if (takes_lengths(wind.spectrum.kind) || coherence.kind == CoherenceKind::iec)
    json["iec_edition"] = flags.iec_edition.value_or(3);
  if (coherence.kind == CoherenceKind::shinya_fournier || coherence.kind == CoherenceKind::davenport) {
    json["decay_y"] = by_component(coherence.decay_y);
    json["decay_z"] = by_component(coherence.decay_z);
  }
  if (coherence.kind == CoherenceKind::iec) {
    json["iec_decay"] = coherence.iec_decay;
    json["iec_length_m"] = coherence.iec_length;
  }
  json["amplitudes"] = flags.amplitudes;
  json["seed"] = wind.seed;
  return json;
}

std::string terrain_table() {
  std::string table =
      "terrain      roughness_length_m displacement_m canopy_height_m canopy_decay intensity_at_10_m\n";
  for (const Terrain& terrain : terrains()) {
    char line[160], canopy[40] = "              -            -";
    if (terrain.canopy_height > 0)
      std::snprintf(canopy, sizeof canopy, "%15g %12g", terrain.canopy_height, terrain.canopy_decay);
    std::snprintf(line, sizeof line, "%-12s %18g %14g %s %17.2f\n", terrain.name.c_str(),
                  terrain.roughness_length, terrain.displacement, canopy,
                  turbulence_intensity_of(mean_wind_over(terrain, 10)));
    table += line;
  }
  return table;
}

}  // namespace tremula::cli
