#include "tremula/render/raster.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "tremula/numerics/random.hpp"

namespace tremula {
namespace {

double draw(std::uint32_t what, std::uint64_t place) { return uniform({5, RandomStream::test, what, place}); }

// A vertex of a perspective view at picture coordinates x, y in [-1, 1] and a depth.
RasterVertex at(double x, double y, double depth) {
  const auto w = static_cast<float>(depth);
  return {static_cast<float>(x) * w, static_cast<float>(y) * w, w, w};
}

long covered(const VisibilityBuffer& buffer) {
  return std::count_if(buffer.triangle.begin(), buffer.triangle.end(),
                       [](std::uint32_t t) { return t != no_triangle; });
}

TEST(Rasterise, CoversTheAreaOfATriangleOfEitherFace) {
  const std::vector<RasterVertex> vertices = {at(-0.8, -0.6, 3), at(0.7, -0.3, 5), at(0.1, 0.9, 4)};
  const double area = 0.5 * std::abs(1.5 * 1.5 - 0.3 * 0.9) / 4 * 500 * 500;
  for (const std::vector<std::uint32_t>& indices : {std::vector<std::uint32_t>{0, 1, 2}, {0, 2, 1}}) {
    const VisibilityBuffer buffer = rasterise(vertices, indices, 500, 500, true, 0.1F);
    EXPECT_NEAR(static_cast<double>(covered(buffer)), area, 0.003 * area);
  }
}

TEST(Rasterise, EverySampleOfASharedEdgeBelongsToOneTriangle) {
  // A square cut into a mesh with random inner points: drawn one by one, its triangles cover as many samples
  // as the square has, no more and no less.
  constexpr int n = 6;
  std::vector<RasterVertex> vertices;
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) {
      const bool inner = i > 0 && j > 0 && i < n && j < n;
      const double shift_x = inner ? 0.4 * (draw(0, std::uint64_t(j * 100 + i)) - 0.5) : 0;
      const double shift_y = inner ? 0.4 * (draw(1, std::uint64_t(j * 100 + i)) - 0.5) : 0;
      vertices.push_back(at(2 * (i + shift_x) / n - 1, 2 * (j + shift_y) / n - 1, 2));
    }
  }
  std::vector<std::uint32_t> indices;
  for (std::uint32_t j = 0; j < n; ++j) {
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t a = j * (n + 1) + i;
      indices.insert(indices.end(), {a, a + 1, a + n + 2, a, a + n + 2, a + n + 1});
    }
  }
  for (const int size : {16, 100, 101}) {
    long sum = 0;
    for (std::size_t t = 0; t < indices.size(); t += 3) {
      sum += covered(rasterise(vertices, std::span(indices).subspan(t, 3), size, size, true, 0.1F));
    }
    EXPECT_EQ(sum, size * size);
    EXPECT_EQ(covered(rasterise(vertices, indices, size, size, true, 0.1F)), size * size);
  }
}

TEST(Rasterise, TheNearerTriangleWinsInEitherOrderAndTheFirstOfEquals) {
  const std::vector<RasterVertex> vertices = {at(-1, -1, 2), at(1, -1, 2), at(0, 1, 2),
                                              at(-1, -1, 3), at(1, -1, 3), at(0, 1, 3)};
  const std::size_t middle = 32 * 64 + 32;
  EXPECT_EQ(
      rasterise(vertices, std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5}, 64, 64, true, 0.1F).triangle[middle],
      0U);
  EXPECT_EQ(
      rasterise(vertices, std::vector<std::uint32_t>{3, 4, 5, 0, 1, 2}, 64, 64, true, 0.1F).triangle[middle],
      1U);
  EXPECT_EQ(
      rasterise(vertices, std::vector<std::uint32_t>{0, 1, 2, 1, 2, 0}, 64, 64, true, 0.1F).triangle[middle],
      0U);
}

TEST(Rasterise, TrianglesThatCrossShowEachItsNearerPart) {
  const std::vector<RasterVertex> vertices = {at(-1, -1, 2), at(1, -1, 4), at(1, 1, 4), at(-1, 1, 2),
                                              at(-1, -1, 4), at(1, -1, 2), at(1, 1, 2), at(-1, 1, 4)};
  const std::vector<std::uint32_t> indices = {0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7};
  const VisibilityBuffer buffer = rasterise(vertices, indices, 64, 64, true, 0.1F);
  for (std::size_t y = 0; y < 64; ++y) {
    for (std::size_t x = 0; x < 64; ++x) EXPECT_EQ(buffer.triangle[y * 64 + x] < 2, x < 32) << x << ' ' << y;
  }
}

