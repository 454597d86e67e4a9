// Plant and weather as Stam 1997 has them, for the benchmarks that repeat his experiments.
#pragma once

#include "tremula/pipeline.hpp"

namespace tremula::bench {

// Appendix A: his material, the section as printed (errata S1), no weight.
inline StructureOptions paper_structure() {
  return {.material = find_material("paper"), .section = Section::paper, .gravity = 0};
}

// Sections 2 to 6: his wind, its rows of unit variance (errata S7), his loads and damping by mass, eq. 7 in
// every bin, the modes and nothing besides. By default his loop of section 7.
inline Weather paper_weather(const TimeAxis& loop = {256, 256}) {
  Weather weather;
  weather.wind = StamWind{};
  weather.loads.model = LoadModel::paper;
  weather.damping = {.mass_proportional = 0.5, .aerodynamic = false};
  weather.transfer = Transfer::sampled;
  weather.static_correction = false;
  weather.loop = loop;
  return weather;
}

}  // namespace tremula::bench
