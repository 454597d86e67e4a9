#include "tremula/io/repair.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "complaint.hpp"
#include "io/input_files.hpp"
#include "tremula/numerics/random.hpp"

namespace tremula {
namespace {

using test::count_of;
using test::message_of;

// Branches by start, end and parent, with a root at the start of each that has none; places count from 1.
struct Piece {
  Vec3 start, end;
  int parent;
};

RawTree raw_tree(const std::vector<Piece>& pieces) {
  RawTree tree;
  tree.path = "tree";
  for (const Piece& piece : pieces) {
    RawBranch branch;
    branch.start = piece.start;
    branch.end = piece.end;
    branch.start_radius = branch.end_radius = 0.01 * static_cast<double>(tree.branches.size() + 1);
    branch.parent = piece.parent;
    branch.place = tree.branches.size() + 1;
    if (piece.parent < 0) {
      branch.root = static_cast<int>(tree.roots.size());
      tree.roots.push_back(piece.start);
    }
    tree.branches.push_back(branch);
  }
  return tree;
}

// However far apart things lie, unless `allow_gaps` says otherwise.
ImportedSkeleton mend(RawTree tree, bool allow_gaps = true) {
  return repair(std::move(tree), "test", CarrierRule::nearer_end, {.allow_gaps = allow_gaps});
}

std::string complaint_about(RawTree tree, bool allow_gaps = true) {
  return test::complaint_of([&] { mend(std::move(tree), allow_gaps); });
}

// Which raw branch each became, known by its radius.
int piece_of(const Branch& branch) { return static_cast<int>(std::lround(branch.start_radius / 0.01)) - 1; }

std::vector<Piece> random_pieces(int count, std::uint64_t seed, double loose_share) {
  const auto draw = [&](int k, std::uint32_t what) {
    return uniform({seed, RandomStream::test, what, static_cast<std::uint64_t>(k)});
  };
  std::vector<Piece> pieces;
  for (int k = 0; k < count; ++k) {
    const int parent = k == 0 || draw(k, 0) < loose_share ? -1 : static_cast<int>(draw(k, 1) * k);
    Vec3 start = 5 * Vec3(draw(k, 2), draw(k, 3), 0.1 + draw(k, 4));
    if (k == 0) start.setZero();
    if (parent >= 0) start = pieces[std::size_t(parent)].end;
    pieces.push_back({start, start + Vec3(draw(k, 5) - 0.5, draw(k, 6) - 0.5, draw(k, 7)), parent});
  }
  return pieces;
}

// ---- recentred
// ---------------------------------------------------------------------------------------------------

TEST(Repair, LeavesATreeNearTheOriginWhereItIs) {
  const ImportedSkeleton imported = mend(raw_tree({{{3, 0, 0}, {3, 0, 4}, -1}}));  // 3 m away, 4 m high
  EXPECT_TRUE(imported.repairs.empty());
  EXPECT_EQ(imported.skeleton.roots[0], Vec3(3, 0, 0));
  EXPECT_EQ(imported.skeleton.origin, Vec3(0, 0, 0));
}

TEST(Repair, RecentresATreeFurtherFromTheOriginThanItIsLarge) {
  const ImportedSkeleton imported = mend(raw_tree({{{5, 0, 0}, {5, 0, 4}, -1}, {{5, 0, 4}, {6, 0, 4.5}, 0}}));
  EXPECT_EQ(imported.skeleton.roots[0], Vec3(0, 0, 0));
  EXPECT_EQ(imported.skeleton.origin, Vec3(5, 0, 0));
  EXPECT_EQ(imported.skeleton.branches[1].end, Vec3(1, 0, 4.5));
  EXPECT_EQ(count_of(imported, "recentred"), 2u);
  EXPECT_EQ(message_of(imported, "recentred"), "recentred: the root stood at (5.000, 0.000, 0.000) m");
}

TEST(Repair, KeepsThePrecisionOfAScanAMillionMetresAway) {
  const std::vector<Piece> near = random_pieces(200, 1, 0.05);
  const Vec3 shift(500000.25, 4649776.5, -1000000.125);
  std::vector<Piece> far = near;
  for (Piece& piece : far) {
    piece.start += shift;
    piece.end += shift;
  }
  const Skeleton a = mend(raw_tree(near)).skeleton;
  const Skeleton b = mend(raw_tree(far)).skeleton;
  EXPECT_EQ(b.origin, shift);
  ASSERT_EQ(a.branch_count(), b.branch_count());
  const double rounding = 4 * 0x1p-53 * 5e6;  // of the far coordinates, twice for each of two numbers
  for (std::size_t k = 0; k < a.branches.size(); ++k) {
    EXPECT_EQ(a.branches[k].start_node, b.branches[k].start_node);
    EXPECT_LE((a.branches[k].start - b.branches[k].start).norm(), rounding);
    EXPECT_LE((a.branches[k].end - b.branches[k].end).norm(), rounding);
  }
}

// ---- joined
// ------------------------------------------------------------------------------------------------------

TEST(Repair, JoinsASegmentWithoutParentToTheNearerEndOfTheNearestBranch) {
  const ImportedSkeleton imported =
      mend(raw_tree({{{0, 0, 0}, {0, 0, 2}, -1},
                     {{0, 0, 2}, {0, 0, 4}, 0},
                     {{0.5, 0, 2.5}, {1, 0, 3}, -1},     // nearer the start of the second
                     {{0.5, 0, 3.5}, {1, 0, 4}, -1}}));  // nearer its end
  EXPECT_EQ(count_of(imported, "joined_to_nearest"), 2u);
  EXPECT_EQ(message_of(imported, "joined_to_nearest"),
            "2 segments without parent joined to the nearest branch, at 0.5 m (line 3), 0.5 m (line 4)");
  const Skeleton& skeleton = imported.skeleton;
  EXPECT_EQ(skeleton.root_count(), 1);
  EXPECT_EQ(skeleton.branches[2].start_node, skeleton.end_node(0));
  EXPECT_EQ(skeleton.branches[3].start_node, skeleton.end_node(1));
  EXPECT_EQ(skeleton.branches[2].start, Vec3(0.5, 0, 2.5));  // by a rigid arm: nothing moves
}

TEST(Repair, NeverJoinsToTheGround) {
  const ImportedSkeleton imported =
      mend(raw_tree({{{0, 0, 0}, {0, 0, 2}, -1}, {{0.1, 0, 0.2}, {0.5, 0, 0.5}, -1}}));
  EXPECT_EQ(imported.skeleton.branches[1].start_node, imported.skeleton.end_node(0));
}

TEST(Repair, TakesTheLowestStartForTheBase) {
  const ImportedSkeleton imported = mend(raw_tree({{{0, 0, 1}, {0, 0, 2}, -1}, {{0, 0, 0}, {0, 0, 1}, -1}}));
  EXPECT_EQ(imported.skeleton.roots, (std::vector<Vec3>{{0, 0, 0}}));
  // The branch it is joined to is put before it.
  EXPECT_EQ(piece_of(imported.skeleton.branches[0]), 1);
  EXPECT_EQ(piece_of(imported.skeleton.branches[1]), 0);
  EXPECT_EQ(imported.skeleton.branches[1].start_node, 1);
}

TEST(Repair, DoesNotTakeALowTwigForTheBase) {
  // Below the foot of the trunk, with 5 % of its wood, and then with 20 %.
  for (const double length : {0.05, 0.2}) {
    const ImportedSkeleton imported =
        mend(raw_tree({{{0, 0, 0}, {0, 0, 4}, -1}, {{0.5, 0, -0.3}, {0.5 + length, 0, -0.3}, -1}}));
    EXPECT_EQ(imported.skeleton.roots,
              (std::vector<Vec3>{length < 0.1 ? Vec3(0, 0, 0) : Vec3(0.5, 0, -0.3)}));
    EXPECT_EQ(count_of(imported, "joined_to_nearest"), 1u);
  }
}

TEST(Repair, JoinsABrokenLimbPieceByPieceFromTheTreeOutwards) {
  // The limb hangs down, so that its outermost piece is the lowest; the pieces lie 0.1 apart, in reverse
  // order.
  const ImportedSkeleton imported = mend(raw_tree({{{0, 0, 0}, {0, 0, 5}, -1},
                                                   {{3.2, 0, 2}, {4, 0, 1.5}, -1},
                                                   {{2.1, 0, 3}, {3.1, 0, 2}, -1},
                                                   {{0.1, 0, 5}, {2, 0, 3}, -1}}));
  std::vector<int> parent(4, -1);
  for (const Branch& branch : imported.skeleton.branches) {
    const int k = imported.skeleton.parent(static_cast<int>(&branch - imported.skeleton.branches.data()));
    parent[std::size_t(piece_of(branch))] = k < 0 ? -1 : piece_of(imported.skeleton.branches[std::size_t(k)]);
  }
  EXPECT_EQ(parent, (std::vector<int>{-1, 2, 3, 0}));
}

TEST(Repair, JoinsLikeTryingEveryBranchDoes) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    const std::vector<Piece> pieces = random_pieces(60, seed, 0.3);
    const ImportedSkeleton imported = mend(raw_tree(pieces));
    const Skeleton& skeleton = imported.skeleton;
    ASSERT_EQ(skeleton.branches.size(), pieces.size());
    std::vector<int> branch_of(pieces.size());
    for (int k = 0; k < skeleton.branch_count(); ++k)
      branch_of[std::size_t(piece_of(skeleton.branches[std::size_t(k)]))] = k;

