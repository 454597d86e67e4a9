#include "tremula/render/raster.hpp"

#include "tremula/base/check.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace tremula {
namespace {

// Samples lie on a grid this fine: edges that two triangles share are then the same edge exactly.
constexpr int subpixel_bits = 8;
constexpr float subpixel = 1 << subpixel_bits;
constexpr float guard =
    4;  // triangles that reach farther than this many half-pictures from the middle are cut

struct ScreenTriangle {
  std::array<std::int32_t, 3> x, y;  // [subpixels]
  std::array<float, 3> nearness;
  std::uint32_t index;
};

// Keeps the part of a convex polygon where distance(vertex) >= 0.
template <typename Distance>
void cut(std::vector<RasterVertex>& polygon, const Distance& distance) {
  std::vector<RasterVertex> kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const RasterVertex& a = polygon[i];
    const RasterVertex& b = polygon[(i + 1) % polygon.size()];
    const float at_a = distance(a);
    const float at_b = distance(b);
    if (at_a >= 0) kept.push_back(a);
    if ((at_a < 0) != (at_b < 0)) {
      const float t = at_a / (at_a - at_b);
      kept.push_back({a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), a.w + t * (b.w - a.w),
                      a.depth + t * (b.depth - a.depth)});
    }
  }
  polygon = std::move(kept);
}

struct Screen {
  int width, height;
  bool perspective;
  float near_w;

  void append(const RasterVertex& a, const RasterVertex& b, const RasterVertex& c, std::uint32_t index,
              std::vector<ScreenTriangle>& out) const {
    ScreenTriangle t;
    t.index = index;
    const std::array<const RasterVertex*, 3> corners = {&a, &b, &c};
    for (std::size_t i = 0; i < 3; ++i) {
      const RasterVertex& v = *corners[i];
      t.x[i] = static_cast<std::int32_t>(
          std::lround((v.x / v.w + 1) * 0.5F * static_cast<float>(width) * subpixel));
      t.y[i] = static_cast<std::int32_t>(
          std::lround((1 - v.y / v.w) * 0.5F * static_cast<float>(height) * subpixel));
      t.nearness[i] = perspective ? 1 / v.depth : -v.depth;
    }
    const std::int64_t area =
        std::int64_t{t.x[1] - t.x[0]} * (t.y[2] - t.y[0]) - std::int64_t{t.y[1] - t.y[0]} * (t.x[2] - t.x[0]);
    if (area == 0) return;
    if (area < 0) {
      std::swap(t.x[1], t.x[2]);
      std::swap(t.y[1], t.y[2]);
      std::swap(t.nearness[1], t.nearness[2]);
    }
    out.push_back(t);
  }

  void clip(const RasterVertex& a, const RasterVertex& b, const RasterVertex& c, std::uint32_t index,
            std::vector<ScreenTriangle>& out) const {
    const auto all = [&](auto outside) { return outside(a) && outside(b) && outside(c); };
    const auto any = [&](auto outside) { return outside(a) || outside(b) || outside(c); };
    if (all([&](const RasterVertex& v) { return v.w < near_w; })) return;
    if (all([](const RasterVertex& v) { return v.x > v.w; })) return;
    if (all([](const RasterVertex& v) { return v.x < -v.w; })) return;
    if (all([](const RasterVertex& v) { return v.y > v.w; })) return;
    if (all([](const RasterVertex& v) { return v.y < -v.w; })) return;
    if (!any([&](const RasterVertex& v) {
          return v.w < near_w || std::max(std::abs(v.x), std::abs(v.y)) > guard * v.w;
        })) {
      append(a, b, c, index, out);
      return;
    }
    std::vector<RasterVertex> polygon = {a, b, c};
    cut(polygon, [&](const RasterVertex& v) { return v.w - near_w; });
    cut(polygon, [](const RasterVertex& v) { return guard * v.w - v.x; });
    cut(polygon, [](const RasterVertex& v) { return guard * v.w + v.x; });
    cut(polygon, [](const RasterVertex& v) { return guard * v.w - v.y; });
    cut(polygon, [](const RasterVertex& v) { return guard * v.w + v.y; });
    for (std::size_t i = 2; i < polygon.size(); ++i)
      append(polygon[0], polygon[i - 1], polygon[i], index, out);
  }
};

// First sample whose centre is not left of (above) the coordinate, and the last that is not right of (below)
// it.
int first_sample(std::int32_t low) { return (low + (1 << (subpixel_bits - 1)) - 1) >> subpixel_bits; }
int last_sample(std::int32_t high) { return (high - (1 << (subpixel_bits - 1))) >> subpixel_bits; }

