#include "tremula/structure/compliance_operator.hpp"

#include "tremula/base/simd.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>
#include <variant>
#include <vector>

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

// Vectors never cross a function that is not inlined.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace tremula {
namespace {

constexpr int largest_subtree = 2048;    // branches of a block: 200 kB of motion and forces
constexpr int parallel_branches = 8192;  // fewer: one thread is faster

// The numbers of a group of branches, one branch a lane. Lanes without a branch are 0 throughout. How a
// branch is carried and what its compliance is, is told in one way for a tree and in another for a tree under
// load.
template <int lanes, bool loaded>
struct Group {
  // Sums and differences as the sweeps need them. a, t, b: the axial, torsion and bending mass.
  enum Number {
    direction,                                  // 3
    reach = direction + 3,                      // 3
    root_deflection = reach + 3,                // of C = S S^T: across
    root_slope_deflection,                      //
    root_slope,                                 //
    root_along,                                 // axial - deflection
    root_twist,                                 // torsion - slope
    carry = direction + 3,                      // under load instead: 6 x 3, by rows
    root = carry + 18,                          // and the lower triangle of 6 x 6, by rows
    arm = loaded ? root + 21 : root_twist + 1,  // 3
    along = arm + 3,                            // a00 - b00, a01 - b02, a11 - b22
    twist = along + 3,                          // t00 - b11, t01 - b13, t11 - b33
    bending = twist + 3,                        // b00 b01 b02 b03 b11 b12 b13 b22 b23 b33
    number_count = bending + 10,
  };
  std::array<std::array<double, lanes>, number_count> numbers{};
  std::array<std::int32_t, lanes> parent{};  // where the parent's first number is in the block's motion
};

struct Block {
  int first_group = 0, group_count = 0, inlet_groups = 0;
  // For each inlet, the branch of the top that it stands for, as a place in the top's motion; -1: the ground.
  std::vector<std::int32_t> inlets{};
};

// Where everything is, before the numbers are packed.
struct Layout {
  int lanes = 8;
  std::vector<Block> blocks{};  // the top first, where there is one
  bool has_top = false;
  std::vector<int> slot{};             // by branch: group * lanes + lane
  std::vector<std::int32_t> parent{};  // by branch: place of the parent's first number in the block's motion
  int group_count = 0;
};

// By branch: 0 for the top, else 1, 2, … Subtrees follow each other into a block until it is full.
std::vector<int> cut_into_blocks(const BeamTree& tree) {
  const int count = tree.branch_count();
  std::vector<int> block(index_of(count), 1);
  if (count <= 2 * largest_subtree) return block;
  std::vector<int> subtree(index_of(count), 1);
  for (int k = count - 1; k >= 0; --k) {
    const int parent = tree.parent[index_of(k)];
    if (parent >= 0) subtree[index_of(parent)] += subtree[index_of(k)];
  }
  int current = 1, filled = 0;
  for (int k = 0; k < count; ++k) {
    const int parent = tree.parent[index_of(k)];
    if (subtree[index_of(k)] > largest_subtree) {
      block[index_of(k)] = 0;
    } else if (parent >= 0 && block[index_of(parent)] > 0) {
      block[index_of(k)] = block[index_of(parent)];
    } else {
      if (filled + subtree[index_of(k)] > largest_subtree) {
        ++current;
        filled = 0;
      }
      block[index_of(k)] = current;
      filled += subtree[index_of(k)];
    }
  }
  return block;
}

// The branches of every block by depth in it, and within a depth by parent: (block, depth) -> branches.
std::vector<std::vector<std::vector<int>>> sort_by_depth(const BeamTree& tree,
                                                         const std::vector<int>& block) {
  std::vector<std::vector<std::vector<int>>> sorted(
      index_of(1 + *std::max_element(block.begin(), block.end())));
  std::vector<int> depth(block.size(), 0), rank(block.size(), 0);
  int next_rank = 0;
  for (int k = 0; k < tree.branch_count(); ++k) {
    const int parent = tree.parent[index_of(k)];
    const bool inside = parent >= 0 && block[index_of(parent)] == block[index_of(k)];
    if (inside) depth[index_of(k)] = depth[index_of(parent)] + 1;
    auto& levels = sorted[index_of(block[index_of(k)])];
    if (levels.size() <= index_of(depth[index_of(k)])) levels.resize(index_of(depth[index_of(k)]) + 1);
    levels[index_of(depth[index_of(k)])].push_back(k);
  }
  for (auto& levels : sorted) {
    for (auto& level : levels) {
      const auto rank_of_parent = [&](int k) {
        const int parent = tree.parent[index_of(k)];
        return parent < 0 ? -1 : rank[index_of(parent)];
      };
      std::stable_sort(level.begin(), level.end(),
                       [&](int a, int b) { return rank_of_parent(a) < rank_of_parent(b); });
      for (const int k : level) rank[index_of(k)] = next_rank++;
    }
  }
  return sorted;
}

int group_count(const std::vector<std::vector<std::vector<int>>>& sorted, int lanes) {
  int groups = 0;
  for (const auto& levels : sorted) {
    for (const auto& level : levels) groups += (static_cast<int>(level.size()) + lanes - 1) / lanes;
  }
  return groups;
}

Layout lay_out(const BeamTree& tree) {
  const std::vector<int> block_of = cut_into_blocks(tree);
  const auto sorted = sort_by_depth(tree, block_of);
  Layout layout;
  // Where most depths have few branches (a straight stem), lanes would be empty.
  const double cost_8 = 1.8 * group_count(sorted, 8), cost_4 = 1.3 * group_count(sorted, 4);
  const double cost_1 = tree.branch_count();
  layout.lanes = cost_8 <= std::min(cost_4, cost_1) ? 8 : cost_4 <= cost_1 ? 4 : 1;
  const int lanes = layout.lanes;
  const auto place = [&](int slot) {
    return static_cast<std::int32_t>(slot / lanes * 6 * lanes + slot % lanes);
  };
  layout.slot.resize(block_of.size());
  layout.parent.resize(block_of.size());
  layout.has_top = !sorted[0].empty();
  for (const auto& levels : sorted) {
    if (levels.empty()) continue;
    Block block;
    block.first_group = layout.group_count;
    std::vector<int> heads;  // branches whose parent is not in the block
    for (const auto& level : levels) {
      for (int i = 0; i < static_cast<int>(level.size()); ++i)
        layout.slot[index_of(level[index_of(i)])] = layout.group_count * lanes + i;
      layout.group_count += (static_cast<int>(level.size()) + lanes - 1) / lanes;
    }
    block.group_count = layout.group_count - block.first_group;
    // Inlets: one for each branch outside that carries branches of the block. The first levels' order is by
    // parent, so equal ones follow each other.
    const auto head_place = [&](int parent) {
      return parent < 0 ? -1 : place(layout.slot[index_of(parent)] + lanes * layout.blocks[0].inlet_groups);
    };
    for (const int k : levels[0]) {
      const std::int32_t from = head_place(tree.parent[index_of(k)]);
      if (block.inlets.empty() || block.inlets.back() != from) block.inlets.push_back(from);
      layout.parent[index_of(k)] = place(static_cast<int>(block.inlets.size()) - 1);
    }
    block.inlet_groups = (static_cast<int>(block.inlets.size()) + lanes - 1) / lanes;
    for (std::size_t depth = 1; depth < levels.size(); ++depth) {
      for (const int k : levels[depth]) {
        const int local = layout.slot[index_of(tree.parent[index_of(k)])] - block.first_group * lanes;
        layout.parent[index_of(k)] = place(local + block.inlet_groups * lanes);
      }
    }
    layout.blocks.push_back(std::move(block));
  }
  return layout;
}

template <int lanes, bool loaded>
void pack(const BeamTree& tree, int k, Group<lanes, loaded>& group, int lane) {
  using Number = typename Group<lanes, loaded>::Number;
  const auto set = [&](int number, double value) { group.numbers[index_of(number)][index_of(lane)] = value; };
  for (int i = 0; i < 3; ++i) {
    set(Number::direction + i, tree.members[index_of(k)].direction[i]);
    set(Number::arm + i, tree.members[index_of(k)].start_arm[i]);
  }
  if constexpr (loaded) {
    const LoadedBranch& branch = tree.loaded[index_of(k)];
    for (int i = 0, next = 0; i < 6; ++i) {
      for (int j = 0; j < 3; ++j) set(Number::carry + 3 * i + j, branch.carry(i, j));
      for (int j = 0; j <= i; ++j, ++next) set(Number::root + next, branch.root(i, j));
    }
  } else {
    for (int i = 0; i < 3; ++i) set(Number::reach + i, tree.reach[index_of(k)][i]);
    const Compliance& c = tree.compliances[index_of(k)];
    const double deflection = std::sqrt(c.deflection), slope = std::sqrt(c.slope_held);
    set(Number::root_deflection, deflection);
    set(Number::root_slope_deflection, c.deflection_slope / deflection);
    set(Number::root_slope, slope);
    set(Number::root_along, std::sqrt(c.axial) - deflection);
    set(Number::root_twist, std::sqrt(c.torsion) - slope);
  }
  const ElementMass& mass = tree.masses[index_of(k)];
  for (int i = 0, next = 0, next_bending = 0; i < 2; ++i) {
    for (int j = i; j < 2; ++j, ++next) {
      set(Number::along + next, mass.axial(i, j) - mass.bending(2 * i, 2 * j));
      set(Number::twist + next, mass.torsion(i, j) - mass.bending(2 * i + 1, 2 * j + 1));
    }
    if (i == 0) {
      for (int row = 0; row < 4; ++row) {
        for (int column = row; column < 4; ++column)
          set(Number::bending + next_bending++, mass.bending(row, column));
      }
    }
  }
}

template <class L>
struct Triple {
  L x, y, z;
};
template <class L>
TREMULA_INLINE Triple<L> operator+(const Triple<L>& a, const Triple<L>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class L>
TREMULA_INLINE Triple<L> operator*(const L& s, const Triple<L>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class L>
TREMULA_INLINE L dot(const Triple<L>& a, const Triple<L>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class L>
TREMULA_INLINE Triple<L> cross(const Triple<L>& a, const Triple<L>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// Six numbers of a lane are `lanes` apart; a group's are together.
template <int lanes>
TREMULA_INLINE void load_pair(const double* from, Triple<Lanes<lanes>>& first, Triple<Lanes<lanes>>& second) {
  load(from, first.x), load(from + lanes, first.y), load(from + 2 * lanes, first.z);
  load(from + 3 * lanes, second.x), load(from + 4 * lanes, second.y), load(from + 5 * lanes, second.z);
}
template <int lanes>
TREMULA_INLINE void store_pair(const Triple<Lanes<lanes>>& first, const Triple<Lanes<lanes>>& second,
                               double* to) {
  store(first.x, to), store(first.y, to + lanes), store(first.z, to + 2 * lanes);
  store(second.x, to + 3 * lanes), store(second.y, to + 4 * lanes), store(second.z, to + 5 * lanes);
}
template <int lanes>
TREMULA_INLINE Lanes<lanes> gather(const double* base, const std::int32_t* place) {
  if constexpr (lanes == 8) {
    return Lanes<8>{base[place[0]], base[place[1]], base[place[2]], base[place[3]],
                    base[place[4]], base[place[5]], base[place[6]], base[place[7]]};
  } else if constexpr (lanes == 4) {
    return Lanes<4>{base[place[0]], base[place[1]], base[place[2]], base[place[3]]};
  } else {
    return base[place[0]];
  }
}
template <int lanes>
TREMULA_INLINE void gather_pair(const double* base, const std::int32_t* place, Triple<Lanes<lanes>>& first,
                                Triple<Lanes<lanes>>& second) {
  first = {gather<lanes>(base, place), gather<lanes>(base + lanes, place),
           gather<lanes>(base + 2 * lanes, place)};
  second = {gather<lanes>(base + 3 * lanes, place), gather<lanes>(base + 4 * lanes, place),
            gather<lanes>(base + 5 * lanes, place)};
}
// Lanes may share a parent, so they are added one after the other.
template <int lanes>
TREMULA_INLINE void scatter_add_pair(const Triple<Lanes<lanes>>& first, const Triple<Lanes<lanes>>& second,
                                     const std::int32_t* place, double* base) {
  alignas(64) double values[6][lanes];
  store_pair<lanes>(first, second, values[0]);
  for (int lane = 0; lane < lanes; ++lane) {
    for (int i = 0; i < 6; ++i) base[place[lane] + i * lanes] += values[i][lane];
  }
}

template <int lanes, bool loaded>
struct GroupReader {
  using L = Lanes<lanes>;
  using G = Group<lanes, loaded>;
  const G& group;
  TREMULA_INLINE L number(int which) const {
    L value;
    load(group.numbers[static_cast<std::size_t>(which)].data(), value);
    return value;
  }
  TREMULA_INLINE L bending(int i) const { return number(G::bending + i); }
  TREMULA_INLINE Triple<L> triple(int which) const {
    return {number(which), number(which + 1), number(which + 2)};
  }
  // Under load: three rows of the carry times a rotation, and those of the root times s up to the diagonal.
  TREMULA_INLINE Triple<L> carried(int row, const Triple<L>& rotation) const {
    const int first = G::carry + 3 * row;
    return {dot(triple(first), rotation), dot(triple(first + 3), rotation), dot(triple(first + 6), rotation)};
  }
  TREMULA_INLINE L root(int i, int j) const { return number(G::root + i * (i + 1) / 2 + j); }
  TREMULA_INLINE Triple<L> upper_root(const Triple<L>& s) const {
    return {root(0, 0) * s.x, root(1, 0) * s.x + root(1, 1) * s.y,
            root(2, 0) * s.x + root(2, 1) * s.y + root(2, 2) * s.z};
  }
  TREMULA_INLINE Triple<L> lower_root(const Triple<L>& s, const Triple<L>& t) const {
    const Triple<L> left = {dot(triple(G::root + 6), s), dot(triple(G::root + 10), s),
                            dot(triple(G::root + 15), s)};
    return left + Triple<L>{root(3, 3) * t.x, root(4, 3) * t.x + root(4, 4) * t.y,
                            root(5, 3) * t.x + root(5, 4) * t.y + root(5, 5) * t.z};
  }
  // And the same transposed.
  TREMULA_INLINE Triple<L> carried_back(const Triple<L>& force, const Triple<L>& moment) const {
    return force.x * triple(G::carry) + force.y * triple(G::carry + 3) + force.z * triple(G::carry + 6) +
           moment.x * triple(G::carry + 9) + moment.y * triple(G::carry + 12) +
           moment.z * triple(G::carry + 15);
  }
  TREMULA_INLINE Triple<L> upper_root_back(const Triple<L>& force, const Triple<L>& moment) const {
    return Triple<L>{root(0, 0) * force.x + root(1, 0) * force.y + root(2, 0) * force.z,
                     root(1, 1) * force.y + root(2, 1) * force.z, root(2, 2) * force.z} +
           moment.x * triple(G::root + 6) + moment.y * triple(G::root + 10) + moment.z * triple(G::root + 15);
  }
  TREMULA_INLINE Triple<L> lower_root_back(const Triple<L>& moment) const {
    return {root(3, 3) * moment.x + root(4, 3) * moment.y + root(5, 3) * moment.z,
            root(4, 4) * moment.y + root(5, 4) * moment.z, root(5, 5) * moment.z};
  }
};

// u = B^-1 S s from the roots of the block to its tips; `motion` begins with the inlets.
template <int lanes, bool loaded>
TREMULA_INLINE void sweep_to_tips(const Group<lanes, loaded>* groups, int count, const double* s,
                                  double* motion, double* start_motion, int inlet_groups) {
  using L = Lanes<lanes>;
  using G = Group<lanes, loaded>;
  for (int g = 0; g < count; ++g) {
    const GroupReader<lanes, loaded> read{groups[g]};
    Triple<L> force, moment, u, theta;
    load_pair<lanes>(s + 6 * lanes * g, force, moment);
    gather_pair<lanes>(motion, groups[g].parent.data(), u, theta);
    store_pair<lanes>(u, theta, start_motion + 6 * lanes * g);
    if constexpr (loaded) {
      u = u + read.carried(0, theta) + read.upper_root(force);
      theta = read.carried(3, theta) + read.lower_root(force, moment);
    } else {
      const Triple<L> d = read.triple(G::direction);
      u = u + cross(theta, read.triple(G::reach)) + read.number(G::root_deflection) * force +
          (read.number(G::root_along) * dot(force, d)) * d;
      theta = theta + read.number(G::root_slope) * moment +
              (read.number(G::root_twist) * dot(moment, d)) * d +
              read.number(G::root_slope_deflection) * cross(d, force);
    }
    store_pair<lanes>(u, theta, motion + 6 * lanes * (inlet_groups + g));
  }
}

// The forces of the masses, their sum B^-T from the tips to the roots, and S^T. `forces` begins with the
// inlets and is 0 before. Returns s . out.
template <int lanes, bool loaded>
TREMULA_INLINE double sweep_to_roots(const Group<lanes, loaded>* groups, int count, const double* s,
                                     const double* motion, const double* start_motion, double* forces,
                                     int inlet_groups, double* out) {
  using L = Lanes<lanes>;
  using G = Group<lanes, loaded>;
  L product{};
  for (int g = count - 1; g >= 0; --g) {
    const GroupReader<lanes, loaded> read{groups[g]};
    Triple<L> u0, theta0, u1, theta1, force1, moment1;
    load_pair<lanes>(start_motion + 6 * lanes * g, u0, theta0);
    load_pair<lanes>(motion + 6 * lanes * (inlet_groups + g), u1, theta1);
    load_pair<lanes>(forces + 6 * lanes * (inlet_groups + g), force1, moment1);
    const Triple<L> d = read.triple(G::direction), arm = read.triple(G::arm);
    u0 = u0 + cross(theta0, arm);

    // A section is round: what its mass does across the branch is scalars times vectors, and what differs
    // along it is put right along d.
    const L along0 = dot(u0, d), along1 = dot(u1, d), twist0 = dot(theta0, d), twist1 = dot(theta1, d);
    const Triple<L> force0 = read.bending(0) * u0 + read.bending(2) * u1 +
                             cross(read.bending(1) * theta0 + read.bending(3) * theta1, d) +
                             (read.number(G::along) * along0 + read.number(G::along + 1) * along1) * d;
    const Triple<L> moment0 = cross(d, read.bending(1) * u0 + read.bending(5) * u1) +
                              read.bending(4) * theta0 + read.bending(6) * theta1 +
                              (read.number(G::twist) * twist0 + read.number(G::twist + 1) * twist1) * d;
    force1 = force1 + read.bending(2) * u0 + read.bending(7) * u1 +
             cross(read.bending(5) * theta0 + read.bending(8) * theta1, d) +
             (read.number(G::along + 1) * along0 + read.number(G::along + 2) * along1) * d;
    moment1 = moment1 + cross(d, read.bending(3) * u0 + read.bending(8) * u1) + read.bending(6) * theta0 +
              read.bending(9) * theta1 +
              (read.number(G::twist + 1) * twist0 + read.number(G::twist + 2) * twist1) * d;

    Triple<L> carried, out1, out2;
    if constexpr (loaded) {
      carried = moment0 + cross(arm, force0) + read.carried_back(force1, moment1);
      out1 = read.upper_root_back(force1, moment1);
      out2 = read.lower_root_back(moment1);
    } else {
      carried = moment0 + moment1 + cross(arm, force0) + cross(read.triple(G::reach), force1);
      const L slope_deflection = read.number(G::root_slope_deflection);
      out1 = read.number(G::root_deflection) * force1 + slope_deflection * cross(moment1, d) +
             (read.number(G::root_along) * dot(force1, d)) * d;
      out2 = read.number(G::root_slope) * moment1 + (read.number(G::root_twist) * dot(moment1, d)) * d;
    }
    scatter_add_pair<lanes>(force0 + force1, carried, groups[g].parent.data(), forces);
    store_pair<lanes>(out1, out2, out + 6 * lanes * g);
    Triple<L> s1, s2;
    load_pair<lanes>(s + 6 * lanes * g, s1, s2);
    product += dot(s1, out1) + dot(s2, out2);
  }
  alignas(64) double parts[lanes];
  store(product, parts);
  double sum = 0;
  for (int lane = 0; lane < lanes; ++lane) sum += parts[lane];
  return sum;
}

// Clones of templates do not exist; these are what they would be.
#define TREMULA_SWEEPS(lanes, loaded)                                                                        \
  TREMULA_CLONES void to_tips(const Group<lanes, loaded>* groups, int count, const double* s,                \
                              double* motion, double* start_motion, int inlet_groups) {                      \
    sweep_to_tips<lanes, loaded>(groups, count, s, motion, start_motion, inlet_groups);                      \
  }                                                                                                          \
  TREMULA_CLONES double to_roots(const Group<lanes, loaded>* groups, int count, const double* s,             \
                                 const double* motion, const double* start_motion, double* forces,           \
                                 int inlet_groups, double* out) {                                            \
    return sweep_to_roots<lanes, loaded>(groups, count, s, motion, start_motion, forces, inlet_groups, out); \
  }
TREMULA_SWEEPS(8, false)
TREMULA_SWEEPS(4, false)
TREMULA_SWEEPS(1, false)
TREMULA_SWEEPS(8, true)
TREMULA_SWEEPS(4, true)
TREMULA_SWEEPS(1, true)
#undef TREMULA_SWEEPS

template <int lanes, bool loaded>
class PackedTree {
 public:
  PackedTree(const BeamTree& tree, Layout layout)
      : layout_(std::move(layout)), groups_(index_of(layout_.group_count)) {
    for (int k = 0; k < tree.branch_count(); ++k) {
      const int slot = layout_.slot[index_of(k)];
      pack(tree, k, groups_[index_of(slot / lanes)], slot % lanes);
      groups_[index_of(slot / lanes)].parent[index_of(slot % lanes)] = layout_.parent[index_of(k)];
    }
    int inlets = 0;
    for (const Block& block : layout_.blocks) {
      first_inlet_.push_back(inlets);
      inlets += static_cast<int>(block.inlets.size());
    }
    inlet_forces_.resize(6 * index_of(inlets));
    products_.resize(layout_.blocks.size());
    if (layout_.has_top) top_.resize(motion_size(layout_.blocks[0]));
  }

  Eigen::Index size() const { return Eigen::Index{6} * lanes * layout_.group_count; }
  // Where the first number of a branch is; the others follow `lanes` apart.
  Eigen::Index place(int branch) const {
    const int slot = layout_.slot[index_of(branch)];
    return Eigen::Index{6} * lanes * (slot / lanes) + slot % lanes;
  }

  double apply(const double* s, double* out) {
    const int first_block = layout_.has_top ? 1 : 0;
    if (layout_.has_top) move(layout_.blocks[0], s, top_);
    for_each_block(first_block, [&](std::size_t b) {
      const Block& block = layout_.blocks[b];
      Scratch& scratch = scratch_.local();
      scratch.resize(motion_size(block));
      move(block, s, scratch);
      products_[b] = force(block, s, scratch, out);
      for (std::size_t i = 0; i < block.inlets.size(); ++i) {
        for (std::size_t c = 0; c < 6; ++c) {
          inlet_forces_[6 * (index_of(first_inlet_[b]) + i) + c] = scratch.forces[inlet_place(i) + c * lanes];
        }
      }
    });
    if (layout_.has_top) {
      for (std::size_t b = 1; b < layout_.blocks.size(); ++b) {
        const Block& block = layout_.blocks[b];
        for (std::size_t i = 0; i < block.inlets.size(); ++i) {
          if (block.inlets[i] < 0) continue;
          for (std::size_t c = 0; c < 6; ++c) {
            top_.forces[static_cast<std::size_t>(block.inlets[i]) + c * lanes] +=
                inlet_forces_[6 * (index_of(first_inlet_[b]) + i) + c];
          }
        }
      }
      products_[0] = force(layout_.blocks[0], s, top_, out);
    }
    return std::accumulate(products_.begin(), products_.end(), 0.0);
  }

  Eigen::VectorXd packed(const Eigen::VectorXd& s) const {
    Eigen::VectorXd result = Eigen::VectorXd::Zero(size());
    for (int k = 0; k < static_cast<int>(layout_.slot.size()); ++k) {
      for (int c = 0; c < 6; ++c) result[place(k) + c * lanes] = s[6 * k + c];
    }
    return result;
  }
  Eigen::VectorXd unpacked(const double* s) const {
    Eigen::VectorXd result(6 * static_cast<Eigen::Index>(layout_.slot.size()));
    for (int k = 0; k < static_cast<int>(layout_.slot.size()); ++k) {
      for (int c = 0; c < 6; ++c) result[6 * k + c] = s[place(k) + c * lanes];
    }
    return result;
  }

 private:
  struct Scratch {
    std::vector<double> motion{}, start_motion{}, forces{};
    void resize(std::size_t size) {
      if (motion.size() < size) motion.resize(size), start_motion.resize(size), forces.resize(size);
    }
  };

  static std::size_t inlet_place(std::size_t i) { return i / lanes * 6 * lanes + i % lanes; }
  static std::size_t motion_size(const Block& block) {
    return 6 * lanes * index_of(block.inlet_groups + block.group_count);
  }
  const double* part(const Block& block, const double* vector) const {
    return vector + std::ptrdiff_t{6} * lanes * block.first_group;
  }

  template <class Work>
  void for_each_block(int first, const Work& work) {
    const std::size_t count = layout_.blocks.size();
    if (static_cast<int>(layout_.slot.size()) < parallel_branches) {
      for (std::size_t b = index_of(first); b < count; ++b) work(b);
    } else {
      tbb::parallel_for(index_of(first), count, work);
    }
  }

  void move(const Block& block, const double* s, Scratch& scratch) {
    std::fill_n(scratch.motion.begin(), 6 * lanes * block.inlet_groups, 0.0);
    std::fill_n(scratch.forces.begin(), motion_size(block), 0.0);
    for (std::size_t i = 0; i < block.inlets.size(); ++i) {
      if (block.inlets[i] < 0) continue;
      for (std::size_t c = 0; c < 6; ++c) {
        scratch.motion[inlet_place(i) + c * lanes] =
            top_.motion[static_cast<std::size_t>(block.inlets[i]) + c * lanes];
      }
    }
    to_tips(groups_.data() + block.first_group, block.group_count, part(block, s), scratch.motion.data(),
            scratch.start_motion.data(), block.inlet_groups);
  }
  double force(const Block& block, const double* s, Scratch& scratch, double* out) {
    return to_roots(groups_.data() + block.first_group, block.group_count, part(block, s),
                    scratch.motion.data(), scratch.start_motion.data(), scratch.forces.data(),
                    block.inlet_groups, out + (part(block, s) - s));
  }

  Layout layout_;
  std::vector<Group<lanes, loaded>> groups_;
  std::vector<int> first_inlet_{};
  std::vector<double> inlet_forces_{}, products_{};
  Scratch top_{};
  tbb::enumerable_thread_specific<Scratch> scratch_{};
};

}  // namespace

struct ComplianceOperator::Impl {
  using Packed = std::variant<PackedTree<1, false>, PackedTree<4, false>, PackedTree<8, false>,
                              PackedTree<1, true>, PackedTree<4, true>, PackedTree<8, true>>;
  Packed tree;

  template <bool loaded>
  static Packed packed(const BeamTree& tree, Layout layout) {
    if (layout.lanes == 8) return PackedTree<8, loaded>(tree, std::move(layout));
    if (layout.lanes == 4) return PackedTree<4, loaded>(tree, std::move(layout));
    return PackedTree<1, loaded>(tree, std::move(layout));
  }
  static Packed packed(const BeamTree& tree) {
    return tree.is_loaded() ? packed<true>(tree, lay_out(tree)) : packed<false>(tree, lay_out(tree));
  }
};

ComplianceOperator::ComplianceOperator(const BeamTree& tree)
    : impl_(std::make_unique<Impl>(Impl{Impl::packed(tree)})) {}
ComplianceOperator::~ComplianceOperator() = default;
ComplianceOperator::ComplianceOperator(ComplianceOperator&&) noexcept = default;

Eigen::Index ComplianceOperator::size() const {
  return std::visit([](const auto& tree) { return tree.size(); }, impl_->tree);
}

double ComplianceOperator::apply(Eigen::Ref<const Eigen::VectorXd> in, Eigen::Ref<Eigen::VectorXd> out) {
  return std::visit([&](auto& tree) { return tree.apply(in.data(), out.data()); }, impl_->tree);
}

Eigen::VectorXd ComplianceOperator::packed(const Eigen::VectorXd& s) const {
  return std::visit([&](const auto& tree) { return tree.packed(s); }, impl_->tree);
}

Eigen::VectorXd ComplianceOperator::unpacked(Eigen::Ref<const Eigen::VectorXd> s) const {
  return std::visit([&](const auto& tree) { return tree.unpacked(s.data()); }, impl_->tree);
}

}  // namespace tremula
