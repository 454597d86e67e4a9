// Is a field the wind it should be: its check in a few numbers, and in words.
#pragma once

#include "tremula/io/wind_plot.hpp"
#include "tremula/wind/field.hpp"

#include <array>
#include <string>
#include <vector>

namespace tremula {

// Numbers that need a target are 0 without one.
struct WindVerdict {
  std::size_t hub_row = 0;  // the row nearest the reference height
  bool has_targets = false;
  // By component: the rms change from the last step to the first, over that between other steps. Of a loop it
  // is about 1.
  std::array<double, 3> seam = {};
  double mean_error = 0;                                // largest of all rows, over the wanted at the hub
  std::array<std::array<double, 2>, 3> deviation = {};  // least and most of measured over wanted, of all rows
  std::array<double, 3> deviation_scatter = {};         // relative, of the sample that one loop is
  std::array<std::array<double, 2>, 3> spectrum = {};   // the same of bands of eight bins and more
  std::array<double, 3> coherence_rms = {};             // measured (real part) minus wanted, of such bands
  std::vector<std::string> faults = {};                 // a few words each; none: as wanted
};

// A fault is: a mean 2 % off; a deviation further off than three times the scatter of one loop and 2 %; an
// rms error of the coherence above 0.1; a loop with a seam twice what it should be.
WindVerdict judge_wind(const WindField& field, const WindReport& report);

// Rows of mean and deviation by height, from the top down (at most `most_rows`), and a line for each of the
// numbers above. Ends with a line break.
std::string verdict_text(const WindField& field, const WindReport& report, const WindVerdict& verdict,
                         std::size_t most_rows = 12);

}  // namespace tremula