    // The same by trial: nearest loose piece first, each to the nearest branch so far.
    std::vector<int> top(pieces.size());
    for (std::size_t k = 0; k < pieces.size(); ++k) {
      top[k] = pieces[k].parent < 0 ? static_cast<int>(k) : top[std::size_t(pieces[k].parent)];
    }
    std::vector<double> wood(pieces.size(), 0);
    for (std::size_t k = 0; k < pieces.size(); ++k) {
      wood[std::size_t(top[k])] +=
          (pieces[k].end - pieces[k].start).norm() * std::pow(static_cast<double>(k + 1), 2);
    }
    int base = -1;
    for (int k = 0; k < static_cast<int>(pieces.size()); ++k) {
      if (wood[std::size_t(k)] < 0.1 * *std::max_element(wood.begin(), wood.end())) continue;
      if (base < 0 || pieces[std::size_t(k)].start.z() < pieces[std::size_t(base)].start.z()) base = k;
    }
    // All that stand within 5 % of the height of the base's are roots.
    Vec3 low = pieces[0].start, high = low;
    for (const Piece& piece : pieces) {
      low = low.cwiseMin(piece.start).cwiseMin(piece.end);
      high = high.cwiseMax(piece.start).cwiseMax(piece.end);
    }
    std::set<int> connected;
    std::vector<Vec3> roots;
    for (int k = 0; k < static_cast<int>(pieces.size()); ++k) {
      const Piece& piece = pieces[std::size_t(k)];
      if (piece.parent >= 0) continue;
      if (std::abs(piece.start.z() - pieces[std::size_t(base)].start.z()) > 0.05 * (high.z() - low.z()))
        continue;
      connected.insert(k);
      roots.push_back(piece.start);
    }
    const std::set<int> clamped = connected;
    EXPECT_EQ(skeleton.roots, roots);
    const auto distance = [&](const Vec3& p, std::size_t k) {
      const Vec3 along = pieces[k].end - pieces[k].start;
      const double s = std::clamp((p - pieces[k].start).dot(along) / along.squaredNorm(), 0.0, 1.0);
      return (p - pieces[k].start - s * along).norm();
    };
    const auto nearest = [&](int loose) {
      std::pair<double, std::size_t> best{HUGE_VAL, 0};
      for (std::size_t k = 0; k < pieces.size(); ++k) {
        if (connected.contains(top[k]))
          best = std::min(best, {distance(pieces[std::size_t(loose)].start, k), k});
      }
      return best;
    };
    std::vector<std::pair<double, int>> order;
    for (int k = 0; k < static_cast<int>(pieces.size()); ++k) {
      if (pieces[std::size_t(k)].parent < 0 && !clamped.contains(k)) order.emplace_back(nearest(k).first, k);
    }
    std::sort(order.begin(), order.end());
    EXPECT_EQ(count_of(imported, "joined_to_nearest"), order.size());
    for (const auto& [unused, loose] : order) {
      const std::size_t to = nearest(loose).second;
      connected.insert(loose);
      const Branch& carrier = skeleton.branches[std::size_t(branch_of[to])];
      const Branch& joined = skeleton.branches[std::size_t(branch_of[std::size_t(loose)])];
      const bool at_start = (joined.start - carrier.start).norm() < (joined.start - carrier.end).norm();
      const int end = skeleton.end_node(branch_of[to]);
      const bool on_a_branch = carrier.start_node >= skeleton.root_count();
      EXPECT_EQ(joined.start_node, at_start && on_a_branch ? carrier.start_node : end);
      EXPECT_EQ(joined.start, pieces[std::size_t(loose)].start);
    }
  }
}

