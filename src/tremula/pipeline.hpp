// The cascade from end to end. Read this first: what depends on the plant alone is baked once; the wind and
// the motion vary. pipeline.cpp is the whole story.
#pragma once

#include "tremula/dynamics/branch_oscillators.hpp"
#include "tremula/dynamics/damping.hpp"
#include "tremula/dynamics/drag_in_time.hpp"
#include "tremula/dynamics/flapping.hpp"
#include "tremula/dynamics/lean.hpp"
#include "tremula/dynamics/loads.hpp"
#include "tremula/dynamics/motion.hpp"
#include "tremula/dynamics/motion_statistics.hpp"
#include "tremula/dynamics/pull.hpp"
#include "tremula/dynamics/transfer.hpp"
#include "tremula/geometry/skeleton.hpp"
#include "tremula/modes/solve_modes.hpp"
#include "tremula/structure/structure.hpp"
#include "tremula/wind/gust_script.hpp"
#include "tremula/wind/point_wind.hpp"

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tremula {

// Told which stage begins ("structure", "modes", "wind", "loads", "response") and, while a long one runs, how
// much of it is done (0 … 1). May be called from several threads.
using Progress = std::function<void(std::string_view stage, double done)>;

struct BakeOptions {
  StructureOptions structure = {};  // of a tree
  FrameOptions frame = {};
  SheetOptions sheet = {};
  ModeOptions modes{.count = 20};
};

// What vibrates, and how it can.
struct Subject {
  Structure structure;
  Modes modes;
};

// How the wind becomes motion.
enum class Dynamics {
  modal,  // the modes of the whole plant, synthesised bin by bin (S)
  time,   // the same modes, integrated in time until they repeat: exact for forces linear between samples
  oscillators,  // every branch its own beam (F section 6.1, branch_oscillators.hpp), of trees alone
  flapping,     // a flag by the angles of its threads, as far as it goes (flapping.hpp), of sheets alone
};

struct Weather {
  Wind wind = turbulent_wind({}, 0.2);
  std::optional<double> ground =
      {};  // heights count from here [m]; not given: from the lowest node that is held
  LoadOptions loads = {};
  Dynamics dynamics = Dynamics::modal;
  BranchOscillatorOptions oscillators = {};  // of Dynamics::oscillators
  FlappingOptions flapping = {};             // of Dynamics::flapping; density and damping are those below
  Drag drag = Drag::linear;                  // of the gusts about the mean loads
  LeanOptions lean = {};
  Damping damping = {};
  Transfer transfer = Transfer::bin_averaged;
  bool static_correction = true;  // shapes for what the modes left out do
  TimeAxis loop{.period = 20, .sample_count = 600};
  // Pulled, and let go at t = 0 in the mean wind: a clip, in which no gusts are.
  std::optional<Pull> pull = {};
  // The wind scaled and turned from its reference speed and heading to these: a clip, whose drag is that of
  // the square of the wind at every instant.
  std::optional<GustScript> script = {};
  bool from_rest = false;  // the wind begins at t = 0, on what stands in still air: a clip as well
  bool makes_clip() const { return pull || script || from_rest; }
  std::vector<Gauge> gauges = {};  // what is read of the motion besides (dynamics/gauge.hpp)
  int most_strained = 0;           // and of how many branches that are strained most
};

// Throws InputError for a skeleton, a frame or a sheet that assemble does not take and for options out of
// range (see the stages).
Subject bake(const Skeleton& skeleton, const BakeOptions& options, const Progress& progress = {});
Subject bake(const Frame& frame, const BakeOptions& options, const Progress& progress = {});
Subject bake(const Sheet& sheet, const BakeOptions& options, const Progress& progress = {});

// What the user should know about a loop: modes above its highest frequency, wind that it is too short for,
// turbulence too large for linear loads and, where displacements are superposed (linear poses and morph
// targets), members stretched by more than 5 %. A line each.
std::vector<std::string> advice(const Subject& subject, const Weather& weather,
                                const MotionStatistics& statistics, bool superposed = true);

// The loop, or the clip (Motion::repeats), that this weather gives the subject. `warnings`, where given,
// takes what the wind has to say, a line each. Throws InputError for settings out of range, and for a subject
// whose parts do not fit together.
Motion set_in_motion(const Subject& subject, const Weather& weather, const Progress& progress = {},
                     std::vector<std::string>* warnings = nullptr);
// The same for whoever can spare the modes: their shapes go into the motion and are not held twice.
Motion set_in_motion(const Structure& structure, Modes modes, const Weather& weather,
                     const Progress& progress = {}, std::vector<std::string>* warnings = nullptr);

}  // namespace tremula