TEST(Rasterise, NearnessIsThatOfThePlane) {
  // The plane z = 3 + 0.5 x seen from the origin along z: 1/z = (1 - 0.5 x/z) / 3.
  const auto plane = [](double px, double py) {
    const double depth = 3 / (1 - 0.5 * px);
    return at(px, py, depth);
  };
  const std::vector<RasterVertex> vertices = {plane(-1, -1), plane(1, -1), plane(0, 1)};
  const VisibilityBuffer buffer =
      rasterise(vertices, std::vector<std::uint32_t>{0, 1, 2}, 200, 200, true, 0.1F);
  for (int y = 0; y < 200; ++y) {
    for (int x = 0; x < 200; ++x) {
      const auto sample = static_cast<std::size_t>(y * 200 + x);
      if (buffer.triangle[sample] == no_triangle) continue;
      EXPECT_NEAR(buffer.nearness[sample], (1 - 0.5 * (2 * (x + 0.5) / 200 - 1)) / 3, 1e-5);
    }
  }
  EXPECT_GT(covered(buffer), 10000);
}

TEST(Rasterise, AFloorThatRunsBehindTheEyeFillsTheLowerHalf) {
  // y = -1 for depths from -1000 to 1000; the horizon is the middle row.
  const auto floor_point = [](float x, float depth) { return RasterVertex{x, -1, depth, depth}; };
  const std::vector<RasterVertex> vertices = {floor_point(-5000, -1000), floor_point(5000, -1000),
                                              floor_point(5000, 1000), floor_point(-5000, 1000)};
  const VisibilityBuffer buffer =
      rasterise(vertices, std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3}, 80, 80, true, 0.01F);
  for (std::size_t y = 0; y < 80; ++y) {
    for (std::size_t x = 0; x < 80; ++x) {
      const bool below = y >= 40;
      EXPECT_EQ(buffer.triangle[y * 80 + x] != no_triangle, below) << x << ' ' << y;
      if (below) {
        EXPECT_NEAR(buffer.nearness[y * 80 + x], (2 * (double(y) + 0.5) / 80 - 1), 2e-3);
      }
    }
  }
}

TEST(Rasterise, WhatIsBehindOrBesideTheViewIsNotDrawn) {
  const std::vector<RasterVertex> vertices = {{-1, -1, -2, -2}, {1, -1, -2, -2}, {0, 1, -2, -2},
                                              at(1.1, -1, 2),   at(3, -1, 2),    at(2, 1, 2)};
  EXPECT_EQ(covered(rasterise(vertices, std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5}, 64, 64, true, 0.1F)),
            0);
}

TEST(Rasterise, ASphereCoversItsSolidDisc) {
  // Seen from a distance d, a sphere of radius r is a disc of radius r / sqrt(d^2 - r^2) at distance 1.
  constexpr int rings = 60, sectors = 120;
  const double r = 1, d = 3;
  std::vector<RasterVertex> vertices;
  for (int i = 0; i <= rings; ++i) {
    for (int j = 0; j < sectors; ++j) {
      const double theta = M_PI * i / rings, phi = 2 * M_PI * j / sectors;
      const double depth = d + r * std::cos(theta);
      vertices.push_back({float(r * std::sin(theta) * std::cos(phi)),
                          float(r * std::sin(theta) * std::sin(phi)), float(depth), float(depth)});
    }
  }
  std::vector<std::uint32_t> indices;
  for (std::uint32_t i = 0; i < rings; ++i) {
    for (std::uint32_t j = 0; j < sectors; ++j) {
      const std::uint32_t a = i * sectors + j, b = i * sectors + (j + 1) % sectors;
      indices.insert(indices.end(), {a, b, b + sectors, a, b + sectors, a + sectors});
    }
  }
  const VisibilityBuffer buffer = rasterise(vertices, indices, 600, 600, true, 0.1F);
  const double disc = M_PI * r * r / (d * d - r * r) / 4 * 600 * 600;
  EXPECT_NEAR(static_cast<double>(covered(buffer)), disc, 0.003 * disc);
  EXPECT_NEAR(buffer.nearness[300 * 600 + 300], 1 / (d - r), 1e-3);
}

TEST(Rasterise, IsTheSameOnAnyNumberOfThreads) {
  std::vector<RasterVertex> vertices;
  for (std::uint64_t v = 0; v < 30000; ++v) {
    const double x = 2 * draw(2, v / 3) - 1 + 0.1 * draw(3, v), y = 2 * draw(4, v / 3) - 1 + 0.1 * draw(5, v);
    vertices.push_back(at(x, y, 1 + std::floor(4 * draw(6, v / 3))));
  }
  std::vector<std::uint32_t> indices(vertices.size());
  std::iota(indices.begin(), indices.end(), 0U);
  std::vector<VisibilityBuffer> results;
  for (const std::size_t threads : {1, 2, 5}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    results.push_back(rasterise(vertices, indices, 300, 200, true, 0.1F));
  }
  for (const VisibilityBuffer& result : results) {
    EXPECT_EQ(result.triangle, results[0].triangle);
    EXPECT_EQ(result.nearness, results[0].nearness);
  }
}

}  // namespace
}  // namespace tremula
