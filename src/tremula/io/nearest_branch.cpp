#include "tremula/io/nearest_branch.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace tremula {
namespace {

double squared_distance(const Vec3& point, const Vec3& low, const Vec3& high) {
  return (point - point.cwiseMax(low).cwiseMin(high)).squaredNorm();
}

}  // namespace

double squared_distance(const Vec3& point, const NearestBranch::Segment& segment) {
  const Vec3 along = segment.end - segment.start;
  const double length2 = along.squaredNorm();
  const double s = length2 > 0 ? std::clamp((point - segment.start).dot(along) / length2, 0.0, 1.0) : 0.0;
  return (point - segment.start - s * along).squaredNorm();
}

NearestBranch::NearestBranch(std::vector<Segment> segments)
    : segments_(std::move(segments)),
      order_(segments_.size()),
      leaf_of_(segments_.size(), -1),
      included_(segments_.size(), 0) {
  std::iota(order_.begin(), order_.end(), 0);
  if (!segments_.empty()) build(0, static_cast<int>(segments_.size()), -1);
}

// Halves at the median, so the depth is a logarithm whatever the segments are.
int NearestBranch::build(int first, int last, int up) {
  Box box{Vec3::Constant(HUGE_VAL), Vec3::Constant(-HUGE_VAL), first, last, -1, -1, up};
  for (int i = first; i < last; ++i) {
    const Segment& segment = segments_[order_[i]];
    box.low = box.low.cwiseMin(segment.start).cwiseMin(segment.end);
    box.high = box.high.cwiseMax(segment.start).cwiseMax(segment.end);
  }
  const int self = static_cast<int>(boxes_.size());
  boxes_.push_back(box);
  if (last - first <= 4) {
    for (int i = first; i < last; ++i) {
      leaf_of_[order_[i]] = self;
    }
    return self;
  }
  int axis;
  (box.high - box.low).maxCoeff(&axis);
  const int middle = first + (last - first) / 2;
  const auto twice_centre = [&](int k) {
    const Segment& segment = segments_[k];
    return segment.start[axis] + segment.end[axis];
  };
  std::nth_element(order_.begin() + first, order_.begin() + middle, order_.begin() + last, [&](int a, int b) {
    return std::pair(twice_centre(a), a) < std::pair(twice_centre(b), b);
  });
  const int left = build(first, middle, self);
  const int right = build(middle, last, self);
  boxes_[self].left = left;
  boxes_[self].right = right;
  return self;
}

void NearestBranch::include(int segment) {
  char& included = included_[segment];
  if (included) return;
  included = 1;
  for (int b = leaf_of_[segment]; b >= 0; b = boxes_[b].up) {
    ++boxes_[b].included;
  }
}

NearestBranch::Found NearestBranch::nearest(const Vec3& point, std::size_t& visited) const {
  Found best{-1, HUGE_VAL};
  if (boxes_.empty()) return best;
  std::vector<std::pair<double, int>> open{{0.0, 0}};
  while (!open.empty()) {
    const auto [bound, index] = open.back();
    open.pop_back();
    const Box& box = boxes_[index];
    ++visited;
    if (box.included == 0 || bound > best.squared_distance) continue;
    if (box.left < 0) {
      for (int i = box.first; i < box.last; ++i) {
        const int k = order_[i];
        if (!included_[k]) continue;
        const double d = squared_distance(point, segments_[k]);
        if (std::pair(d, k) < std::pair(best.squared_distance, best.segment)) best = {k, d};
      }
      continue;
    }
    // The nearer child is looked at first.
    std::pair<double, int> children[2];
    int c = 0;
    for (const int child : {box.left, box.right}) {
      const Box& inner = boxes_[child];
      children[c++] = {squared_distance(point, inner.low, inner.high), child};
    }
    if (children[0] < children[1]) std::swap(children[0], children[1]);
    open.insert(open.end(), {children[0], children[1]});
  }
  return best;
}

}  // namespace tremula
