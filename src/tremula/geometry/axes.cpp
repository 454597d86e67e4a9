#include "tremula/geometry/axes.hpp"

#include "tremula/geometry/surface.hpp"

#include <algorithm>
#include <cmath>

namespace tremula {

std::vector<Vec3> branch_directions(const Skeleton& skeleton) {
  std::vector<Vec3> directions(skeleton.branches.size());
  for (int k = 0; k < skeleton.branch_count(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    const Vec3 along = skeleton.branches[i].end - skeleton.branches[i].start;
    const int below = skeleton.parent(k);
    if (along.norm() > 1e-12) {
      directions[i] = along.normalized();
    } else {
      directions[i] = below < 0 ? Vec3(Vec3::UnitZ()) : directions[static_cast<std::size_t>(below)];
    }
  }
  return directions;
}

std::vector<int> branch_continuations(const Skeleton& skeleton) {
  const std::size_t count = skeleton.branches.size();
  const std::vector<Vec3> directions = branch_directions(skeleton);

  // How much wood hangs on each branch, itself included: scanned radii alone are too noisy to follow a stem.
  std::vector<double> reach(count);
  for (std::size_t k = count; k-- > 0;) {
    reach[k] += skeleton.branches[k].length() + skeleton.branches[k].start_radius;
    const int below = skeleton.parent(static_cast<int>(k));
    if (below >= 0) reach[static_cast<std::size_t>(below)] += reach[k];
  }

  std::vector<int> continuation(count, -1);
  std::vector<double> best(count, 0.0);
  for (std::size_t k = 0; k < count; ++k) {
    const int below = skeleton.parent(static_cast<int>(k));
    if (below < 0) continue;
    const auto p = static_cast<std::size_t>(below);
    const Branch& branch = skeleton.branches[k];
    const Branch& lower = skeleton.branches[p];
    const double straightness = directions[p].dot(directions[k]);
    // No tube bends by more than 120 degrees. The cylinders of a scanned stem often miss each other by more
    // than their radius: that is no gap in the stem as long as they run on in much the same direction.
    const double gap = (branch.start - lower.end).norm();
    const double reachable = lower.end_radius + 0.3 * (lower.length() + branch.length());
    if (straightness < -0.5 || (gap > lower.end_radius && (straightness < 0.5 || gap > reachable))) continue;
    const double score =
        branch.start_radius * (1.2 + straightness) * std::pow(reach[k], 0.25) / (1 + gap / lower.end_radius);
    if (score > best[p]) {
      best[p] = score;
      continuation[p] = static_cast<int>(k);
    }
  }
  return continuation;
}

std::vector<std::vector<int>> split_into_axes(const Skeleton& skeleton) {
  const std::vector<int> continuation = branch_continuations(skeleton);
  std::vector<std::vector<int>> axes;
  for (int k = 0; k < skeleton.branch_count(); ++k) {
    const int below = skeleton.parent(k);
    if (below >= 0 && continuation[static_cast<std::size_t>(below)] == k) continue;
    std::vector<int>& axis = axes.emplace_back();
    for (int next = k; next >= 0; next = continuation[static_cast<std::size_t>(next)]) axis.push_back(next);
  }
  return axes;
}

}  // namespace tremula
