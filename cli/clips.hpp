// Several winds in one .glb, by flag.
#pragma once

#include <string>
#include <vector>

#include "tremula/dynamics/motion.hpp"

namespace tremula::cli {

struct NamedWind {
  std::string name;   // of the clip
  double wind_speed;  // [m/s]
};

// "calm:2". Throws InputError that names the flag: for a text without name or speed, a speed outside 0 to 100
// m/s, and two of one name.
std::vector<NamedWind> parse_clips(const std::vector<std::string>& texts);

// The lean of a motion without its gusts: one sample.
Motion lean_alone(Motion motion);

}  // namespace tremula::cli
