// The sheets that come with tremula.
#pragma once

#include "tremula/structure/sheet.hpp"

#include <string>
#include <vector>

namespace tremula {

struct SheetPreset {
  std::string name;         // "flag"
  std::string description;  // one line
  Sheet sheet;              // for a wind along x
  Eigen::Vector3f color;    // sRGB, 0–1
};

const std::vector<SheetPreset>& sheet_presets();

}  // namespace tremula
