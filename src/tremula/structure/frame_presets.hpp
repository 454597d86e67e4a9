// The frames that come with tremula.
#pragma once

#include "tremula/structure/frame.hpp"

#include <string>
#include <vector>

#include <Eigen/Core>

namespace tremula {

struct FramePreset {
  std::string name;                         // "sign"
  std::string description;                  // one line
  Frame frame;                              // for a wind along x
  Eigen::Vector3f beam_color, panel_color;  // sRGB, 0–1
};

const std::vector<FramePreset>& frame_presets();

}  // namespace tremula