// ---- collapsed, dropped, reordered
// -------------------------------------------------------------------------------

TEST(Repair, RehangsTheChildrenOfASegmentOfZeroLength) {
  const ImportedSkeleton imported = mend(raw_tree({{{0, 0, 0}, {0, 0, 2}, -1},
                                                   {{0, 0, 2}, {0, 0, 2}, 0},
                                                   {{0, 0, 2}, {0, 0, 2 + 1e-12}, 1},
                                                   {{0, 0, 2}, {0, 0, 3}, 2}}));
  ASSERT_EQ(imported.skeleton.branch_count(), 2);
  EXPECT_EQ(imported.skeleton.branches[1].start_node, 1);
  EXPECT_EQ(count_of(imported, "collapsed_zero_length"), 2u);
  EXPECT_EQ(message_of(imported, "collapsed_zero_length"), "2 segments of zero length collapsed");
}

TEST(Repair, KeepsTheRootOfABaseOfZeroLength) {
  const ImportedSkeleton imported =
      mend(raw_tree({{{0, 0, 0}, {0, 0, 0}, -1}, {{0, 0, 0}, {0, 0, 1}, 0}, {{0, 0, 0}, {1, 0, 1}, 0}}));
  ASSERT_EQ(imported.skeleton.branch_count(), 2);
  EXPECT_EQ(imported.skeleton.root_count(), 1);
  EXPECT_EQ(imported.skeleton.branches[0].start_node, 0);
  EXPECT_EQ(imported.skeleton.branches[1].start_node, 0);
}

