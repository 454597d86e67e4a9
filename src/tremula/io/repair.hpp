// From what a file says to a skeleton the later stages can work with. Where people's scans are known to be
// untidy this mends and counts; where a file cannot be a plant it throws (docs/guide/inputs.md lists both).
#pragma once

#include "tremula/geometry/skeleton.hpp"
#include "tremula/io/skeleton_files.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace tremula {

// A branch as a file gives it, its numbers already known to be finite and its radii above 0.
struct RawBranch {
  Vec3 start = Vec3::Zero(), end = Vec3::Zero();  // [m]
  double start_radius = 0, end_radius = 0;        // [m]
  int parent = -1;        // branch it grows from, anywhere in the file, or -1: from a root
  int root = 0;           // where there is no parent: which root
  std::size_t place = 0;  // line of the file, or number of the cylinder
  double wall = 1;        // as Branch::wall
};

struct RawTree {
  std::string path;
  bool place_is_line = true;
  std::vector<Vec3> roots;  // [m]
  std::vector<RawBranch> branches;
  std::vector<Leaf> leaves;     // Leaf::branch is an index into `branches`
  Vec3 origin = Vec3::Zero();   // what the file says was subtracted already [m]
  double resolution = 0x1p-52;  // relative spacing of the file's numbers: 2^-23 for single precision
  bool exact = false;           // written by write_swc: it is taken as it stands
  std::vector<Repair> repairs;  // what the reader mended itself
};

// Which end of its parent carries a branch.
enum class CarrierRule {
  end,         // always the end
  nearer_end,  // the end or the start, whichever is nearer to the branch's own start
};

// Roots near the ground (within 5 % of the plant's height of the base) are clamped; the branches on any other
// are joined to the nearest branch. The base is the lowest root among the pieces that hold at least a tenth
// of the wood of the largest. What starts farther from its carrier than a scan can explain is refused unless
// options.allow_gaps; the bounds stand in repair.cpp.
//
// `most_visits`: boxes and branches looked at before joining loose pieces gives up; seconds of work, and
// hundreds of times what real scans need.
ImportedSkeleton repair(RawTree tree, const std::string& format, CarrierRule rule,
                        const ReadOptions& options = {}, std::size_t most_visits = 1'000'000'000);

}  // namespace tremula
