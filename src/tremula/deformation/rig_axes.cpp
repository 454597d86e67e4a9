#include "tremula/deformation/rig_axes.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tremula::rig {
namespace {

// (N) Whether the bark of a branch goes on from that of its parent: one tube has both.
std::vector<char> joined_by_bark(const BeamTree& tree, const Surface& surface) {
  std::vector<char> joined(tree.parent.size());
  for (const SurfacePart& part : surface.parts) {
    const std::vector<std::uint32_t>& corners = part.triangles;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const auto k = surface.branch[corners[i]], other = surface.branch[corners[i % 3 == 2 ? i - 2 : i + 1]];
      if (tree.parent[index_of(k)] == other) joined[index_of(k)] = 1;
      if (tree.parent[index_of(other)] == k) joined[index_of(other)] = 1;
    }
  }
  return joined;
}

// Which branch goes on where another ends: the one whose bark does, since joints of another axis would tear
// at that; thick and straight ones first where there is no bark.
std::vector<int> continuations(const BeamTree& tree, const Surface& surface) {
  const auto count = index_of(tree.branch_count());
  const std::vector<char> joined = joined_by_bark(tree, surface);
  std::vector<int> next(count, -1);
  std::vector<double> best(count, -1);
  for (std::size_t k = 0; k < count; ++k) {
    if (tree.parent[k] < 0) continue;
    const auto p = index_of(tree.parent[k]);
    const Member& member = tree.members[k];
    const double straight = 1 + member.direction.dot(tree.members[p].direction);
    const double score = (joined[k] != 0 ? 1e6 : 1) * member.beam.start_radius * straight;
    if (score <= best[p]) continue;
    best[p] = score;
    next[p] = static_cast<int>(k);
  }
  return next;
}

// The vertices of a ring stand at one place along their branch; those of a collar each at their own. Where
// the last of these stands on an axis, its skin is no longer that of the one below.
void hold_collars(const BeamTree& tree, const Places& places, const Surface& surface, Axes& all) {
  std::vector<double> last(all.axes.size());
  const std::size_t count = surface.vertex_count();
  const auto same = [&](std::size_t i, std::size_t j) {
    return surface.branch[i] == surface.branch[j] && surface.along[i] == surface.along[j];
  };
  for (std::size_t first = 0, end = 0; first < count; first = end) {
    for (end = first + 1; end < count && same(first, end);) ++end;
    const auto k = index_of(surface.branch[first]);
    const auto a = index_of(all.of_branch[k]);
    const double way = all.way[k] + static_cast<double>(surface.along[first]) * tree.members[k].beam.length;
    if (end - first < 3 && way < 0.7 * all.axes[a].reached.back()) last[a] = std::max(last[a], way);
  }
  for (std::size_t a = 0; a < last.size(); ++a) {
    Axis& axis = all.axes[a];
    if (axis.is_stem) continue;
    axis.held = std::min(last[a], 0.5 * axis.reached.back());
    while (axis.reached[index_of(axis.free)] <= axis.held) ++axis.free;
    const auto k = index_of(places.branch[index_of(axis.places[index_of(axis.free)])]);
    axis.start = tree.members[k].start + (axis.held - all.way[k]) * tree.members[k].direction;
  }
}

// A branch and the place along it where leaves sit.
using Seat = std::pair<std::int32_t, float>;

// Each once, in the order of the branches.
std::vector<Seat> seats_of_leaves(const Surface& surface, const std::vector<char>& in_piece) {
  std::vector<Seat> seats;
  for (std::size_t i = 0; i < surface.vertex_count(); ++i) {
    if (in_piece[i] == 0) continue;
    const Seat seat{surface.branch[i], surface.along[i]};
    if (seats.empty() || seats.back() != seat) seats.push_back(seat);
  }
  std::sort(seats.begin(), seats.end());
  seats.erase(std::unique(seats.begin(), seats.end()), seats.end());
  return seats;
}

}  // namespace

std::vector<char> vertices_of_pieces(const Surface& surface) {
  std::vector<char> in_piece(surface.vertex_count());
  for (const SurfacePart& part : surface.parts) {
    for (std::uint32_t v = 0; v < part.pieces.size * part.pieces.count; ++v)
      in_piece[part.pieces.first_vertex + v] = 1;
  }
  return in_piece;
}