TEST(Repair, DropsWhatStandsInThePlaceOfAnotherWithAllThatRepeatsOnIt) {
  // 3 repeats 1, and 4 repeats 2 on it; 5 grows from what is dropped.
  const ImportedSkeleton imported = mend(raw_tree({{{0, 0, 0}, {0, 0, 1}, -1},
                                                   {{0, 0, 1}, {0, 0, 2}, 0},
                                                   {{0, 0, 2}, {0, 0, 3}, 1},
                                                   {{0, 0, 1}, {-0.0, 0, 2}, 0},
                                                   {{0, 0, 2}, {0, 0, 3}, 3},
                                                   {{0, 0, 3}, {0, 1, 3}, 4}}));
  ASSERT_EQ(imported.skeleton.branch_count(), 4);
  EXPECT_EQ(count_of(imported, "dropped_duplicate"), 2u);
  EXPECT_EQ(message_of(imported, "dropped_duplicate"), "2 segments in the place of another dropped");
  EXPECT_EQ(piece_of(imported.skeleton.branches[3]), 5);
  EXPECT_EQ(imported.skeleton.branches[3].start_node, imported.skeleton.end_node(2));
}

TEST(Repair, DropsASecondBaseInThePlaceOfTheFirst) {
  const ImportedSkeleton imported = mend(raw_tree({{{0, 0, 0}, {0, 0, 1}, -1}, {{0, 0, 0}, {0, 0, 1}, -1}}));
  EXPECT_EQ(imported.skeleton.branch_count(), 1);
  EXPECT_EQ(count_of(imported, "dropped_duplicate"), 1u);
  EXPECT_EQ(count_of(imported, "joined_to_nearest"), 0u);
}

TEST(Repair, KeepsBranchesThatShareOnlyTheirEnds) {
  const ImportedSkeleton imported =
      mend(raw_tree({{{0, 0, 0}, {0, 0, 1}, -1},
                     {{0, 0, 1}, {0, 0, 2}, 0},
                     {{0, 0, 2}, {0, 0, 1}, 1},     // the same piece, the other way
                     {{0, 0, 1}, {0, 0, 2}, 2}}));  // the same piece on another parent
  EXPECT_EQ(imported.skeleton.branch_count(), 4);
  EXPECT_TRUE(imported.repairs.empty());
}

