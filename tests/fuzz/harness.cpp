#include "harness.hpp"

#include "tremula/base/error.hpp"
#include "tremula/io/atomic_file.hpp"

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <sstream>

#include "support.hpp"

namespace tremula::fuzz {
namespace {

// What texts of numbers are made of, whatever their columns.
constexpr std::string_view numbers =
    "0 1 -1 7 0.5 -0.0 1e9 1e-12 1e300 1e-300 1e999 2147483648 9223372036854775807 nan inf 360";

// Words with blanks between them, the numbers, and what stands between fields and lines.
std::vector<std::string> text_words(const std::string& format) {
  std::istringstream all(format + ' ' + std::string(numbers));
  std::vector<std::string> words(std::istream_iterator<std::string>(all), {});
  for (const char* separator : {"\n", "\r\n", "\t", " ", ",", ";", "\"", "#"}) words.emplace_back(separator);
  return words;
}

// Bytes in hexadecimal, a blank between two words.
std::vector<std::string> binary_words(const std::string& hexadecimal) {
  std::istringstream all(hexadecimal);
  std::vector<std::string> words;
  for (std::string digits; all >> digits;) {
    std::string& word = words.emplace_back();
    for (std::size_t i = 0; i + 1 < digits.size(); i += 2)
      word += static_cast<char>(std::stoi(digits.substr(i, 2), nullptr, 16));
  }
  return words;
}

std::vector<std::string> swc_words() {
  std::vector<std::string> words = text_words("id type x y z radius parent 16");
  for (const char* comment :
       {"# tremula skeleton\n", "# origin ", "# leaf ", "# bark_color ", "# leaf_color "})
    words.emplace_back(comment);
  return words;
}

std::vector<std::string> table_words() {
  return text_words(
      "ID parentID startX startY startZ endX endY endZ radius length start axis axis_direction cyl_id parent "
      "parent_id "
      "start.1 p1 p2 sx ex ax x y z section_id extension branch");
}

std::vector<std::string> matlab_words() {
  std::vector<std::string> words = binary_words(
      "0e000000 0f000000 0600000008000000 0500000008000000 0100030051534d 0001 ffffffff ffffff7f 09000000 "
      "07000000 "
      "000000000000f07f 000000000000f87f");
  for (const char* name : {"QSM", "QSMs", "OptQSM", "qsm", "cylinder", "radius", "length", "start", "axis",
                           "parent", "Rad", "Len", "Sta", "Axe", "CPar", "IM", "MI"})
    words.emplace_back(name);
  return words;
}

std::vector<std::string> turbsim_words() {
  return binary_words(
      "0700 0800 01000000 02000000 0000803f 0000807f 0000c07f ffffff7f ffffffff 00000080 286b6e4e "
      "0100000000000000");
}

std::vector<std::string> lsystem_words() {
  std::vector<std::string> words = text_words(
      "axiom: steps: seed: radius: pipe drawn tip_radius: pipe_exponent: pipe_taper: leaf_shape_factor: "
      "leaf_mass_per_area: bark_color: leaf_color: -> : = F( f( L( T( !( +( -( &( ^( /( \\( $ [ ] ) min( "
      "max( floor( "
      "ceil( round( abs( sqrt( pow( exp( log( sin( cos( if( rand( normal( height() && || == != <= >= % ^ * "
      "+");
  words.emplace_back("\n ");
  return words;
}

std::vector<std::string> frame_words() {
  return text_words(
      "name material pieces clamped [points] [[beams]] through radius [[masses]] at mass = [ ] \"a\" \"oak\" "
      "1e-3 "
      "nan inf { } ''' # 1979-05-27");
}

std::vector<std::string> scene_words() {
  return text_words(
      "[wind] [motion] [ground] [sky] [medium] [camera] [[camera.path]] [picture] [[objects]] "
      "[[objects.instances]] [[objects.grid]] [[objects.scatter]] = [ ] { } \"oak\" \"random\" source "
      "position "
      "turn scale density low high distance inside outside columns rows spacing eye look_at time aperture "
      "frame "
      "true false \"\"\" ''' # 1979-05-27");
}

std::vector<std::string> spectrum_words() {
  return text_words("frequency S_u S_v S_w k1_rad_per_m Fu Fv Fw");
}

std::vector<std::string> profile_words() {
  return text_words("height_m z[m] speed_m_s U(m/s) direction_deg heading [deg] [m] [m/s] \xC2\xB0");
}

std::vector<std::string> skeleton_words() {
  std::vector<std::string> words = swc_words();
  for (const std::string& word : table_words()) words.push_back(word);
  return words;
}

}  // namespace

bool is_printable(std::string_view text) {
  return text.size() < 1000 &&
         std::all_of(text.begin(), text.end(), [](char c) { return c >= 0x20 && c < 0x7F; });
}

const std::vector<Harness>& harnesses() {
  static const std::vector<Harness> all = {
      {"swc", try_swc, swc_seeds, swc_words()},
      {"treeqsm_text", try_treeqsm_text, treeqsm_text_seeds, table_words()},
      {"treeqsm_mat", try_treeqsm_mat, matlab_seeds, matlab_words()},
      {"tables", try_tables, table_seeds, table_words()},
      {"matlab", try_matlab, matlab_seeds, matlab_words()},
      {"skeleton", try_skeleton, skeleton_seeds, skeleton_words()},
      {"lsystem", try_lsystem, lsystem_seeds, lsystem_words()},
      {"turbsim", try_turbsim, turbsim_seeds, turbsim_words()},
      {"spectrum", try_spectrum, spectrum_seeds, spectrum_words()},
      {"profile", try_profile, profile_seeds, profile_words()},
      {"motion", try_motion, skeleton_seeds, skeleton_words()},
      {"frame", try_frame, frame_seeds, frame_words()},
      {"scene", try_scene, scene_seeds, scene_words()},
      {"wind_file", try_wind_file, turbsim_seeds, turbsim_words()},
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
