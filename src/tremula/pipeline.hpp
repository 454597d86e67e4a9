// The cascade from end to end. Read this first: what depends on the plant alone is baked once; the wind and
// the motion vary. pipeline.cpp is the whole story.
#pragma once

#include "tremula/dynamics/loads.hpp"
#include "tremula/dynamics/motion.hpp"
#include "tremula/dynamics/reconfiguration.hpp"
#include "tremula/dynamics/response.hpp"
#include "tremula/geometry/skeleton.hpp"
#include "tremula/modes/solve_modes.hpp"
#include "tremula/structure/structure.hpp"
#include "tremula/wind/stam_wind.hpp"

#include <functional>
#include <string_view>

namespace tremula {

// Told which stage begins ("structure", "modes", "loads", "wind", "response") and, while a long one runs, how
// much of it is done (0 … 1). May be called from several threads.
using Progress = std::function<void(std::string_view stage, double done)>;

struct BakeOptions {
  StructureOptions structure = {};
  ModeOptions modes{.count = 20};
};

// A plant and how it can vibrate.
struct Subject {
  Skeleton skeleton;
  Structure structure;
  Modes modes;
};

struct Weather {
  StamWind wind = {};
  LoadOptions loads = {};
  Reconfiguration reconfiguration = {};
  Damping damping = {};
  TimeAxis loop{.period = 20, .sample_count = 600};
};

// Throws InputError for options out of range (see the stages).
Subject bake(const Skeleton& skeleton, const BakeOptions& options, const Progress& progress = {});

// The loop that this weather gives the subject. Throws InputError for settings out of range.
Motion set_in_motion(const Subject& subject, const Weather& weather, const Progress& progress = {});

}  // namespace tremula
