// tremula beam: one branch as F takes it, a uniform beam with a clamp and a free end.

#include "tremula/base/error.hpp"
#include "tremula/io/beam_plot.hpp"
#include "tremula/structure/uniform_beam.hpp"

#include <numbers>

#include "commands.hpp"
#include "common.hpp"

namespace tremula::cli {
namespace {

struct BeamCommand {
  double length = 1, radius = 0.005, wall = 0;
  std::optional<double> frequency, damping_time, youngs_modulus;
  double density = 800;  // F section 6.1
  int count = 3;
  std::string format = "table", output = "-", plot;

  void run() const;
};

// Of one mode of the beam.
struct BeamMode {
  double root, frequency, mean;
};

void BeamCommand::run() const {
  if (wall > radius) {
    throw InputError("--wall", printed("%g m, in a radius of %g m", wall, radius),
                     "no more than the radius; 0 for a solid branch");
  }
  if (frequency && youngs_modulus)
    throw InputError("--frequency", "given with --youngs-modulus", "one of them");
  if (damping_time && !frequency) throw InputError("--damping-time", "without --frequency", "both");
  if (count < 1 || count > 1000) throw InputError("--count", std::to_string(count), "1 to 1000");
  if (count > 12 && !plot.empty())
    throw InputError("--count", std::to_string(count), "at most 12 with --plot");
  const std::size_t form = format_of({"-o", output}, format == "table" ? "txt" : format,
                                     {{"txt", "a table"}, {"json", "numbers"}}, 0);
  if (!plot.empty()) format_of({"--plot", plot}, "", {{"svg", "a picture"}}, 0);
  Outputs outputs({{"-o", output}, {"--plot", plot}}, {});

  const RoundSection section = round_section(radius, wall);
  const double modulus = frequency ? youngs_modulus_of(*frequency, length, density, section)
                                   : youngs_modulus.value_or(find_material("green-wood").youngs_modulus);
  const UniformBeam beam{length, modulus * section.second_moment, density * section.area};
  std::vector<BeamMode> modes;
  for (int r = 1; r <= count; ++r) {
    modes.push_back(
        {clamped_free_root(r), natural_omega(beam, r) / (2 * std::numbers::pi), clamped_free_mean(r)});
  }
  const double damping = damping_time ? stiffness_damping_of(*damping_time, *frequency) : 0;  // 0: not known

  Json json = {{"length_m", length},
               {"radius_m", radius},
               {"wall_m", wall > 0 ? Json(wall) : Json()},
               {"area_m2", section.area},
               {"second_moment_m4", section.second_moment},
               {"density_kg_m3", density},
               {"youngs_modulus_pa", modulus},
               {"stiffness_damping_s", damping > 0 ? Json(damping) : Json()},
               {"clamp_shear_n_m", clamp_shear(beam, 1)},
               {"modes", Json::array()}};
  std::string table =
      printed("beam of %g m, radius %g m, %s; %g kg/m^3, E = %.4g Pa%s\n%6s %12s %14s %10s%s\n", length,
              radius, wall > 0 ? printed("wall %g m", wall).c_str() : "solid", density, modulus,
              damping > 0 ? printed(", c = %.4g s", damping).c_str() : "", "mode", "lambda", "frequency_hz",
              "mean", damping > 0 ? " damping_ratio" : "");
  for (std::size_t r = 0; r < modes.size(); ++r) {
    const BeamMode& mode = modes[r];
    Json entry = {{"lambda", mode.root}, {"frequency_hz", mode.frequency}, {"mean", mode.mean}};
    table += printed("%6zu %12.6f %14.6g %10.6f", r + 1, mode.root, mode.frequency, mode.mean);
    if (damping > 0) {  // c omega_r^2 = 2 zeta omega_r
      const double ratio = damping * std::numbers::pi * mode.frequency;
      entry["damping_ratio"] = ratio;
      table += printed(" %13.4g", ratio);
    }
    table += '\n';
    json["modes"].push_back(std::move(entry));
  }
  outputs.add(output, form == 1 ? text_of(json) : table);
  if (!plot.empty()) outputs.add(plot, plot_beam_shapes(count));
  outputs.commit();
}

}  // namespace

void add_beam(CLI::App& app) {
  auto command = std::make_shared<BeamCommand>();
  CLI::App& sub = *app.add_subcommand("beam", "One uniform branch: frequencies, or E and damping from them");
  sub.add_option("--length", command->length, "Of the branch [m]")->capture_default_str();
  sub.add_option("--radius", command->radius, "Of its section [m]")->capture_default_str();
  sub.add_option("--wall", command->wall, "Thickness of the wall of a tube [m]; 0: solid")
      ->capture_default_str();
  sub.add_option("--density", command->density, "[kg/m^3]")->capture_default_str();
  sub.add_option("--youngs-modulus", command->youngs_modulus, "[Pa]; not given: that of green-wood");
  sub.add_option("--frequency", command->frequency,
                 "How often it swings [Hz]: gives E, which is then not given");
  sub.add_option("--damping-time", command->damping_time,
                 "In which it falls to 1/e [s]: gives the damping c of --stiffness-damping");
  sub.add_option("--count", command->count, "How many of the lowest modes")->capture_default_str();
  sub.add_option("--format", command->format, "table or json, where no extension says it")
      ->check(CLI::IsMember({"table", "json"}))
      ->capture_default_str();
  sub.add_option("-o,--output", command->output, "File to write instead of standard output: .txt or .json");
  sub.add_option("--plot", command->plot, "Picture of the shapes to draw besides (.svg)");
  sub.footer(
      "Examples:\n"
      "  tremula beam --length 1 --radius 0.005 --frequency 2 --damping-time 1\n"
      "  tremula beam --length 8 --radius 0.03 --wall 0.004 --youngs-modulus 1.1e10\n"
      "  tremula beam --count 3 --plot shapes.svg\n");
  sub.callback([command] { command->run(); });
}

}  // namespace tremula::cli
