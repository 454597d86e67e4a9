// Reads plants from the files people have, recognised by what stands in them rather than by their name.
#pragma once

#include "tremula/geometry/skeleton.hpp"

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tremula {

// Something the reader mended because scans really look so; never silent.
struct Repair {
  std::string kind;  // stable key for reports: "recentred", "joined_to_nearest", "collapsed_zero_length", …
  std::size_t count;    // how many branches (or nodes) it touched
  std::string message;  // one sentence for people: "9 segments without parent joined to the nearest branch"
};

// What a plant looks like where its file says so; sRGB, 0–1.
struct PlantColors {
  std::optional<Eigen::Vector3f> bark = {}, leaf = {};
};

struct ImportedSkeleton {
  Skeleton skeleton;
  // "swc", "treeqsm-text", "treeqsm-mat", "simpleforest-csv", "archi-table", "rtwig-table",
  // "treegraph-table", "raycloud-tree"
  std::string format;
  std::vector<Repair> repairs;
  PlantColors colors = {};
};

struct ReadOptions {
  double unit = 1;          // length of one unit of the file [m]
  bool allow_gaps = false;  // join what starts far from the branch that carries it, however far
};

// Throws InputError for anything that is not a usable plant (see docs/guide/inputs.md for what is repaired).
ImportedSkeleton read_skeleton(const std::string& path, const ReadOptions& options = {});

// The same from bytes already in memory; `path` is for messages.
ImportedSkeleton read_skeleton(std::string_view bytes, const std::string& path,
                               const ReadOptions& options = {});

// SWC: one sample per node, comments with units and origin; reading it back gives the same branches.
std::string encode_swc(const Skeleton& skeleton, const PlantColors& colors = {});
void write_swc(const Skeleton& skeleton, const std::string& path, const PlantColors& colors = {});

}  // namespace tremula