TEST(Repair, GivesTheSameTreeInWhateverOrderItsBranchesStand) {
  const std::vector<Piece> pieces = random_pieces(100, 5, 0);
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    std::vector<int> order(pieces.size());
    std::iota(order.begin(), order.end(), 0);
    for (std::size_t k = order.size() - 1; k > 0; --k) {
      const double u = uniform({seed, RandomStream::test, 0, k});
      std::swap(order[k], order[static_cast<std::size_t>(u * static_cast<double>(k + 1))]);
    }
    std::vector<std::size_t> stands_at(pieces.size());
    for (std::size_t k = 0; k < order.size(); ++k) stands_at[std::size_t(order[k])] = k;
    std::vector<Piece> shuffled;
    std::size_t before_parent = 0;
    for (const int k : order) {
      Piece piece = pieces[std::size_t(k)];
      if (piece.parent >= 0) {
        before_parent += stands_at[std::size_t(piece.parent)] > stands_at[std::size_t(k)];
        piece.parent = static_cast<int>(stands_at[std::size_t(piece.parent)]);
      }
      shuffled.push_back(piece);
    }
    const ImportedSkeleton imported = mend(raw_tree(shuffled));
    EXPECT_EQ(count_of(imported, "reordered"), before_parent);
    ASSERT_EQ(imported.skeleton.branches.size(), pieces.size());
    for (int k = 0; k < imported.skeleton.branch_count(); ++k) {
      const Branch& branch = imported.skeleton.branches[std::size_t(k)];
      const Piece& piece = shuffled[std::size_t(piece_of(branch))];
      EXPECT_EQ(branch.end, piece.end);
      const int parent = imported.skeleton.parent(k);
      EXPECT_EQ(parent < 0 ? -1 : piece_of(imported.skeleton.branches[std::size_t(parent)]), piece.parent);
    }
  }
}

TEST(Repair, KeepsTheOrderOfTheFileWhereParentsStandFirst) {
  const ImportedSkeleton imported = mend(raw_tree(random_pieces(100, 6, 0)));
  EXPECT_TRUE(imported.repairs.empty());
  for (int k = 0; k < imported.skeleton.branch_count(); ++k) {
    EXPECT_EQ(piece_of(imported.skeleton.branches[std::size_t(k)]), k);
  }
}

// ---- leaves
// ------------------------------------------------------------------------------------------------------

TEST(Repair, MovesLeavesWithTheirBranch) {
  RawTree tree = raw_tree(
      {{{100, 0, 2}, {100, 0, 2}, 1}, {{100, 0, 0}, {100, 0, 2}, -1}, {{100, 0, 2}, {101, 0, 2}, 0}});
  Leaf leaf;
  leaf.base = {101, 0, 2};
  leaf.length = leaf.width = leaf.area = leaf.mass = 0.1;
  leaf.position = 0.5;
  for (const int branch : {0, 1, 2}) {
    leaf.branch = branch;
    tree.leaves.push_back(leaf);
  }
  const Skeleton skeleton = mend(tree).skeleton;
  ASSERT_EQ(skeleton.leaves.size(), 3u);
  EXPECT_EQ(skeleton.leaves[0].branch, 0);  // its own was collapsed: it sits at the end of the one below
  EXPECT_EQ(skeleton.leaves[0].position, 1);
  EXPECT_EQ(skeleton.leaves[1].branch, 0);
  EXPECT_EQ(skeleton.leaves[1].position, 0.5);
  EXPECT_EQ(skeleton.leaves[2].branch, 1);
  EXPECT_EQ(skeleton.leaves[2].base, Vec3(1, 0, 2));
}

TEST(Repair, DropsLeavesOfWhatCollapsedIntoTheRootAndSaysSo) {
  RawTree tree = raw_tree({{{0, 0, 0}, {0, 0, 0}, -1}, {{0, 0, 0}, {0, 0, 2}, 0}});
  tree.leaves.emplace_back();
  const ImportedSkeleton imported = mend(tree);
  EXPECT_TRUE(imported.skeleton.leaves.empty());
  EXPECT_EQ(message_of(imported, "dropped_leaf"), "1 leaf on a collapsed segment at the root dropped");
}

