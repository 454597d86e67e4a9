// Small sheets for the tests, made here.
#pragma once

#include "tremula/structure/sheet.hpp"

#include <cmath>

namespace tremula::test {

// Steel, a square metre, 16 x 16 elements, in x and z.
inline Sheet steel_sheet(int across = 16, int up = 16) {
  Sheet sheet;
  sheet.width = sheet.height = 1;
  sheet.thickness = 0.005;
  sheet.youngs_modulus = 200e9;
  sheet.density = 7850;
  sheet.elements = {across, up};
  return sheet;
}

inline Sheet with_elements(Sheet sheet, int count) {
  sheet.elements = {count, count};
  return sheet;
}

// omega a^2 sqrt(rho h / D) of a mode of frequency f [Hz] of a sheet that is a wide.
inline double plate_number(const Sheet& sheet, double frequency) {
  const PlateSection section =
      plate_section(sheet.thickness, sheet.youngs_modulus, sheet.poisson_ratio, sheet.density);
  return 2 * 3.14159265358979323846 * frequency * sheet.width * sheet.width *
         std::sqrt(section.mass_per_area / section.bending_stiffness);
}

}  // namespace tremula::test
