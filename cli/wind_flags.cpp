#include "wind_flags.hpp"

#include "tremula/base/error.hpp"
#include "tremula/io/spectrum_table.hpp"
#include "tremula/wind/point_wind.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>

namespace tremula::cli {
namespace {

constexpr const char* profile_forms = "log, power, power:EXPONENT or constant";

struct Profile {
  ProfileKind kind = ProfileKind::logarithmic;
  std::optional<double> exponent;
};

Profile parse_profile(const std::string& text) {
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
  }
  throw InputError("--profile", "'" + text + "'", profile_forms);
}

const char* name_of(ProfileKind kind) {
  switch (kind) {
    case ProfileKind::constant:
      return "constant";
    case ProfileKind::logarithmic:
      return "log";
    case ProfileKind::power:
      return "power";
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
    if (name == tremula::name_of(kind)) return kind;
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

Json by_component(const Vec3& values) { return {{"u", values[0]}, {"v", values[1]}, {"w", values[2]}}; }

Json by_component(const std::array<double, 3>& values) {
  return {{"u", values[0]}, {"v", values[1]}, {"w", values[2]}};
}

}  // namespace

void WindFlags::add_to(CLI::App& command, const WindFlagNames& names) {
  const std::string& group = names.group;
  const auto add = [&](const std::string& flag, auto& value, const std::string& text) {
    return command.add_option(flag, value, text)->group(group);
  };
  add(names.speed, speed, "Mean wind speed at the reference height [m/s]")->capture_default_str();
  add("--reference-height", reference_height, "Height of the given wind speed [m]")->capture_default_str();
  if (names.heading) {
    add("--heading", heading, "Where the wind blows to, from +x towards +y [degrees]")->capture_default_str();
  }
  add(names.spectrum, spectrum,
      "How the gusts spread over frequency: simiu-scanlan, iec-kaimal, von-karman, or a table FILE.csv with "
      "columns frequency,S_u,S_v,S_w")
      ->capture_default_str();
  add("--coherence", coherence,
      "How far gusts reach: shinya-fournier, iec, davenport or none (default: iec with iec-kaimal and "
      "von-karman, else shinya-fournier)");
  add("--iec-edition", iec_edition,
      "Of IEC 61400-1, for the lengths of iec-kaimal and von-karman and the coherence iec: 2 or 3")
      ->default_str("3");
  add("--terrain", terrain,
      "What the ground is: " + terrain_names() +
          ". Sets roughness, displacement, canopy and with them the intensity, as far as they are not given");
  add("--profile", profile, std::string("How the mean wind grows with height: ") + profile_forms)
      ->capture_default_str();
  CLI::Option* intensity =
      add("--turbulence-intensity", turbulence_intensity,
          "Standard deviation of the wind over its mean, at the reference height (default: 0.2, or that of "
          "the terrain)");
  add("--friction-velocity", friction_velocity,
      "u* [m/s] instead of the intensity: sigma_u = sqrt(6) u*, whatever the spectrum")
      ->excludes(intensity);
  add("--power-exponent", power_exponent, "Exponent of the power profile")->default_str("0.2");
  add("--roughness-length", roughness_length, "z0 of the log profile [m]")->default_str("0.03");
  add("--displacement", displacement, "Height of the ground that the log profile stands on [m]")
      ->default_str("0");
  add("--canopy-height", canopy_height, "Below it the wind falls exponentially [m]; 0: no canopy")
      ->default_str("0");
  add("--canopy-decay", canopy_decay, "How steeply: a of exp(-a (1 - z/h))")->default_str("2");
  add("--decay-y", decay_y, "Coherence decay across the wind of u,v,w, in place of the model's")
      ->delimiter(',')
      ->expected(3);
  add("--decay-z", decay_z, "The same with height")->delimiter(',')->expected(3);
  add("--amplitudes", amplitudes,
      "gaussian: of every wave the size is random too; phases: only its phase is, the power is the "
      "spectrum's")
      ->check(CLI::IsMember({"gaussian", "phases"}))
      ->capture_default_str();
  add("--seed", seed, "Another seed gives another realisation of the same wind (0 or more)")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
}

MeanWind WindFlags::mean_wind() const {
  const Profile parsed = parse_profile(profile);
  if (parsed.exponent && power_exponent && *parsed.exponent != *power_exponent) {
    throw InputError("--power-exponent", std::to_string(*power_exponent) + " beside --profile " + profile,
                     "one exponent");
  }
  MeanWind mean{
      .speed = speed, .reference_height = reference_height, .heading = heading, .profile = parsed.kind};
  if (terrain) {
    const Terrain& ground = terrain_named(*terrain);
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
  return mean;
}

double WindFlags::intensity(const MeanWind& mean) const {
  if (turbulence_intensity) return *turbulence_intensity;
  if (!friction_velocity) return terrain ? turbulence_intensity_of(mean) : default_turbulence_intensity;
  if (*friction_velocity == 0) return 0;
  if (speed == 0) {
    throw InputError("--friction-velocity", std::to_string(*friction_velocity) + " m/s in a wind of 0 m/s",
                     "a mean wind to carry the gusts, or 0");
  }
  return std::sqrt(6.0) * *friction_velocity / speed;
}

TurbulentWind WindFlags::wind() const {
  const MeanWind mean = mean_wind();
  const std::optional<SpectrumKind> model = model_named(spectrum);
  if (!model && (turbulence_intensity || friction_velocity)) {
    throw InputError(turbulence_intensity ? "--turbulence-intensity" : "--friction-velocity",
                     "given with the table " + spectrum, "none: measured spectra stay as they are");
  }
  const IecEdition edition = tremula::iec_edition(iec_edition.value_or(3));
  TurbulentWind wind =
      turbulent_wind(mean, model ? intensity(mean) : 0, model.value_or(SpectrumKind::simiu_scanlan), edition);
  if (!model) wind.spectrum = spectrum_from_file(spectrum);
  if (coherence) wind.coherence = coherence_model(coherence_named(*coherence), mean, edition);
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

Json describe(const WindFlags& flags, const TurbulentWind& wind) {
  const MeanWind& mean = wind.mean;
  const Coherence& coherence = wind.coherence;
  Json json = {{"spectrum", flags.spectrum},
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
               {"turbulence_intensity", at_reference_height(wind).intensity.value_or(0)},
               {"deviation_m_s", by_component(Vec3(spectrum_variance(wind.spectrum).cwiseSqrt()))}};
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
