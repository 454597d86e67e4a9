// Where joints may sit: places along the axes of a tree, and how these move. Internal to the deformation.
#pragma once

#include "tremula/base/types.hpp"
#include "tremula/geometry/surface.hpp"
#include "tremula/structure/bent_tree.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace tremula::rig {

// Places on the axes: the foot of every stem, and on every branch `pieces` of them at even steps, the last at
// its end. In the order of the branches. After these, no place for joints, where leaves sit.
struct Places {
  std::vector<int> first, pieces;  // (N) the first place of a branch beyond its start, and how many
  std::vector<int> foot;           // (N) of a stem's lowest branch; -1
  std::vector<int> branch;         // (P)
  std::vector<double> s;           // (P) 0 start … 1 end
  std::vector<Vec3> rest;          // (P) [m]
  std::vector<double> reach;  // (P) how far off the axis the bark goes that is nearest, or a leaf there [m]
  int leaves_from = 0;        // the first that has leaves or other pieces that keep their shape

  int count() const { return static_cast<int>(branch.size()); }
  int end_of(int k) const { return first[index_of(k)] + pieces[index_of(k)] - 1; }
};

// A chain of branches, each of which goes on best where the one below it ends.
struct Axis {
  int base = -1;              // the place that carries it
  Vec3 foot = Vec3::Zero();   // where it begins, a rigid arm from there [m]
  Vec3 start = Vec3::Zero();  // where its joints begin, beyond the collar that sits on what carries it [m]
  double held = 0;            // the way along the axis to there [m]
  int free = 0;               // the first place beyond that, by its order
  bool is_stem = false;       // stands on the ground
  int depth = 0;              // how many axes carry it
  std::vector<int> places{};  // beyond the start
  std::vector<double> reached{};   // at every place, the way along the axis from its start [m]
  std::vector<int> leaves{};       // places where they sit
  std::vector<double> leaf_way{};  // to there [m]
};

struct Axes {
  std::vector<Axis> axes;      // those that carry before those that are carried
  std::vector<int> of_branch;  // (N)
  std::vector<double> way;     // (N) along its axis to the start of a branch [m]
};

// (V) Which vertices belong to leaves and others of many alike (Pieces).
std::vector<char> vertices_of_pieces(const Surface& surface);

Places find_places(const BeamTree& tree, const Surface& surface, const std::vector<int>& pieces);
// (N) How far off each branch its skin goes, leaves and all [m].
std::vector<double> reach_of_branches(const Places& places);
Axes find_axes(const BeamTree& tree, const Places& places, const Surface& surface);

struct PlacePose {
  Vec3 position = Vec3::Zero();  // [m]
  Mat3 frame = Mat3::Identity();
};
PlacePose pose_of(const BeamTree& tree, const Places& places, const std::vector<BentBranch>& bent, int place);

}  // namespace tremula::rig
