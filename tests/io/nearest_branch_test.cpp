#include "tremula/io/nearest_branch.hpp"

#include <cmath>
#include <utility>

#include <gtest/gtest.h>

#include "tremula/numerics/random.hpp"

namespace tremula {
namespace {

double uniform_at(std::uint64_t place, std::uint32_t what) {
  return uniform({11, RandomStream::test, what, place});
}

Vec3 point_at(std::uint64_t place, std::uint32_t what) {
  return {uniform_at(place, what), uniform_at(place, what + 1), uniform_at(place, what + 2)};
}

// The least over many points of the segment: an upper bound, and within (length/steps)^2/4 of the truth.
double squared_distance_by_sampling(const Vec3& point, const NearestBranch::Segment& segment, int steps) {
  double least = HUGE_VAL;
  for (int i = 0; i <= steps; ++i) {
    const Vec3 on = segment.start + (segment.end - segment.start) * (static_cast<double>(i) / steps);
    least = std::min(least, (point - on).squaredNorm());
  }
  return least;
}

TEST(NearestBranch, FindsWhatTryingAllFindsWhileTheTreeGrows) {
  constexpr int count = 100;
  std::vector<NearestBranch::Segment> segments;
  for (std::uint64_t k = 0; k < count; ++k) {
    const Vec3 start = point_at(k, 0);
    segments.push_back({start, start + 0.3 * (point_at(k, 3) - Vec3::Constant(0.5))});
  }
  segments[17].end = segments[17].start;  // a segment may be a point
  NearestBranch search(segments);
  std::size_t visited = 0;
  EXPECT_EQ(search.nearest(Vec3::Zero(), visited).segment, -1);
  constexpr int steps = 100;
  const double error = std::pow(0.3 * std::sqrt(0.75) / steps, 2) / 4;
  for (int included = 1; included <= count; ++included) {
    search.include((included * 7) % count);
    const Vec3 point = 2 * point_at(static_cast<std::uint64_t>(included), 6) - Vec3::Constant(0.5);
    double least = HUGE_VAL;
    for (int i = 1; i <= included; ++i) {
      least =
          std::min(least, squared_distance_by_sampling(point, segments[std::size_t((i * 7) % count)], steps));
    }
    const NearestBranch::Found found = search.nearest(point, visited);
    EXPECT_NEAR(found.squared_distance, least, error + 1e-15);
    EXPECT_NEAR(squared_distance_by_sampling(point, segments[std::size_t(found.segment)], steps), least,
                error + 1e-15);
  }
}

TEST(NearestBranch, PrefersTheFirstOfSeveralEquallyNear) {
  const NearestBranch::Segment same{{0, 0, 0}, {0, 0, 1}};
  NearestBranch search(std::vector<NearestBranch::Segment>(50, same));
  for (const int k : {41, 7, 30}) search.include(k);
  std::size_t visited = 0;
  EXPECT_EQ(search.nearest({1, 0, 0.5}, visited).segment, 7);
}

TEST(NearestBranch, LooksAtAFewBoxesOfMany) {
  std::vector<NearestBranch::Segment> segments;
  for (std::uint64_t k = 0; k < 20000; ++k) {
    const Vec3 start = point_at(k, 0);
    segments.push_back({start, start + 0.01 * point_at(k, 3)});
  }
  NearestBranch search(segments);
  for (int k = 0; k < 20000; ++k) search.include(k);
  std::size_t visited = 0;
  for (std::uint64_t q = 0; q < 100; ++q) search.nearest(point_at(q, 6), visited);
  EXPECT_LT(visited, 100 * 200u);
}

}  // namespace
}  // namespace tremula