// ---- roots, gaps and units
// -----------------------------------------------------------------------------------------------

TEST(Repair, ClampsEveryStemThatStandsOnTheGround) {
  // 4 m high: 5 % are 0.2 m.
  for (const double foot : {0.2, -0.2, 0.0}) {
    const ImportedSkeleton imported =
        mend(raw_tree({{{0, 0, 0}, {0, 0, 4}, -1}, {{5, 0, foot}, {5, 0, 3.8}, -1}}), false);
    ASSERT_EQ(imported.skeleton.root_count(), 2) << foot;
    EXPECT_EQ(imported.skeleton.branches[1].start_node, 1);
    EXPECT_EQ(message_of(imported, "several_roots"), "2 stems stand on the ground, each clamped at its foot");
  }
}

TEST(Repair, JoinsALoosePieceOnlyAcrossAGapThatIsSmallForIt) {
  // Radii 0.01 and 0.02, 0.8 m long: 0.03 + 2 * 0.02 + 0.25 * 0.8 = 0.27 m from the axis of the stem.
  for (const double distance : {0.26, 0.28}) {
    const RawTree tree = raw_tree({{{0, 0, 0}, {0, 0, 4}, -1}, {{distance, 0, 2}, {distance, 0, 2.8}, -1}});
    EXPECT_EQ(complaint_about(tree, false),
              distance < 0.27
                  ? ""
                  : "tree:2: has no parent, stands in the air and is 0.28 m from the nearest branch, "
                    "wanted at most 0.27 m for a piece of its size, or --allow-gaps to join it all "
                    "the same");
    EXPECT_EQ(message_of(mend(tree), "joined_to_nearest"),
              "1 segment without parent joined to the nearest branch, at " +
                  std::string(distance < 0.27 ? "0.26" : "0.28") + " m (line 2)");
  }
}

TEST(Repair, RefusesAChildThatStartsTwoParentsAway) {
  // The parent is 1 m long with a radius of 0.02, the child has 0.03: twice that is 2.1 m.
  for (const double away : {1.0, 1.5, 2.2}) {
    const RawTree tree =
        raw_tree({{{0, 0, 0}, {0, 0, 1}, -1}, {{0, 0, 1}, {0, 0, 2}, 0}, {{away, 0, 2}, {away, 0, 3}, 1}});
    EXPECT_EQ(complaint_about(tree, false),
              away < 2.1
                  ? ""
                  : "tree:3: starts 2.2 m from its parent, line 2, wanted a start on its parent (do parents "
                    "count otherwise, or were rows taken out?), or --allow-gaps to bridge it all the same");
    const ImportedSkeleton imported = mend(tree);
    EXPECT_EQ(imported.skeleton.branches[2].start, Vec3(away, 0, 2));
    EXPECT_EQ(count_of(imported, "far_from_parent"), away > 1.05 ? 1u : 0u);
  }
}

TEST(Repair, RefusesATableInWhichHalfOfAllStartAwayFromTheirParents) {
  std::vector<Piece> pieces;
  for (int k = 0; k < 6; ++k) pieces.push_back({{0, 0, 1.5 * k}, {0, 0, 1.5 * k + 1}, k - 1});
  EXPECT_NE(complaint_about(raw_tree(pieces), false).find("half of the segments start more than "),
            std::string::npos);
  EXPECT_EQ(complaint_about(raw_tree(pieces), true), "");
}

TEST(Repair, GivesTheSameTreeInEveryUnit) {
  const std::vector<Piece> pieces = random_pieces(60, 3, 0.05);
  const Skeleton in_metres = mend(raw_tree(pieces)).skeleton;
  for (const double unit : {1e-3, 1e-2, 0.3048}) {
    RawTree tree = raw_tree(pieces);
    for (Vec3& root : tree.roots) root /= unit;
    for (RawBranch& branch : tree.branches) {
      for (Vec3* point : {&branch.start, &branch.end}) *point /= unit;
      for (double* radius : {&branch.start_radius, &branch.end_radius}) *radius /= unit;
    }
    const Skeleton scaled =
        repair(tree, "test", CarrierRule::nearer_end, {.unit = unit, .allow_gaps = true}).skeleton;
    ASSERT_EQ(scaled.branch_count(), in_metres.branch_count());
    for (std::size_t k = 0; k < scaled.branches.size(); ++k) {
      EXPECT_EQ(scaled.branches[k].start_node, in_metres.branches[k].start_node);
      EXPECT_LE((scaled.branches[k].end - in_metres.branches[k].end).norm(), 1e-13);
      EXPECT_NEAR(scaled.branches[k].end_radius, in_metres.branches[k].end_radius, 1e-15);
    }
  }
}

