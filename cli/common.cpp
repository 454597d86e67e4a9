#include "common.hpp"

#include "tremula/base/error.hpp"
#include "tremula/geometry/grow.hpp"
#include "tremula/geometry/lsystem.hpp"
#include "tremula/geometry/plants.hpp"
#include "tremula/io/atomic_file.hpp"
#include "tremula/io/frame_file.hpp"
#include "tremula/io/sheet_file.hpp"
#include "tremula/modes/mode_quality.hpp"
#include "tremula/structure/sag.hpp"
#include "tremula/structure/sheet_presets.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <mutex>

#include <sys/resource.h>
#include <tbb/global_control.h>
#include <unistd.h>

namespace tremula::cli {
namespace {

std::vector<std::pair<std::string, double>> parse_constants(const std::vector<std::string>& constants) {
  std::vector<std::pair<std::string, double>> values;
  for (const std::string& text : constants) {
    const std::size_t equals = text.find('=');
    double value = 0;
    std::size_t used = 0;
    try {
      if (equals != std::string::npos) value = std::stod(text.substr(equals + 1), &used);
    } catch (const std::exception&) {
      used = 0;
    }
    if (used == 0 || equals + 1 + used != text.size()) {
      throw InputError("--set", "'" + text + "'", "NAME=NUMBER");
    }
    values.emplace_back(text.substr(0, equals), value);
  }
  return values;
}

Plant grow_plant(const std::string& name, const std::string& text, const std::string& text_name,
                 std::optional<std::uint64_t> seed, const std::vector<std::string>& constants) {
  const LSystem system = parse_lsystem(text, text_name);
  const GrownPlant grown =
      grow(system, {.seed = seed, .constants = parse_constants(constants), .limits = {}});
  return {name, {grown.skeleton, "l-system", {}, {grown.bark_color, grown.leaf_color}}};
}

const PlantPreset* preset_named(const std::string& name) {
  const auto found = std::ranges::find(plant_presets(), name, &PlantPreset::name);
  return found == plant_presets().end() ? nullptr : &*found;
}

}  // namespace

Habitat habitat_of(const std::string& input) {
  if (std::filesystem::exists(input)) {
    if (lower_extension(input) != ".lsys") return {};
    return habitat_of(parse_lsystem(read_file(input, std::size_t{16} << 20), input));
  }
  const PlantPreset* preset = preset_named(input);
  return preset == nullptr ? Habitat{} : habitat_of(parse_lsystem(preset->text, preset->name));
}

void ReadFlags::add_to(CLI::App& command) {
  const char* group = "Reading";
  command.add_option("--unit", unit, "Unit of length of a tree file: m, cm, mm or ft; m if not given")
      ->check(CLI::IsMember({"m", "cm", "mm", "ft"}))
      ->group(group);
  command
      .add_flag(
          "--allow-gaps", allow_gaps,
          "Bridge any gap in a tree file by a rigid arm: between a branch and a parent far away, and from "
          "a piece without parent to the nearest branch")
      ->group(group);
}

ReadOptions ReadFlags::options() const {
  const double size = unit == "mm" ? 1e-3 : unit == "cm" ? 1e-2 : unit == "ft" ? 0.3048 : 1;
  return {.unit = size, .allow_gaps = allow_gaps};
}

void ReadFlags::refuse_for(const std::string& input) const {
  if (!unit.empty()) throw InputError("--unit " + unit, "given with " + input, "a tree file");
  if (allow_gaps) throw InputError("--allow-gaps", "given with " + input, "a tree file");
}

Plant open_plant(const std::string& input, const ReadFlags& read, std::optional<std::uint64_t> growth_seed,
                 const std::vector<std::string>& constants) {
  const std::string name = std::filesystem::path(input).stem().string();
  const bool exists = std::filesystem::exists(input);
  if (!exists) {
    if (const PlantPreset* preset = preset_named(input)) {
      read.refuse_for(input);
      return grow_plant(preset->name, preset->text, preset->name, growth_seed, constants);
    }
    for (const SheetPreset& preset : sheet_presets()) {
      if (preset.name != input) continue;
      read.refuse_for(input);
      if (growth_seed || !constants.empty())
        throw InputError(growth_seed ? "--seed" : "--set", "given with " + input, "an L-system or a plant");
      return {preset.name, {{}, "sheet", {}, {.leaf = preset.color}}, {}, preset.sheet};
    }
    std::string names;
    for (const PlantPreset& preset : plant_presets())
      names += (names.empty() ? "" : ", ") + std::string(preset.name);
    for (const SheetPreset& preset : sheet_presets()) names += ", " + preset.name;
    throw InputError(input, "there is no such file or preset",
                     "a tree file, an L-system (.lsys) or one of " + names);
  }
  if (lower_extension(input) == ".lsys") {
    read.refuse_for(input);
    return grow_plant(name, read_file(input, std::size_t{16} << 20), input, growth_seed, constants);
  }
  if (lower_extension(input) == ".toml") {
    read.refuse_for(input);
    if (growth_seed || !constants.empty())
      throw InputError(growth_seed ? "--seed" : "--set", "given with " + input, "an L-system or a preset");
    if (is_sheet_file(read_file(input, std::size_t{16} << 20))) {
      const SheetFile file = read_sheet(input);
      return {file.name.empty() ? name : file.name, {{}, "sheet", {}, {}}, {}, file.sheet};
    }
    const FrameFile file = read_frame(input);
    return {file.name.empty() ? name : file.name, {outline_of(file.frame), "frame", {}, {}}, file.frame};
  }
  if (growth_seed) throw InputError("--seed", "given with " + input, "an L-system or a preset");
  if (!constants.empty()) throw InputError("--set", "given with " + input, "an L-system or a preset");
  return {name, read_skeleton(input, read.options())};
}

void need_tree(const Plant& plant, const std::string& what) {
  if (!plant.is_tree()) throw InputError(what, plant.kind(), "a tree");
}

void print_warnings(const Plant& plant) {
  for (const Repair& repair : plant.imported.repairs)
    std::cerr << "tremula: warning: " << repair.message << '\n';
}

void print_warnings(const std::vector<std::string>& lines) {
  for (const std::string& line : lines) std::cerr << "tremula: warning: " << line << '\n';
}

Json describe(const Sheet& sheet) {
  const auto vector = [](const Vec3& v) { return Json{v[0], v[1], v[2]}; };
  return {{"width_m", sheet.width},
          {"height_m", sheet.height},
          {"thickness_m", sheet.thickness},
          {"youngs_modulus_pa", sheet.youngs_modulus},
          {"poisson_ratio", sheet.poisson_ratio},
          {"density_kg_m3", sheet.density},
          {"elements", {sheet.elements[0], sheet.elements[1]}},
          {"cloth", sheet.wrinkles},
          {"corner_m", vector(sheet.corner)},
          {"normal", vector(sheet.normal())}};
}

Json describe(const Plant& plant) {
  if (plant.sheet)
    return {{"name", plant.name},
            {"format", "sheet"},
            {"sheet", describe(*plant.sheet)},
            {"repairs", Json::array()}};
  const Skeleton& skeleton = plant.imported.skeleton;
  const Extent box = extent(skeleton);
  double length = 0, volume = 0, thinnest = skeleton.branches.front().end_radius, thickest = 0, leaf_area = 0;
  for (const Branch& branch : skeleton.branches) {
    const double a = branch.start_radius, b = branch.end_radius;
    length += branch.length();
    volume +=
        3.14159265358979323846 / 3 * (a * a + a * b + b * b) * branch.length() * tube_share(branch.wall).area;
    thinnest = std::min({thinnest, a, b});
    thickest = std::max({thickest, a, b});
  }
  for (const Leaf& leaf : skeleton.leaves) leaf_area += leaf.area;
  Json repairs = Json::array();
  for (const Repair& repair : plant.imported.repairs) {
    repairs.push_back({{"kind", repair.kind}, {"count", repair.count}, {"message", repair.message}});
  }
  const auto vector = [](const Vec3& v) { return Json{v[0], v[1], v[2]}; };
  return {{"name", plant.name},
          {"format", plant.imported.format},
          {"branches", skeleton.branch_count()},
          {"roots", plant.frame ? plant.frame->clamped.size() : skeleton.roots.size()},
          {"leaves", skeleton.leaves.size()},
          {"leaf_area_m2", leaf_area},
          {"height_m", box.high.z() - box.low.z()},
          {"low_m", vector(box.low)},
          {"high_m", vector(box.high)},
          {"total_length_m", length},
          {"wood_volume_m3", volume},
          {"radius_min_m", thinnest},
          {"radius_max_m", thickest},
          {"origin_m", vector(skeleton.origin)},
          {"repairs", repairs}};
}

std::uint64_t peak_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

void StructureFlags::add_to(CLI::App& command) {
  std::string names;
  for (const Material& preset : material_presets()) names += (names.empty() ? "" : ", ") + preset.name;
  const char* group = "Wood";
  material_option = command
                        .add_option("--material", material,
                                    "What the branches are made of: " + names +
                                        ". A plant that knows its own (kelp) is made of that")
                        ->capture_default_str()
                        ->group(group);
  command.add_option("--youngs-modulus", youngs_modulus, "Young's modulus E along the grain [Pa]")
      ->group(group);
  command.add_option("--shear-modulus", shear_modulus, "Shear modulus G of torsion [Pa]")->group(group);
  command.add_option("--density", density, "Density of green wood [kg/m^3]")->group(group);
  command
      .add_option("--section", section,
                  "exact: tapered, I = pi r^4/4; paper: mean radius, I = pi r^4 as Stam prints it")
      ->check(CLI::IsMember({"exact", "paper"}))
      ->capture_default_str()
      ->group(group);
  command.add_flag("--no-rotatory-inertia", no_rotatory_inertia, "Leave out the rotatory inertia of bending")
      ->group(group);
  medium_option =
      command
          .add_option(
              "--medium", medium,
              "air, or water, in which kelp, seagrass and algae are anyway: branches and blades carry "
              "some of it with them, and drag is that of water (a current is then the wind; try 0.5 "
              "m/s). Sheets carry what air or water they move, and none in a vacuum")
          ->check(CLI::IsMember({"air", "water", "vacuum"}))
          ->capture_default_str()
          ->group(group);
  command
      .add_option("--root-rotation-stiffness", root_rotation_stiffness,
                  "Each stem stands on a spring of this rotational stiffness [N m/rad]; otherwise clamped")
      ->group(group);
  command
      .add_option("--root-translation-stiffness", root_translation_stiffness,
                  "and of this translational stiffness [N/m]; otherwise it does not shift")
      ->group(group);
  command
      .add_option("--gravity", gravity,
                  "Gravity [m/s^2]: the shape in the file is the shape under its weight, which makes what "
                  "stands sway more slowly and what hangs faster; 0: none")
      ->capture_default_str()
      ->group(group);
  shape_option =
      command
          .add_option(
              "--shape", shape,
              "loaded: the file has the plant as it stands under its weight, as scans and drawings do; "
              "unloaded: as it would be without, and weight (or what floats) bends it first, as kelp and "
              "algae are")
          ->check(CLI::IsMember({"loaded", "unloaded"}))
          ->capture_default_str()
          ->group(group);
}

void StructureFlags::settle_in(const Habitat& habitat) {
  if (material_option->count() == 0 && !habitat.material.empty()) material = habitat.material;
  if (medium_option->count() == 0 && habitat.in_water) medium = "water";
  if (shape_option->count() == 0 && habitat.drawn_unloaded && gravity > 0) shape = "unloaded";
}

StructureOptions StructureFlags::options() const {
  StructureOptions options;
  options.material = find_material(material);
  if (youngs_modulus || shear_modulus || density) {
    options.material.source = options.material.name + ", changed by flags";
    options.material.name = "custom";
  }
  options.material.youngs_modulus = youngs_modulus.value_or(options.material.youngs_modulus);
  options.material.shear_modulus = shear_modulus.value_or(options.material.shear_modulus);
  options.material.density = density.value_or(options.material.density);
  options.section = section == "paper" ? Section::paper : Section::exact;
  options.rotatory_inertia = !no_rotatory_inertia;
  options.added_mass_density = medium == "water" ? water_density : 0;
  options.gravity = gravity;
  options.root.rotation = root_rotation_stiffness.value_or(options.root.rotation);
  options.root.translation = root_translation_stiffness.value_or(options.root.translation);
  check_material(options.material);
  check_root(options.root);
  return options;
}

void StructureFlags::refuse_for(const std::string& input, const char* kind, bool has_weight) const {
  const StructureFlags none;
  const auto refuse = [&](bool given, const char* flag, const std::string& wanted) {
    if (given) throw InputError(flag, "given with the " + std::string(kind) + " " + input, wanted);
  };
  const char* in_file = "the material in the file";
  const std::string is_clamped = "a tree: a " + std::string(kind) + " is clamped";
  const char* no_weight = "a tree: a frame is taken without its weight";
  refuse(material != none.material, "--material", in_file);
  refuse(youngs_modulus.has_value(), "--youngs-modulus", in_file);
  refuse(shear_modulus.has_value(), "--shear-modulus", in_file);
  refuse(density.has_value(), "--density", in_file);
  refuse(root_rotation_stiffness.has_value(), "--root-rotation-stiffness", is_clamped);
  refuse(root_translation_stiffness.has_value(), "--root-translation-stiffness", is_clamped);
  refuse(shape != none.shape, "--shape", has_weight ? "a tree: a sheet is flat" : no_weight);
  if (has_weight) return;
  refuse(medium != none.medium, "--medium", "air");
  refuse(gravity != none.gravity, "--gravity", no_weight);
}

FrameOptions StructureFlags::frame_options(const std::string& input) const {
  refuse_for(input, "frame", false);
  return {.section = section == "paper" ? Section::paper : Section::exact,
          .rotatory_inertia = !no_rotatory_inertia};
}

SheetOptions StructureFlags::sheet_options(const std::string& input) const {
  refuse_for(input, "sheet", true);
  const StructureFlags none;
  if (section != none.section)
    throw InputError("--section", "given with the sheet " + input, "a tree or a frame");
  if (no_rotatory_inertia)
    throw InputError("--no-rotatory-inertia", "given with the sheet " + input,
                     "a tree or a frame: a sheet has none");
  return {.gravity = gravity,
          .fluid_density = medium == "water" ? water_density
                           : medium == "air" ? air_density
                                             : 0};
}

Structure assemble(const Plant& plant, const StructureFlags& flags, const std::string& input) {
  if (plant.frame) return tremula::assemble(*plant.frame, flags.frame_options(input));
  if (plant.sheet) {
    const SheetOptions options = flags.sheet_options(input);
    return in_file(input, [&] { return tremula::assemble(*plant.sheet, options); });
  }
  const Skeleton& skeleton = plant.imported.skeleton;
  const StructureOptions options = flags.options();
  return with_likely_reason(skeleton, options, [&] { return tremula::assemble(skeleton, options); });
}

Plant under_weight(Plant plant, const StructureFlags& flags) {
  if (flags.shape == "loaded" || !plant.is_tree()) return plant;
  if (flags.gravity == 0)
    throw InputError("--shape unloaded", "given with --gravity 0", "a weight that bends the plant");
  plant.imported.skeleton = sagged(plant.imported.skeleton, flags.options());
  return plant;
}

std::vector<bool> trunk_of(const Plant& plant) {
  if (plant.frame) return std::vector<bool>(plant.frame->elements.size());
  if (plant.sheet) return {};
  return trunk_branches(plant.imported.skeleton);
}

Json describe(const StructureOptions& options, const LoadMargin& margin) {
  const auto finite = [](double value) { return std::isfinite(value) ? Json(value) : Json(); };
  return {{"material", options.material.name},
          {"youngs_modulus_pa", options.material.youngs_modulus},
          {"modulus_of_rupture_pa",
           options.material.modulus_of_rupture > 0 ? Json(options.material.modulus_of_rupture) : Json()},
          {"shear_modulus_pa", options.material.shear_modulus},
          {"density_kg_m3", options.material.density},
          {"source", options.material.source},
          {"section", options.section == Section::paper ? "paper" : "exact"},
          {"rotatory_inertia", options.rotatory_inertia},
          {"added_mass_density_kg_m3", options.added_mass_density},
          {"root_rotation_stiffness_n_m_rad", finite(options.root.rotation)},
          {"root_translation_stiffness_n_m", finite(options.root.translation)},
          {"gravity_m_s2", options.gravity},
          {"load_margin", finite(margin.factor)}};
}

void ThreadsFlag::add_to(CLI::App& command) {
  command.add_option("--threads", count, "Threads to use; 0: one per core. The result does not depend on it")
      ->capture_default_str();
}

void ThreadsFlag::run(const std::function<void()>& work) const {
  if (count == 0) return work();
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(count));
  work();
}

