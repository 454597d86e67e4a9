#include "tremula/structure/mode_count.hpp"

#include "tremula/base/error.hpp"
#include "tremula/structure/element_blocks.hpp"

#include <numeric>
#include <string>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace tremula {
namespace {

int negative_count(const Mat6& pivot) {
  if (Eigen::LLT<Mat6>(pivot).info() == Eigen::Success) return 0;  // most are
  const Eigen::SelfAdjointEigenSolver<Mat6> solver(pivot, Eigen::EigenvaluesOnly);
  return static_cast<int>((solver.eigenvalues().array() < 0).count());
}

}  // namespace

std::vector<int> negative_pivots(const BeamTree& tree, double omega) {
  if (!(omega >= 0 && omega <= 1e140)) {
    throw InputError("omega", std::to_string(omega), "0 to 1e140 rad/s");
  }
  const double minus_square = -omega * omega;
  // What hangs on the end of each branch, as a dynamic stiffness there; filled by its children before it is
  // read.
  std::vector<Mat6> carried(tree.parent.size(), Mat6::Zero());
  std::vector<int> counts(tree.parent.size());
  for (int k = tree.branch_count() - 1; k >= 0; --k) {
    const auto index = static_cast<std::size_t>(k);
    const Vec3& direction = tree.members[index].direction;
    const ElementBlocks mass = mass_blocks(tree, index);
    const Mat6 end = minus_square * mass.end + carried[index];
    const Mat6 root = compliance_root(tree.compliances[index], direction);
    const bool loaded = tree.is_loaded();
    const Mat6 on_end = loaded ? Mat6(end + tree.geometric[index].relative) : end;
    const Mat6 pivot = Mat6::Identity() + root.transpose() * on_end * root;
    counts[index] = negative_count(pivot);

    const int parent = tree.parent[index];
    if (parent < 0) continue;
    // In (u_start, e), u_end = R u_start + e; then e is eliminated.
    const Mat6 rigid = rigid_carry(tree.reach[index] - tree.members[index].start_arm);
    Mat6 coupling = minus_square * mass.cross + rigid.transpose() * end;
    if (loaded) coupling.bottomRows<3>() += tree.geometric[index].carried;
    const Mat6 start =
        minus_square * (mass.start + mass.cross * rigid + rigid.transpose() * mass.cross.transpose()) +
        rigid.transpose() * end * rigid;
    const Mat6 half = root.transpose() * coupling.transpose();
    const Mat6 at_start = start - half.transpose() * pivot.ldlt().solve(half);
    const Mat6 to_node = rigid_carry(tree.members[index].start_arm);
    carried[static_cast<std::size_t>(parent)] += to_node.transpose() * at_start * to_node;
  }
  return counts;
}

int count_modes_below(const BeamTree& tree, double omega) {
  const std::vector<int> counts = negative_pivots(tree, omega);
  return std::accumulate(counts.begin(), counts.end(), 0);
}

}  // namespace tremula