// ---- refused
// -----------------------------------------------------------------------------------------------------

TEST(Repair, RejectsWhatCannotBeAPlant) {
  EXPECT_EQ(complaint_about(raw_tree({})), "tree: no branch, wanted at least one");
  EXPECT_EQ(complaint_about(raw_tree({{{0, 0, 0}, {0, 0, 0}, -1}})),
            "tree: the whole plant measures 0 m, wanted at least 1e-06 m");
  EXPECT_EQ(
      complaint_about(raw_tree({{{0, 0, 0}, {0, 0, 1e8}, -1}})),
      "tree: the whole plant measures 1e+08 m, wanted at most 1e+06 m (--unit says what unit the file is "
      "in)");
  EXPECT_EQ(complaint_about(raw_tree({{{0, 0, 0}, {0, 0, 0}, -1}, {{1, 0, 0}, {1, 0, 0}, -1}})),
            "tree: every branch has zero length, wanted at least one with a length");
}

TEST(Repair, RejectsPiecesTooEntangledToJoin) {
  std::vector<Piece> pieces = random_pieces(100, 1, 0);
  for (std::size_t k = 1; k < pieces.size(); k += 2) pieces[k].parent = -1;
  const auto complaint_within = [&](std::size_t visits) {
    return test::complaint_of(
        [&] { repair(raw_tree(pieces), "test", CarrierRule::end, {.allow_gaps = true}, visits); });
  };
  EXPECT_EQ(complaint_within(100000), "");
  EXPECT_NE(complaint_within(50).find(
                "pieces without parent lie entangled, wanted a file in which most branches have a parent"),
            std::string::npos);
}

TEST(Repair, NamesTheCircleThatParentsGoRoundIn) {
  EXPECT_EQ(complaint_about(raw_tree({{{0, 0, 0}, {0, 0, 1}, -1}, {{0, 0, 1}, {0, 0, 2}, 1}})),
            "tree:2: parents go round in a circle (2 > 2), wanted parents that lead to a root");
  EXPECT_EQ(complaint_about(raw_tree({{{0, 0, 0}, {0, 0, 1}, -1},
                                      {{0, 0, 1}, {0, 0, 2}, 2},
                                      {{0, 0, 1}, {0, 0, 2}, 3},
                                      {{0, 0, 1}, {0, 0, 2}, 2}})),
            "tree:3: parents go round in a circle (3 > 4 > 3), wanted parents that lead to a root");
  std::vector<Piece> ring(1000, {{0, 0, 0}, {0, 0, 1}, 0});
  for (int k = 0; k < 1000; ++k) ring[std::size_t(k)].parent = (k + 1) % 1000;
  EXPECT_EQ(complaint_about(raw_tree(ring)),
            "tree:1: parents go round in a circle (1 > 2 > 3 > 4 > 5 > 6 > ... > 1), wanted parents that "
            "lead to a root");
}

TEST(Repair, RejectsCoordinatesThatHaveLostTheLengths) {
  // Single precision at 5000 km leaves half metres; the branches are 1 m long.
  RawTree tree = raw_tree({{{5e6, 0, 0}, {5e6, 0, 1}, -1}, {{5e6, 0, 1}, {5e6, 0, 2}, 0}});
  EXPECT_EQ(complaint_about(tree), "");
  tree.resolution = 0x1p-23;
  EXPECT_EQ(complaint_about(tree),
            "tree: coordinates up to 5e+06 m are known to 0.596046 m only, with branches of 1 m on "
            "average, "
            "wanted coordinates nearer to the origin or in higher precision");
}

}  // namespace
}  // namespace tremula
