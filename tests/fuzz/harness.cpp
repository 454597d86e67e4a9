#include "harness.hpp"

#include "tremula/base/error.hpp"
#include "tremula/io/atomic_file.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "support.hpp"

namespace tremula::fuzz {
namespace {

const std::vector<std::string> numbers = {"0",   "-1",     "1",   "1e9", "1e-12",      "1e300", "-0.0",
                                          "0.5", "1e-300", "nan", "inf", "2147483648", "1e999", "7"};

std::vector<std::string> with_numbers(std::vector<std::string> words) {
  words.insert(words.end(), numbers.begin(), numbers.end());
  return words;
}

const std::vector<std::string> swc_words =
    with_numbers({"# tremula skeleton\n", "# origin ", "# leaf ", "# bark_color ", "# leaf_color ", "\n",
                  "\r\n", " -1\n", " 16 ", "#"});
const std::vector<std::string> treeqsm_words = with_numbers(
    {"radius", "length", "start", "axis", "parent", "extension", "branch", "\t", ",", ";", "\n", "\""});
const std::vector<std::string> table_words = with_numbers({"ID",
                                                           "parentID",
                                                           "startX",
                                                           "startY",
                                                           "startZ",
                                                           "endX",
                                                           "endY",
                                                           "endZ",
                                                           "radius",
                                                           "length",
                                                           "axis_direction",
                                                           "cyl_id",
                                                           "parent",
                                                           "parent_id",
                                                           "start.1",
                                                           "p1",
                                                           "p2",
                                                           "sx",
                                                           "ex",
                                                           "ax",
                                                           "x",
                                                           "y",
                                                           "z",
                                                           "section_id",
                                                           ", ",
                                                           ",",
                                                           ";",
                                                           "	",
                                                           "
                                                           ", "\""});
const std::vector<std::string> matlab_words = {std::string("\x0e\0\0\0", 4),
                                               std::string("\x0f\0\0\0", 4),
                                               std::string("\x06\0\0\0\x08\0\0\0", 8),
                                               std::string("\x05\0\0\0\x08\0\0\0", 8),
                                               std::string("\x01\0\x03\0QSM", 8),
                                               "cylinder",
                                               "radius",
                                               "length",
                                               "start",
                                               "axis",
                                               "parent",
                                               "QSMs",
                                               "OptQSM",
                                               "qsm",
                                               "Rad",
                                               "Len",
                                               "Sta",
                                               "Axe",
                                               "CPar",
                                               "IM",
                                               "MI",
                                               std::string("\0\1", 2),
                                               std::string("\xff\xff\xff\xff", 4),
                                               std::string("\xff\xff\xff\x7f", 4),
                                               std::string("\x09\0\0\0", 4),
                                               std::string("\x07\0\0\0", 4),
                                               std::string("\0\0\0\0\0\0\xf0\x7f", 8),
                                               std::string("\0\0\0\0\0\0\xf8\x7f", 8)};
const std::vector<std::string> lsystem_words = with_numbers({"axiom: ",
                                                             "steps: ",
                                                             "seed: ",
                                                             "radius: ",
                                                             "pipe",
                                                             "drawn",
                                                             "tip_radius: ",
                                                             "pipe_exponent: ",
                                                             "pipe_taper: ",
                                                             "leaf_shape_factor: ",
                                                             "leaf_mass_per_area: ",
                                                             "bark_color: ",
                                                             "leaf_color: ",
                                                             " -> ",
                                                             " : ",
                                                             "F(",
                                                             "f(",
                                                             "L(",
                                                             "T(",
                                                             "!(",
                                                             "+(",
                                                             "-(",
                                                             "&(",
                                                             "^(",
                                                             "/(",
                                                             "\\(",
                                                             "$",
                                                             "[",
                                                             "]",
                                                             "min(",
                                                             "max(",
                                                             "floor(",
                                                             "ceil(",
                                                             "round(",
                                                             "abs(",
                                                             "sqrt(",
                                                             "pow(",
                                                             "exp(",
                                                             "log(",
                                                             "sin(",
                                                             "cos(",
                                                             "if(",
                                                             "rand(",
                                                             "normal(",
                                                             "height()",
                                                             "&&",
                                                             "||",
                                                             "==",
                                                             "!=",
                                                             "<=",
                                                             ">=",
                                                             "%",
                                                             "\n",
                                                             "\n ",
                                                             "# "});
const std::vector<std::string> turbsim_words = {
    std::string("\x07\0", 2),       std::string("\x08\0", 2),           std::string("\1\0\0\0", 4),
    std::string("\2\0\0\0", 4),     std::string("\0\0\x80\x3f", 4),     std::string("\0\0\x80\x7f", 4),
    std::string("\0\0\xc0\x7f", 4), std::string("\xff\xff\xff\x7f", 4), std::string("\xff\xff\xff\xff", 4),
    std::string("\0\0\0\x80", 4),   std::string("\x28\x6b\x6e\x4e", 4), std::string("\1\0\0\0\0\0\0\0", 8)};
const std::vector<std::string> spectrum_words = with_numbers(
    {"frequency", "S_u", "S_v", "S_w", "k1_rad_per_m", "Fu", "Fv", "Fw", ",", ";", "\t", "\n", "#"});

const std::vector<std::string> profile_words =
    with_numbers({"height_m", "z [m]", "speed_m_s", "U (m/s)", "direction_deg", "heading", " [deg]", " [",
                  "(", "\xC2\xB0", ",", ";", "\t", "\n", "#", "360", "100"});

std::vector<std::string> all_skeleton_words() {
  std::vector<std::string> words;
  for (const auto* some : {&swc_words, &treeqsm_words, &table_words})
    words.insert(words.end(), some->begin(), some->end());
  std::sort(words.begin(), words.end());
  words.erase(std::unique(words.begin(), words.end()), words.end());
  return words;
}

}  // namespace

bool is_printable(std::string_view text) {
  return text.size() < 1000 &&
         std::all_of(text.begin(), text.end(), [](char c) { return c >= 0x20 && c < 0x7F; });
}

const std::vector<Harness>& harnesses() {
  static const std::vector<Harness> all = {
      {"swc", try_swc, swc_seeds, swc_words},
      {"treeqsm_text", try_treeqsm_text, treeqsm_text_seeds, treeqsm_words},
      {"treeqsm_mat", try_treeqsm_mat, matlab_seeds, matlab_words},
      {"tables", try_tables, table_seeds, table_words},
      {"matlab", try_matlab, matlab_seeds, matlab_words},
      {"skeleton", try_skeleton, skeleton_seeds, all_skeleton_words()},
      {"lsystem", try_lsystem, lsystem_seeds, lsystem_words},
      {"turbsim", try_turbsim, turbsim_seeds, turbsim_words},
      {"spectrum", try_spectrum, spectrum_seeds, spectrum_words},
      {"profile", try_profile, profile_seeds, profile_words},
      {"motion", try_motion, skeleton_seeds, all_skeleton_words()},
      {"wind_file", try_wind_file, turbsim_seeds, turbsim_words},
  };
  return all;
}

const Harness& harness_named(std::string_view name) {
  std::string names;
  for (const Harness& harness : harnesses()) {
    if (harness.name == name) return harness;
    names += ' ' + harness.name;
  }
  throw Broken("no harness '" + std::string(name) + "', wanted one of" + names);
}

bool taken(const std::function<void()>& read) {
  try {
    read();
    return true;
  } catch (const InputError& error) {
    const std::string_view message = error.what();
    if (!is_printable(message) || !message.starts_with(input_name))
      throw Broken("refused, but not in one line that names the input: " + std::string(message));
    return false;
  }
}

std::string bytes_written(const std::function<void(const std::string& path)>& write) {
  static const test::TemporaryFolder folder;
  const std::string path = folder / "written";
  write(path);
  return read_file(path);
}

std::string escaped(std::string_view bytes) {
  std::string text;
  for (const char c : bytes) {
    const auto code = static_cast<unsigned char>(c);
    if (c == '\n') {
      text += "\\n";
    } else if (code >= 0x20 && code < 0x7F && c != '"' && c != '\\') {
      text += c;
    } else {
      char octal[8];
      std::snprintf(octal, sizeof octal, "\\%03o", code);
      text += octal;
    }
  }
  return text;
}

}  // namespace tremula::fuzz
