// The page (.html) of what drifts: one small mesh of every material, drawn as often as any are seen, and the
// paths as a texture, from which the graphics card finds what make_loop finds (drift_pose.hpp): which path a
// mesh shows when, where that is, how it is turned. So the page closes with the loop and no number is made
// for it; a flake takes 6 bytes for every DriftPaths::step of its flight and 64 more (96 with turns), before
// they are packed.
//
// What the page reads (page_block.hpp), with the letters "TRMD":
// - meshes: (meshes + 1) of 32 bits, the first stay of each; those of one material after those of the other.
// - stays: (words x stays) of 32 bits, one word of all stays after the other, floats but for the last of the
//   first 16: taken, begin, end, birth (DriftStay); start x y z, unit, velocity x y z, air_time, size,
//   fall_speed, 1 where it lies afterwards, else 0, and the first of its samples (DriftPath). Leaves and
//   seeds have 8 more: phase, rate, yaw, yaw_rate, swing, glide, lean, 1 where it tumbles, else 0
//   (DriftTurns).
// - samples: (samples x 3) of 16 bits signed, DriftPaths::off_line as it is.
#pragma once

#include "tremula/deformation/drift_pose.hpp"

#include <string>

namespace tremula {

// More make a page that browsers take long to open. [bytes] before they are packed.
inline constexpr double most_bytes_of_drift = 32e6;

// The share of the paths that a page holds, 0 to 1; less than 1: thin them first.
double share_of_page(const DriftPaths& paths);

// `paths` of the drift, of which `share` are left. The same paths give the same bytes. Throws InputError for
// paths of none, for more than a quarter over most_bytes_of_drift, and for numbers that are not finite.
std::string encode_drift(const Drift& drift, const DriftPaths& paths, double share, const DriftLook& look,
                         const LoopFacts& facts);

// Throws Error as encode_html() does, and as encode_drift().
std::string encode_drift_page(const Drift& drift, const DriftPaths& paths, double share,
                              const DriftLook& look, const LoopFacts& facts);

}  // namespace tremula
