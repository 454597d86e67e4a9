// Finds the branch nearest to a point among those that belong to the tree so far, while the tree grows.
#pragma once

#include "tremula/base/types.hpp"

#include <cstddef>
#include <vector>

namespace tremula {

// A tree of boxes over straight segments. Each box counts the segments in it that have been included, so that
// a search passes by what does not belong yet.
class NearestBranch {
 public:
  struct Segment {
    Vec3 start, end;
  };
  struct Found {
    int segment = -1;             // -1: none included
    double squared_distance = 0;  // from the point to the axis [m^2]
  };

  explicit NearestBranch(std::vector<Segment> segments);

  void include(int segment);
  // Ties go to the lower index. `visited` grows by the number of boxes and segments looked at.
  Found nearest(const Vec3& point, std::size_t& visited) const;

 private:
  struct Box {
    Vec3 low, high;
    int first, last;   // range of order_
    int left, right;   // children, or -1 in a leaf
    int up;            // parent, or -1
    int included = 0;  // segments in it that count
  };

  int build(int first, int last, int up);

  std::vector<Segment> segments_;
  std::vector<int> order_;    // segments, box by box
  std::vector<int> leaf_of_;  // the leaf box of each segment
  std::vector<char> included_;
  std::vector<Box> boxes_;
};

double squared_distance(const Vec3& point, const NearestBranch::Segment& segment);  // [m^2]

}  // namespace tremula