Places find_places(const BeamTree& tree, const Surface& surface, const std::vector<int>& pieces) {
  Places places;
  const auto add = [&](int k, double s) {
    places.branch.push_back(k);
    places.s.push_back(s);
    places.rest.push_back(tree.members[index_of(k)].point(s));
  };
  for (int k = 0; k < tree.branch_count(); ++k) {
    const bool stands = tree.parent[index_of(k)] < 0;
    places.foot.push_back(stands ? places.count() : -1);
    if (stands) add(k, 0);
    places.first.push_back(places.count());
    places.pieces.push_back(pieces[index_of(k)]);
    for (int i = 1; i <= pieces[index_of(k)]; ++i) add(k, static_cast<double>(i) / pieces[index_of(k)]);
  }
  places.leaves_from = places.count();
  const std::vector<char> in_piece = vertices_of_pieces(surface);
  const std::vector<Seat> seats = seats_of_leaves(surface, in_piece);
  for (const auto& [k, s] : seats) add(k, static_cast<double>(s));
  places.reach.assign(places.branch.size(), 0);
  for (std::size_t i = 0; i < surface.vertex_count(); ++i) {
    const auto k = index_of(surface.branch[i]);
    const auto s = static_cast<double>(surface.along[i]);
    const double arm = (surface.position[i].cast<double>() - tree.members[k].point(s)).norm();
    const int piece = std::clamp(static_cast<int>(std::ceil(s * places.pieces[k])), 1, places.pieces[k]);
    std::ptrdiff_t place = places.first[k] + piece - 1;
    if (in_piece[i] != 0) {
      const Seat seat{surface.branch[i], surface.along[i]};
      place = places.leaves_from + (std::lower_bound(seats.begin(), seats.end(), seat) - seats.begin());
    }
    places.reach[index_of(place)] = std::max(places.reach[index_of(place)], arm);
  }
  return places;
}

std::vector<double> reach_of_branches(const Places& places) {
  std::vector<double> reach(places.first.size());
  for (std::size_t p = 0; p < places.branch.size(); ++p) {
    double& most = reach[index_of(places.branch[p])];
    most = std::max(most, places.reach[p]);
  }
  return reach;
}

Axes find_axes(const BeamTree& tree, const Places& places, const Surface& surface) {
  const std::vector<int> next = continuations(tree, surface);
  Axes all;
  all.of_branch.assign(tree.parent.size(), -1);
  all.way.assign(tree.parent.size(), 0);
  for (int first = 0; first < tree.branch_count(); ++first) {
    const int parent = tree.parent[index_of(first)];
    if (parent >= 0 && next[index_of(parent)] == first) continue;
    Axis axis{.base = parent < 0 ? places.foot[index_of(first)] : places.end_of(parent),
              .foot = tree.members[index_of(first)].start,
              .start = tree.members[index_of(first)].start,
              .is_stem = parent < 0};
    if (parent >= 0) axis.depth = 1 + all.axes[index_of(all.of_branch[index_of(parent)])].depth;
    double way = 0;
    for (int k = first; k >= 0; k = next[index_of(k)]) {
      const double length = tree.members[index_of(k)].beam.length;
      all.of_branch[index_of(k)] = static_cast<int>(all.axes.size());
      all.way[index_of(k)] = way;
      for (int i = 0; i < places.pieces[index_of(k)]; ++i) {
        const int place = places.first[index_of(k)] + i;
        axis.places.push_back(place);
        axis.reached.push_back(way + places.s[index_of(place)] * length);
      }
      way += length;
    }
    all.axes.push_back(std::move(axis));
  }
  for (int place = places.leaves_from; place < places.count(); ++place) {
    const auto k = index_of(places.branch[index_of(place)]);
    Axis& axis = all.axes[index_of(all.of_branch[k])];
    axis.leaves.push_back(place);
    axis.leaf_way.push_back(all.way[k] + places.s[index_of(place)] * tree.members[k].beam.length);
  }
  hold_collars(tree, places, surface, all);
  return all;
}

PlacePose pose_of(const BeamTree& tree, const Places& places, const std::vector<BentBranch>& bent,
                  int place) {
  const auto k = index_of(places.branch[index_of(place)]);
  const double s = places.s[index_of(place)];
  if (s == 1) return {bent[k].end, bent[k].end_frame};
  const BentPoint point = point_on(tree.members[k], bent[k], s);
  return {point.position, point.frame};
}

}  // namespace tremula::rig
