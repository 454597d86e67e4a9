#include "tremula/io/repair.hpp"

#include "tremula/base/error.hpp"
#include "tremula/io/nearest_branch.hpp"
#include "tremula/io/text_table.hpp"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <numbers>
#include <utility>

namespace tremula {
namespace {

// Ends nearer than this share of the plant's size are in one place; a branch that short has no length.
constexpr double same_place = 1e-9;
// Roots up to this share of the plant's height above the lowest are in the ground.
constexpr double near_the_ground = 0.05;
// No plant is as large as this [m]; the tallest tree, read in millimetres, is not.
constexpr double largest_plant = 1e6;

// How far from the axis of its parent a cylinder may start, in lengths and radii of both (see
// gaps_to_parents). Of 1505 cylinders in five TreeQSM models the farthest starts at 0.84 of that, the middle
// one at 0.05.
constexpr double worth_saying = 1;
constexpr double not_of_a_scan = 2;
constexpr double not_of_most = 0.3;  // for the middle one
// Nor does it matter how far where it is little against the plant: 0.01 of its size in those models.
constexpr double small_gap = 0.02;
constexpr double large_gap = 0.05;
// How far a loose piece may hang from the nearest branch, skin to skin: that many of its radii and that share
// of its reach outwards. The one in those models hangs at 0.7 of a radius.
constexpr double loose_radii = 2;
constexpr double loose_share = 0.25;

// A piece with at least this share of the wood of the largest piece may be the base of the plant.
constexpr double substantial = 0.1;

std::string place(const RawTree& tree, int branch) {
  const std::string number = std::to_string(tree.branches[branch].place);
  return tree.place_is_line ? tree.path + ":" + number : tree.path + ": cylinder " + number;
}

void note(std::vector<Repair>& repairs, const char* kind, std::size_t count, const std::string& one,
          const std::string& many) {
  if (count == 0) return;
  repairs.push_back({kind, count, std::to_string(count) + " " + (count == 1 ? one : many)});
}

[[noreturn]] void reject_cycle(const RawTree& tree, const std::vector<int>& chain, int again) {
  std::string circle;
  const auto first = std::find(chain.begin(), chain.end(), again);
  for (auto k = first; k != chain.end(); ++k) {
    if (k - first == 6) {
      circle += "... > ";
      break;
    }
    circle += std::to_string(tree.branches[*k].place) + " > ";
  }
  throw InputError(
      place(tree, again),
      "parents go round in a circle (" + circle + std::to_string(tree.branches[again].place) + ")",
      "parents that lead to a root");
}

// The branches in an order with every parent before its children, otherwise as in `wanted`. A parent below 0
// ends a chain.
std::vector<int> parents_first(const RawTree& tree, const std::vector<int>& wanted,
                               const std::vector<int>& parent) {
  enum State : char { untouched, on_the_chain, done };
  std::vector<State> state(tree.branches.size(), untouched);
  std::vector<int> order, chain;
  order.reserve(wanted.size());
  for (const int first : wanted) {
    chain.clear();
    int k = first;
    for (; k >= 0 && state[k] != done; k = parent[k]) {
      if (state[k] == on_the_chain) reject_cycle(tree, chain, k);
      state[k] = on_the_chain;
      chain.push_back(k);
    }
    for (auto up = chain.rbegin(); up != chain.rend(); ++up) {
      state[*up] = done;
      order.push_back(*up);
    }
  }
  return order;
}

// All of them, parents before children.
std::vector<int> order_branches(RawTree& tree) {
  std::vector<int> as_in_file, parent;
  std::size_t before_parent = 0;
  for (const RawBranch& branch : tree.branches) {
    const auto k = static_cast<int>(as_in_file.size());
    as_in_file.push_back(k);
    parent.push_back(branch.parent);
    before_parent += branch.parent > k;
  }
  std::vector<int> order = parents_first(tree, as_in_file, parent);
  note(tree.repairs, "reordered", before_parent, "segment stood before its parent and was put after it",
       "segments stood before their parent and were put after it");
  return order;
}

Extent extent(const RawTree& tree) {
  Extent box{tree.branches[0].start, tree.branches[0].start};
  for (const RawBranch& branch : tree.branches) {
    box.low = box.low.cwiseMin(branch.start).cwiseMin(branch.end);
    box.high = box.high.cwiseMax(branch.start).cwiseMax(branch.end);
  }
  return box;
}

void check_size(const RawTree& tree, const Extent& box) {
  const double size = (box.high - box.low).maxCoeff();
  if (size < 1e-6) {
    throw InputError(tree.path, "the whole plant measures " + rounded(size) + " m", "at least 1e-06 m");
  }
  if (size > largest_plant) {
    throw InputError(tree.path, "the whole plant measures " + rounded(size) + " m",
                     "at most 1e+06 m (--unit says what unit the file is in)");
  }
}

// Where coordinates are so large that neighbouring numbers lie a tenth of a branch apart, the lengths that
// the file once had are gone.
void check_resolution(const RawTree& tree, const Extent& box) {
  double total = 0;
  for (const RawBranch& branch : tree.branches) total += (branch.end - branch.start).norm();
  const double mean = total / static_cast<double>(tree.branches.size());
  const double largest = box.low.cwiseAbs().cwiseMax(box.high.cwiseAbs()).maxCoeff();
  if (largest * tree.resolution > 0.1 * mean) {
    throw InputError(tree.path,
                     "coordinates up to " + rounded(largest) + " m are known to " +
                         rounded(largest * tree.resolution) + " m only, with branches of " + rounded(mean) +
                         " m on average",
                     "coordinates nearer to the origin or in higher precision");
  }
}

// Hash of what makes two branches the same: where they start and end, and what they grow from.
std::uint64_t hash(const RawBranch& branch, int parent) {
  std::uint64_t h = static_cast<std::uint64_t>(parent);
  for (const Vec3* point : {&branch.start, &branch.end}) {
    for (int axis = 0; axis < 3; ++axis) {
      h = (h ^ std::bit_cast<std::uint64_t>((*point)[axis] + 0.0)) *
          0x9E3779B97F4A7C15u;  // + 0.0: one zero only
      h ^= h >> 32;
    }
  }
  return h;
}

// For each branch the one that stands for it: itself, the first in the same place, or, where it has no
// length, what it grew from (-1: its root).
struct Standing {
  std::vector<int> branch;
  std::vector<int> root;    // of each branch that grows from a root, after its parents were resolved
  std::vector<int> parent;  // of each branch, after its parents were resolved
  std::size_t collapsed = 0;
  std::size_t dropped = 0;
};

Standing stand_for(const RawTree& tree, const std::vector<int>& order, double tolerance) {
  Standing standing{std::vector<int>(tree.branches.size(), -1), std::vector<int>(tree.branches.size(), -1),
                    std::vector<int>(tree.branches.size(), -1)};
  // Open addressing: branches kept so far, at most half full.
  std::vector<int> table(std::bit_ceil(2 * tree.branches.size()), -1);
  const auto slot_of = [&](int k) -> int& {
    const RawBranch& branch = tree.branches[k];
    std::size_t slot = hash(branch, standing.parent[k]);
    for (;; ++slot) {
      int& other = table[slot & (table.size() - 1)];
      if (other < 0 ||
          (standing.parent[other] == standing.parent[k] && tree.branches[other].start == branch.start &&
           tree.branches[other].end == branch.end)) {
        return other;
      }
    }
  };
  for (const int k : order) {
    const RawBranch& branch = tree.branches[k];
    const int p = branch.parent;
    standing.parent[k] = p < 0 ? -1 : standing.branch[p];
    if (standing.parent[k] < 0) standing.root[k] = p < 0 ? branch.root : standing.root[p];
    if ((branch.end - branch.start).norm() <= tolerance) {
      ++standing.collapsed;
      standing.branch[k] = standing.parent[k];
      continue;
    }
    int& first = slot_of(k);
    if (first < 0) {
      first = k;
    } else {
      ++standing.dropped;
    }
    standing.branch[k] = first;
  }
  return standing;
}

// The branches that stand for themselves.
std::vector<int> kept_branches(RawTree& tree, const std::vector<int>& order, const Standing& standing) {
  note(tree.repairs, "collapsed_zero_length", standing.collapsed, "segment of zero length collapsed",
       "segments of zero length collapsed");
  note(tree.repairs, "dropped_duplicate", standing.dropped, "segment in the place of another dropped",
       "segments in the place of another dropped");
  std::vector<int> kept;
  for (const int k : order) {
    if (standing.branch[k] == k) kept.push_back(k);
  }
  if (kept.empty()) throw InputError(tree.path, "every branch has zero length", "at least one with a length");
  return kept;
}

// The branches that stand on each root, parents first.
using Pieces = std::vector<std::vector<int>>;

Pieces pieces_by_root(const RawTree& tree, const std::vector<int>& kept, const Standing& standing) {
  Pieces pieces(tree.roots.size());
  std::vector<int> root_of(tree.branches.size(), -1);
  for (const int k : kept) {
    root_of[k] = standing.parent[k] < 0 ? standing.root[k] : root_of[standing.parent[k]];
    pieces[root_of[k]].push_back(k);
  }
  return pieces;
}

double wood_volume(const RawTree& tree, const std::vector<int>& piece) {
  double volume = 0;
  for (const int k : piece) {
    const RawBranch& branch = tree.branches[k];
    const double a = branch.start_radius, b = branch.end_radius;
    volume += std::numbers::pi / 3 * (branch.end - branch.start).norm() * (a * a + a * b + b * b);
  }
  return volume;
}

// The lowest root that carries a substantial piece: a stray twig that hangs below the foot of the trunk is no
// base.
int find_base(const RawTree& tree, const Pieces& pieces) {
  std::vector<double> volume;
  for (const std::vector<int>& piece : pieces) volume.push_back(wood_volume(tree, piece));
  const double enough = substantial * *std::max_element(volume.begin(), volume.end());
  int base = -1;
  for (int r = 0; r < static_cast<int>(pieces.size()); ++r) {
    if (volume[r] < enough || pieces[r].empty()) continue;
    if (base < 0 || tree.roots[r].z() < tree.roots[base].z()) base = r;
  }
  return base;
}

// For each root whether it is clamped; none that carries nothing is.
std::vector<char> clamped_roots(const RawTree& tree, const Pieces& pieces, int base, const Extent& box) {
  const double near = near_the_ground * (box.high.z() - box.low.z());
  std::vector<char> clamped(tree.roots.size(), 0);
  for (std::size_t r = 0; r < tree.roots.size(); ++r) {
    clamped[r] = !pieces[r].empty() && std::abs(tree.roots[r].z() - tree.roots[base].z()) <= near;
  }
  return clamped;
}

void note_stems(RawTree& tree, const std::vector<char>& clamped) {
  const auto stems = static_cast<std::size_t>(std::count(clamped.begin(), clamped.end(), 1));
  if (stems > 1)
    note(tree.repairs, "several_roots", stems, "", "stems stand on the ground, each clamped at its foot");
}

// How far a piece reaches from its root.
double reach_outwards(const RawTree& tree, int root, const std::vector<int>& piece) {
  double farthest = 0;
  for (const int k : piece) farthest = std::max(farthest, (tree.branches[k].end - tree.roots[root]).norm());
  return farthest;
}

struct Join {
  int root;
  int carrier;      // branch
  double distance;  // from the root of the piece to the axis of its carrier [m]
};

// Refuses a loose piece that hangs too far away for a gap in a scan.
void check_join(const RawTree& tree, const std::vector<int>& piece, const Join& join) {
  const RawBranch& own = tree.branches[piece.front()];
  const RawBranch& carrier = tree.branches[join.carrier];
  const double skin = std::max(carrier.start_radius, carrier.end_radius) + own.start_radius;
  const double most =
      skin + loose_radii * own.start_radius + loose_share * reach_outwards(tree, join.root, piece);
  if (join.distance <= most) return;
  throw InputError(
      place(tree, piece.front()),
      "has no parent, stands in the air and is " + rounded(join.distance) + " m from the nearest branch",
      "at most " + rounded(most) + " m for a piece of its size, or --allow-gaps to join it all the same");
}

// Joins every piece on a root that is not clamped to the nearest branch of the tree, starting with the piece
// nearest to it.
std::vector<Join> join_loose_pieces(const RawTree& tree, const Pieces& pieces,
                                    const std::vector<char>& clamped, bool allow_gaps,
                                    std::size_t most_visits) {
  std::vector<int> loose;
  for (int r = 0; r < static_cast<int>(tree.roots.size()); ++r) {
    if (!clamped[r] && !pieces[r].empty()) loose.push_back(r);
  }
  if (loose.empty()) return {};

  std::vector<NearestBranch::Segment> segments;
  segments.reserve(tree.branches.size());
  for (const RawBranch& branch : tree.branches) segments.push_back({branch.start, branch.end});
  NearestBranch search(std::move(segments));
  const auto include = [&](int root) {
    for (const int k : pieces[root]) search.include(k);
  };
  for (int r = 0; r < static_cast<int>(tree.roots.size()); ++r) {
    if (clamped[r]) include(r);
  }

  std::size_t visited = 0;
  const auto nearest = [&](int root) {
    if (visited > most_visits) {
      throw InputError(tree.path, std::to_string(loose.size()) + " pieces without parent lie entangled",
                       "a file in which most branches have a parent");
    }
    return search.nearest(tree.roots[root], visited);
  };
  std::vector<std::pair<double, int>> by_distance;
  for (const int r : loose) by_distance.emplace_back(nearest(r).squared_distance, r);
  std::sort(by_distance.begin(), by_distance.end());
  std::vector<Join> joins;
  for (const auto& [distance, r] : by_distance) {
    const NearestBranch::Found found = nearest(r);
    joins.push_back({r, found.segment, std::sqrt(found.squared_distance)});
    if (!allow_gaps) check_join(tree, pieces[r], joins.back());
    include(r);
  }
  return joins;
}

// "at 0.21 m (line 90), 0.04 m (line 7)": the farthest first, and no more than six.
struct Distance {
  double distance;
  std::size_t place;
};

std::string list_distances(const RawTree& tree, std::vector<Distance> distances) {
  std::stable_sort(distances.begin(), distances.end(),
                   [](const Distance& a, const Distance& b) { return a.distance > b.distance; });
  std::string text;
  const char* const where = tree.place_is_line ? "line " : "cylinder ";
  for (std::size_t i = 0; i < distances.size() && i < 6; ++i) {
    char metres[32];
    std::snprintf(metres, sizeof metres, "%.3g m (", distances[i].distance);
    text += (i == 0 ? "" : ", ") + (metres + (where + std::to_string(distances[i].place)) + ")");
  }
  if (distances.size() > 6) text += " and " + std::to_string(distances.size() - 6) + " at less";
  return text;
}

void note_joins(RawTree& tree, const Pieces& pieces, const std::vector<Join>& joins) {
  std::vector<Distance> distances;
  for (const Join& join : joins)
    distances.push_back({join.distance, tree.branches[pieces[join.root].front()].place});
  note(tree.repairs, "joined_to_nearest", joins.size(),
       "segment without parent joined to the nearest branch, at " + list_distances(tree, distances),
       "segments without parent joined to the nearest branch, at " + list_distances(tree, distances));
}

// From a child to the axis of its parent.
struct Gap {
  int child, parent;
  double distance;  // [m]
  double share;     // of how far that may be
};

std::vector<Gap> gaps_to_parents(const RawTree& tree, const std::vector<int>& kept,
                                 const Standing& standing) {
  std::vector<Gap> gaps;
  for (const int k : kept) {
    const int p = standing.parent[k];
    if (p < 0) continue;
    const RawBranch &branch = tree.branches[k], &parent = tree.branches[p];
    const double distance = std::sqrt(squared_distance(branch.start, {parent.start, parent.end}));
    const double reach = (parent.end - parent.start).norm() +
                         std::max(parent.start_radius, parent.end_radius) + branch.start_radius;
    gaps.push_back({k, p, distance, distance / reach});
  }
  return gaps;
}

// Refuses the farthest of the gaps that no scan explains.
void refuse_large_gap(const RawTree& tree, const std::vector<Gap>& gaps, double size) {
  const Gap* farthest = nullptr;
  for (const Gap& gap : gaps) {
    if (gap.share > not_of_a_scan && gap.distance > large_gap * size &&
        (farthest == nullptr || gap.distance > farthest->distance)) {
      farthest = &gap;
    }
  }
  if (farthest == nullptr) return;
  throw InputError(place(tree, farthest->child),
                   "starts " + rounded(farthest->distance) + " m from its parent, " +
                       (tree.place_is_line ? "line " : "cylinder ") +
                       std::to_string(tree.branches[farthest->parent].place),
                   "a start on its parent (do parents count otherwise, or were rows taken out?), or "
                   "--allow-gaps to bridge it all the same");
}

void refuse_gaps_of_most(const RawTree& tree, const std::vector<Gap>& gaps) {
  if (gaps.size() < 4) return;
  std::vector<double> shares;
  for (const Gap& gap : gaps) shares.push_back(gap.share);
  const auto middle = shares.begin() + static_cast<std::ptrdiff_t>(shares.size() / 2);
  std::nth_element(shares.begin(), middle, shares.end());
  if (*middle <= not_of_most) return;
  throw InputError(tree.path,
                   "half of the segments start more than " + rounded(100 * *middle) +
                       " % of a parent's length away from theirs",
                   "starts on parents (do parents count otherwise, or were rows taken out?), or "
                   "--allow-gaps to bridge them all the same");
}

void note_gaps(RawTree& tree, const std::vector<Gap>& gaps, double size) {
  std::vector<Distance> far;
  for (const Gap& gap : gaps) {
    if (gap.share > worth_saying && gap.distance > small_gap * size)
      far.push_back({gap.distance, tree.branches[gap.child].place});
  }
  note(
      tree.repairs, "far_from_parent", far.size(),
      "segment starts far from its parent and is carried by a rigid arm, at " + list_distances(tree, far),
      "segments start far from their parents and are carried by rigid arms, at " + list_distances(tree, far));
}

// Children that start away from their parents: a few are what scans have, the rest is a table misread.
void check_gaps(RawTree& tree, const std::vector<int>& kept, const Standing& standing, double size,
                bool allow_gaps) {
  const std::vector<Gap> gaps = gaps_to_parents(tree, kept, standing);
  if (!allow_gaps) {
    refuse_large_gap(tree, gaps, size);
    refuse_gaps_of_most(tree, gaps);
  }
  note_gaps(tree, gaps, size);
}

// Metres for what the file says in another unit.
void scale(RawTree& tree, double unit) {
  if (unit == 1) return;
  for (Vec3& root : tree.roots) root *= unit;
  for (RawBranch& branch : tree.branches) {
    branch.start *= unit;
    branch.end *= unit;
    branch.start_radius *= unit;
    branch.end_radius *= unit;
  }
}

// Moves everything so that the base comes to the origin, where the file is really off centre: the base
// further from the origin than the plant is large.
void recentre(RawTree& tree, int base, const Extent& box) {
  const Vec3 shift = tree.roots[base];
  if (shift.norm() <= (box.high - box.low).maxCoeff()) return;
  for (Vec3& root : tree.roots) root -= shift;
  for (RawBranch& branch : tree.branches) {
    branch.start -= shift;
    branch.end -= shift;
  }
  for (Leaf& leaf : tree.leaves) leaf.base -= shift;
  tree.origin += shift;
  const auto millimetres = [](double value) {
    char text[32];
    return std::string(text, std::to_chars(text, text + sizeof text, value, std::chars_format::fixed, 3).ptr);
  };
  tree.repairs.push_back({"recentred", tree.branches.size(),
                          "recentred: the root stood at (" + millimetres(shift.x()) + ", " +
                              millimetres(shift.y()) + ", " + millimetres(shift.z()) + ") m"});
}

// What carries each branch: another, to which its piece was joined where it has no parent, or -1: a root.
std::vector<int> carriers(const RawTree& tree, const Standing& standing, const std::vector<Join>& joins) {
  std::vector<int> joined_to(tree.roots.size(), -1);
  for (const Join& join : joins) joined_to[join.root] = join.carrier;
  std::vector<int> carrier = standing.parent;
  for (std::size_t k = 0; k < carrier.size(); ++k) {
    if (carrier[k] < 0) carrier[k] = joined_to[standing.root[k]];
  }
  return carrier;
}

// The end of its carrier where a branch begins.
int node_on(const Skeleton& skeleton, int carrier, const RawBranch& raw, bool joined, CarrierRule rule) {
  const Branch& carrying = skeleton.branches[carrier];
  const bool at_start = (joined || rule == CarrierRule::nearer_end) &&
                        (raw.start - carrying.start).norm() < (raw.start - carrying.end).norm();
  // What is joined must not end up on the ground.
  const bool grounded = joined && carrying.start_node < skeleton.root_count();
  return at_start && !grounded ? carrying.start_node : skeleton.end_node(carrier);
}

struct Built {
  Skeleton skeleton;
  std::vector<int> index;  // of each raw branch in it
};

// The skeleton of the branches in `kept`, what carries before what is carried.
Built build(const RawTree& tree, const std::vector<int>& kept, const Standing& standing,
            const std::vector<char>& clamped, const std::vector<int>& carrier, CarrierRule rule,
            double tolerance) {
  Built built{{}, std::vector<int>(tree.branches.size(), -1)};
  auto& [skeleton, index] = built;
  std::vector<int> root_node(tree.roots.size(), -1);
  for (std::size_t r = 0; r < tree.roots.size(); ++r) {
    if (!clamped[r]) continue;
    root_node[r] = skeleton.root_count();
    skeleton.roots.push_back(tree.roots[r]);
  }
  skeleton.branches.reserve(kept.size());
  for (const int k : kept) {
    const RawBranch& raw = tree.branches[k];
    Branch branch;
    branch.start = raw.start;
    branch.end = raw.end;
    branch.start_radius = raw.start_radius;
    branch.end_radius = raw.end_radius;
    branch.wall = raw.wall;
    branch.start_node = carrier[k] < 0
                            ? root_node[standing.root[k]]
                            : node_on(skeleton, index[carrier[k]], raw, standing.parent[k] < 0, rule);
    const Vec3& node = skeleton.node_position(branch.start_node);
    if ((branch.start - node).norm() <= tolerance) branch.start = node;
    index[k] = skeleton.branch_count();
    skeleton.branches.push_back(branch);
  }
  return built;
}

// What write_swc wrote, branch by branch.
Skeleton as_it_stands(const RawTree& tree, const std::vector<int>& order) {
  Standing standing;
  for (const RawBranch& branch : tree.branches) {
    standing.parent.push_back(branch.parent);
    standing.root.push_back(branch.root);
  }
  const std::vector<char> clamped(tree.roots.size(), 1);
  Built built = build(tree, order, standing, clamped, standing.parent, CarrierRule::end, 0);
  Skeleton& skeleton = built.skeleton;
  skeleton.leaves = tree.leaves;
  for (Leaf& leaf : skeleton.leaves) leaf.branch = built.index[leaf.branch];
  skeleton.origin = tree.origin;
  check_skeleton(skeleton, tree.path);
  return std::move(skeleton);
}

// A leaf whose branch is gone sits at the end of what stands for it.
void put_leaves(RawTree& tree, const Standing& standing, Built& built) {
  std::size_t fallen = 0;
  for (Leaf leaf : tree.leaves) {
    const int k = standing.branch[leaf.branch];
    if (k != leaf.branch) leaf.position = 1;
    if (k < 0) {
      ++fallen;
      continue;
    }
    leaf.branch = built.index[k];
    built.skeleton.leaves.push_back(leaf);
  }
  note(tree.repairs, "dropped_leaf", fallen, "leaf on a collapsed segment at the root dropped",
       "leaves on collapsed segments at the root dropped");
}

}  // namespace

ImportedSkeleton repair(RawTree tree, const std::string& format, CarrierRule rule, const ReadOptions& options,
                        std::size_t most_visits) {
  if (tree.branches.empty()) throw InputError(tree.path, "no branch", "at least one");
  scale(tree, options.unit);
  const std::vector<int> order = order_branches(tree);
  const Extent box = extent(tree);
  check_size(tree, box);
  if (tree.exact) return {as_it_stands(tree, order), format, {}};

  const double tolerance = same_place * (box.high - box.low).norm();
  const Standing standing = stand_for(tree, order, tolerance);
  const std::vector<int> kept = kept_branches(tree, order, standing);
  check_resolution(tree, box);
  check_gaps(tree, kept, standing, (box.high - box.low).maxCoeff(), options.allow_gaps);

  const Pieces pieces = pieces_by_root(tree, kept, standing);
  const int base = find_base(tree, pieces);
  const std::vector<char> clamped = clamped_roots(tree, pieces, base, box);
  note_stems(tree, clamped);
  recentre(tree, base, box);
  const std::vector<Join> joins = join_loose_pieces(tree, pieces, clamped, options.allow_gaps, most_visits);
  note_joins(tree, pieces, joins);

  const std::vector<int> carrier = carriers(tree, standing, joins);
  Built built = build(tree, parents_first(tree, kept, carrier), standing, clamped, carrier, rule, tolerance);
  put_leaves(tree, standing, built);
  built.skeleton.origin = tree.origin;
  check_skeleton(built.skeleton, tree.path);
  return {std::move(built.skeleton), format, std::move(tree.repairs)};
}

}  // namespace tremula
