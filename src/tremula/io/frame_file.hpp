// Frames from TOML: beams between named points, and plates that these carry (.toml).
//
//   name = "pergola"
//   material = "birch"                 # of every beam that names none
//   pieces = 4                        # that every beam is cut into; frequencies converge as it grows
//   clamped = ["left", "right"]       # points that neither move nor turn
//
//   [points]                          # [m], z up
//   left = [0, 0, 0]
//   top = [0, 0, 2.4]
//
//   [[beams]]
//   through = ["left", "top"]         # two points or more
//   radius = 0.05                     # [m], or from the first point to the last: [0.05, 0.03]
//   wall = 0.003                      # of a tube [m]; none: solid
//
//   [[masses]]
//   at = "top"
//   mass = 2.5                        # [kg]
//
//   [[panels]]                        # width … elements as in sheet_file.hpp, elements = [8, 8] if not given
//   corner = [-0.3, 0.05, 1.8]        # where the left bottom corner is [m]
//   along_width = [1, 0, 0]           # the way from left to right, at right angles to
//   along_height = [0, 0, 1]          # the way up; these two if not given
//   fixed = [[0.3, 0.2, "top"]]       # places from that corner [m], and the points that hold them
#pragma once

#include "tremula/structure/frame.hpp"

#include <string>

namespace tremula {

struct FrameFile {
  std::string name;  // as the file gives it; empty where it does not
  Frame frame;
};

// Throws InputError that names the file, the line and the column for what is no frame: other keys than these,
// values of another kind, points that are not there, and what assemble_frame refuses; Error for a file that
// cannot be read.
FrameFile read_frame(const std::string& path);

// The same from the text of a file. `name`: for messages.
FrameFile parse_frame(const std::string& text, const std::string& name);

}  // namespace tremula
