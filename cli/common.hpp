// What the subcommands share: opening plants, materials by flag, progress, and what was done as JSON.
#pragma once

#include "tremula/base/error.hpp"
#include "tremula/geometry/grow.hpp"
#include "tremula/io/skeleton_files.hpp"
#include "tremula/pipeline.hpp"
#include "tremula/structure/plausibility.hpp"
#include "tremula/structure/sheet.hpp"

#include <map>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "outputs.hpp"

namespace tremula::cli {

// What is put into the wind: a plant from a file (scan, SWC, L-system) or, where no file has that name, from
// a preset; or a frame or a sheet (.toml).
struct Plant {
  std::string name;           // for titles: the file's name without folder and extension, or the preset's
  ImportedSkeleton imported;  // of a frame its outline, for the skin
  std::optional<Frame> frame = {};
  std::optional<Sheet> sheet = {};  // whose skeleton is empty

  bool is_tree() const { return !frame && !sheet; }
  const char* kind() const { return sheet ? "a sheet" : frame ? "a frame" : "a tree"; }
};

// Throws InputError for a frame or a sheet where only a tree will do: "grow".
void need_tree(const Plant& plant, const std::string& what);

// Where the plant of an L-system or a preset lives; of anything else nothing is known. Throws as open_plant
// does where the text is none.
Habitat habitat_of(const std::string& input);

// How a tree file is meant: --unit, --allow-gaps.
struct ReadFlags {
  std::string unit;
  bool allow_gaps = false;

  void add_to(CLI::App& command);
  ReadOptions options() const;
  void refuse_for(const std::string& input) const;  // throws where one is given with what is no tree file
};

Plant open_plant(const std::string& input, const ReadFlags& read = {},
                 std::optional<std::uint64_t> growth_seed = {},
                 const std::vector<std::string>& constants = {});

// Says on stderr what the reader mended.
void print_warnings(const Plant& plant);
void print_warnings(const std::vector<std::string>& lines);
Json describe(const Plant& plant);
Json describe(const Sheet& sheet);
Json describe(const std::vector<Panel>& panels);
std::uint64_t peak_bytes();

// Of three values, those of the components of the wind.
template <typename Values>
Json by_component(const Values& values) {
  return {{"u", values[0]}, {"v", values[1]}, {"w", values[2]}};
}

// --material, --youngs-modulus, --shear-modulus, --density, --section, --no-rotatory-inertia,
// --root-rotation-stiffness, --root-translation-stiffness, --gravity, --shape
inline constexpr double water_density = 1000;  // [kg/m^3]
inline constexpr double air_density = LoadOptions{}.fluid_density;

struct StructureFlags {
  std::string material = "green-wood", section = "exact", medium = "air";
  std::optional<double> youngs_modulus, shear_modulus, density;
  std::optional<double> root_rotation_stiffness, root_translation_stiffness;
  double gravity = StructureOptions{}.gravity;
  std::string shape = "loaded";
  bool no_rotatory_inertia = false;

  CLI::Option *material_option = nullptr, *medium_option = nullptr, *shape_option = nullptr;

  void add_to(CLI::App& command);
  // Takes from where a plant lives what was not given.
  void settle_in(const Habitat& habitat);
  StructureOptions options() const;
  // Throws InputError for flags that a frame takes no notice of.
  FrameOptions frame_options(const std::string& input) const;
  SheetOptions sheet_options(const std::string& input) const;  // likewise

 private:
  void refuse_for(const std::string& input, const char* kind, bool has_weight) const;
};
Structure assemble(const Plant& plant, const StructureFlags& flags, const std::string& input);
// The plant as it stands: bent by its weight where --shape says that the file knows nothing of it.
Plant under_weight(Plant plant, const StructureFlags& flags);
// A plant in the wrong unit may be refused because it could not stand: then what no plant has, and the unit
// that was likely meant, is said before the error.
template <class Make>
auto with_likely_reason(const Skeleton& skeleton, const StructureOptions& options, const Make& make) {
  try {
    return make();
  } catch (const InputError&) {
    print_warnings(plausibility(skeleton, options));
    throw;
  }
}
// What a structure has against its numbers, said with the file that they stand in.
template <class Make>
auto in_file(const std::string& file, const Make& make) {
  try {
    return make();
  } catch (const InputError& error) {
    throw InputError(file + ": " + error.what());
  }
}
// Which members are trunk.
std::vector<bool> trunk_of(const Plant& plant);
// The margin is that of the structure made of these.
Json describe(const StructureOptions& options, const LoadMargin& margin);

// Runs everything on this many threads; 0: as many as there are cores.
struct ThreadsFlag {
  int count = 0;
  void add_to(CLI::App& command);
  void run(const std::function<void()>& work) const;
};

// Times the stages, keeps the peak memory at the end of each, and draws a progress bar on a terminal.
class StageLog {
 public:
  StageLog();
  ~StageLog();
  StageLog(const StageLog&) = delete;
  StageLog& operator=(const StageLog&) = delete;
  void begin(std::string_view stage);
  void progress(std::string_view stage, double done);  // begins the stage when it is a new one
  void finish();
  Json json() const;  // [{"stage", "seconds", "peak_bytes"}…]

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tremula::cli