struct StageLog::Impl {
  using Clock = std::chrono::steady_clock;
  struct Stage {
    std::string name;
    double seconds;
    std::uint64_t peak;
  };
  std::mutex mutex;
  std::vector<Stage> stages;
  std::string current;
  Clock::time_point begun, drawn{};
  bool terminal = isatty(STDERR_FILENO) == 1;

  void close() {
    if (current.empty()) return;
    stages.push_back({current, std::chrono::duration<double>(Clock::now() - begun).count(), peak_bytes()});
    current.clear();
    if (terminal) std::fputs("\r\033[K", stderr);
  }
  void draw(double done) {
    if (!terminal || Clock::now() - drawn < std::chrono::milliseconds(100)) return;
    drawn = Clock::now();
    const int filled = static_cast<int>(30 * done);
    std::fprintf(stderr, "\r%-12s [%.*s%*s] %3.0f %%", current.c_str(), filled,
                 "##############################", 30 - filled, "", 100 * done);
    std::fflush(stderr);
  }
};

StageLog::StageLog() : impl_(std::make_unique<Impl>()) {}
StageLog::~StageLog() { finish(); }

void StageLog::begin(std::string_view stage) { progress(stage, 0); }

void StageLog::progress(std::string_view stage, double done) {
  const std::lock_guard lock(impl_->mutex);
  if (impl_->current != stage) {
    impl_->close();
    impl_->current = stage;
    impl_->begun = Impl::Clock::now();
  }
  impl_->draw(std::clamp(done, 0.0, 1.0));
}

void StageLog::finish() {
  const std::lock_guard lock(impl_->mutex);
  impl_->close();
}

Json StageLog::json() const {
  Json stages = Json::array();
  for (const auto& stage : impl_->stages) {
    stages.push_back({{"stage", stage.name}, {"seconds", stage.seconds}, {"peak_bytes", stage.peak}});
  }
  return stages;
}

}  // namespace tremula::cli
