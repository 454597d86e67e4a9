// Sheets from TOML (.toml): a plate, a sign, a flag, a curtain.
//
//   name = "sign"
//
//   [sheet]
//   width = 0.6                       # [m]
//   height = 0.4
//   thickness = 0.002
//   youngs_modulus = 70e9             # [Pa]
//   poisson_ratio = 0.33              # 0.3 where it is not given
//   density = 2700                    # [kg/m^3]
//   elements = [24, 16]               # along width and height; frequencies converge as they grow
//   clamp = ["bottom"]                # edges that neither move nor turn: left, right, bottom, top
//   pin = ["left"]                    # edges that do not move
//   points = [[0.6, 0.4]]             # places that do not move, from the left bottom corner [m]
//   tension = [40, 0]                 # along width and height [N/m], besides what the weight makes
//   cloth = false                     # true: folds where it is pressed in its plane, and carries only pull
//   corner = [0, 0, 2]                # where the left bottom corner is [m], z up
//   heading = 0                       # the way from left to right, from x towards y [degrees]
#pragma once

#include "tremula/structure/sheet.hpp"

#include <string>

namespace tremula {

struct SheetFile {
  std::string name;  // as the file gives it; empty where it does not
  Sheet sheet;
};

// Whether the text of a .toml file is about a sheet: it has a [sheet], or the key alone.
bool is_sheet_file(const std::string& text);

// Throws InputError that names the file, the line and the column for what is no sheet: other keys than these,
// values of another kind, what check_sheet refuses, a sheet that nothing holds; Error for a file that cannot
// be read.
SheetFile read_sheet(const std::string& path);

// The same from the text of a file. `name`: for messages.
SheetFile parse_sheet(const std::string& text, const std::string& name);

}  // namespace tremula
