// What a reader must stand: any bytes at all. A harness gives a reader some bytes and holds it to its word:
// the bytes are refused in one line, or what comes of them is as the headers promise. libFuzzer drives the
// harnesses for hours (libfuzzer.cpp, scripts/fuzz.sh), the test suite for a second each (fuzz_test.cpp), and
// replay.cpp tries single files.
#pragma once

#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace tremula::fuzz {

// A promise that was not kept. What a harness throws is a finding, of this type or any other.
struct Broken : std::logic_error {
  using std::logic_error::logic_error;
};

struct Harness {
  std::string name;
  void (*try_input)(std::string_view bytes);
  std::vector<std::string> (*seeds)();
  std::vector<std::string> words;  // that the format is made of, for mutation
};

const std::vector<Harness>& harnesses();
const Harness& harness_named(std::string_view name);  // throws Broken for other names

inline void require(bool promise, const char* what) {
  if (!promise) throw Broken(what);
}

// The name under which harnesses give bytes to readers.
inline const std::string input_name = "input";

bool is_printable(std::string_view text);  // and short: what an error may say

// True where the reader takes the input; false where it refuses it as readers should: with an InputError of
// one printable line that begins with the name of the input. Everything else is passed on.
bool taken(const std::function<void()>& read);

// What a writer puts into the file that it is given the path of.
std::string bytes_written(const std::function<void(const std::string& path)>& write);

// Bytes as they could stand in a C++ string literal.
std::string escaped(std::string_view bytes);

// ---- The harnesses, by what they try (their registry is harness.cpp)

void try_swc(std::string_view bytes);
void try_treeqsm_text(std::string_view bytes);
void try_treeqsm_mat(std::string_view bytes);
void try_tables(std::string_view bytes);  // whose columns have names
void try_matlab(std::string_view bytes);
void try_skeleton(std::string_view bytes);
void try_lsystem(std::string_view bytes);
void try_turbsim(std::string_view bytes);
void try_spectrum(std::string_view bytes);
void try_profile(std::string_view bytes);
void try_motion(std::string_view bytes);     // a tree, baked and animated
void try_frame(std::string_view bytes);      // a frame from TOML, baked and animated
void try_scene(std::string_view bytes);      // a scene, its copies and its camera
void try_wind_file(std::string_view bytes);  // a field, measured, and blowing through a tree

std::vector<std::string> swc_seeds();
std::vector<std::string> treeqsm_text_seeds();
std::vector<std::string> matlab_seeds();
std::vector<std::string> table_seeds();
std::vector<std::string> skeleton_seeds();  // all of the above
std::vector<std::string> lsystem_seeds();
std::vector<std::string> frame_seeds();
std::vector<std::string> scene_seeds();
std::vector<std::string> turbsim_seeds();
std::vector<std::string> spectrum_seeds();
std::vector<std::string> profile_seeds();

}  // namespace tremula::fuzz