void draw(const ScreenTriangle& t, int top, int bottom, VisibilityBuffer& buffer) {
  const auto [x_low, x_high] = std::minmax({t.x[0], t.x[1], t.x[2]});
  const auto [y_low, y_high] = std::minmax({t.y[0], t.y[1], t.y[2]});
  const int x0 = std::max(first_sample(x_low), 0);
  const int x1 = std::min(last_sample(x_high), buffer.width - 1);
  const int y0 = std::max(first_sample(y_low), top);
  const int y1 = std::min(last_sample(y_high), bottom - 1);
  if (x0 > x1 || y0 > y1) return;

  // Edge i lies opposite corner i; its function grows inwards. A sample on an edge belongs to the triangle
  // whose left or top edge it is.
  std::array<std::int64_t, 3> row, step_x, step_y;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t a = (i + 1) % 3, b = (i + 2) % 3;
    const std::int64_t dx = t.x[b] - t.x[a], dy = t.y[b] - t.y[a];
    const std::int64_t px = (std::int64_t{x0} << subpixel_bits) + (1 << (subpixel_bits - 1));
    const std::int64_t py = (std::int64_t{y0} << subpixel_bits) + (1 << (subpixel_bits - 1));
    const bool owns_edge = dy < 0 || (dy == 0 && dx > 0);
    row[i] = dx * (py - t.y[a]) - dy * (px - t.x[a]) - (owns_edge ? 0 : 1);
    step_x[i] = -dy * (1 << subpixel_bits);
    step_y[i] = dx * (1 << subpixel_bits);
  }
  const double area = static_cast<double>(std::int64_t{t.x[1] - t.x[0]} * (t.y[2] - t.y[0]) -
                                          std::int64_t{t.y[1] - t.y[0]} * (t.x[2] - t.x[0]));
  const double slope_1 = (static_cast<double>(t.nearness[1]) - t.nearness[0]) / area;
  const double slope_2 = (static_cast<double>(t.nearness[2]) - t.nearness[0]) / area;
  const auto near_step =
      static_cast<float>(slope_1 * static_cast<double>(step_x[1]) + slope_2 * static_cast<double>(step_x[2]));
  for (int y = y0; y <= y1; ++y) {
    std::int64_t e0 = row[0], e1 = row[1], e2 = row[2];
    const std::size_t line = static_cast<std::size_t>(y) * static_cast<std::size_t>(buffer.width);
    const auto near_row = static_cast<float>(t.nearness[0] + slope_1 * static_cast<double>(e1) +
                                             slope_2 * static_cast<double>(e2));
    for (int x = x0; x <= x1; ++x) {
      if ((e0 | e1 | e2) >= 0) {
        const float nearness = near_row + near_step * static_cast<float>(x - x0);
        const std::size_t sample = line + static_cast<std::size_t>(x);
        if (nearness > buffer.nearness[sample]) {
          buffer.nearness[sample] = nearness;
          buffer.triangle[sample] = t.index;
        }
      }
      e0 += step_x[0];
      e1 += step_x[1];
      e2 += step_x[2];
    }
    for (std::size_t i = 0; i < 3; ++i) row[i] += step_y[i];
  }
}

}  // namespace

VisibilityBuffer rasterise(std::span<const RasterVertex> vertices, std::span<const std::uint32_t> indices,
                           int width, int height, bool perspective, float near_w) {
  check_at_least("width of the picture", width, 1);
  check_at_least("height of the picture", height, 1);
  for (const std::uint32_t index : indices) {
    if (index >= vertices.size()) {
      throw InputError("index of a triangle", std::to_string(index),
                       "below " + std::to_string(vertices.size()));
    }
  }
  VisibilityBuffer buffer{width, height, perspective, {}, {}};
  const std::size_t samples = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  buffer.nearness.assign(samples, -std::numeric_limits<float>::infinity());
  buffer.triangle.assign(samples, no_triangle);

  // To the screen, in pieces whose order does not depend on who works on them.
  constexpr std::size_t piece = 4096;
  const std::size_t triangles = indices.size() / 3;
  std::vector<std::vector<ScreenTriangle>> pieces((triangles + piece - 1) / piece);
  const Screen screen{width, height, perspective, near_w};
  tbb::parallel_for(std::size_t{0}, pieces.size(), [&](std::size_t p) {
    pieces[p].reserve(piece);
    for (std::size_t t = p * piece; t < std::min((p + 1) * piece, triangles); ++t) {
      screen.clip(vertices[indices[3 * t]], vertices[indices[3 * t + 1]], vertices[indices[3 * t + 2]],
                  static_cast<std::uint32_t>(t), pieces[p]);
    }
  });

  // Each band of rows gets its triangles in their order, and one thread.
  constexpr int band = 32;
  const int bands = (height + band - 1) / band;
  std::vector<std::vector<const ScreenTriangle*>> in_band(static_cast<std::size_t>(bands));
  for (const auto& some : pieces) {
    for (const ScreenTriangle& t : some) {
      const auto [low, high] = std::minmax({t.y[0], t.y[1], t.y[2]});
      const int first = std::max(first_sample(low), 0);
      const int last = std::min(last_sample(high), height - 1);
      if (first > last) continue;
      for (int b = first / band; b <= last / band; ++b) in_band[static_cast<std::size_t>(b)].push_back(&t);
    }
  }
  tbb::parallel_for(0, bands, [&](int b) {
    for (const ScreenTriangle* t : in_band[static_cast<std::size_t>(b)]) {
      draw(*t, b * band, std::min((b + 1) * band, height), buffer);
    }
  });
  return buffer;
}

}  // namespace tremula
