#include "tremula/render/sky.hpp"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace tremula {
namespace {

using Eigen::Vector3f;
using Eigen::Vector3i;

constexpr float pi = std::numbers::pi_v<float>;

// Directions evenly over the sphere (a spiral of the golden angle).
template <int count>
std::array<Vector3f, count> sphere_directions() {
  std::array<Vector3f, count> directions;
  for (int i = 0; i < count; ++i) {
    const float z = 1 - (2 * static_cast<float>(i) + 1) / count;
    const float turn = 2.39996323F * static_cast<float>(i);
    const float level = std::sqrt(1 - z * z);
    directions[static_cast<std::size_t>(i)] = Vector3f(level * std::cos(turn), level * std::sin(turn), z);
  }
  return directions;
}

void deposit(FogGrid& grid, const Vector3f& a, const Vector3f& b, const Vector3f& c, float projection) {
  const float area = 0.5F * (b - a).cross(c - a).norm();
  // Long triangles of trunks are spread over the cells they cross.
  const float longest =
      std::sqrt(std::max({(b - a).squaredNorm(), (c - a).squaredNorm(), (c - b).squaredNorm()}));
  const int pieces = std::clamp(static_cast<int>(longest / grid.cell) + 1, 1, 12);
  const float share =
      projection * area / static_cast<float>(pieces * pieces) / (grid.cell * grid.cell * grid.cell);
  for (int i = 0; i < pieces; ++i) {
    for (int j = 0; j < 2 * (pieces - i) - 1; ++j) {
      // Centres of the small triangles that halve and halve again: upright for even j, upside down for odd j.
      const float third = j % 2 == 0 ? 1.0F / 3 : 2.0F / 3;
      const float s = (static_cast<float>(i) + third) / static_cast<float>(pieces);
      const float t = (static_cast<float>(j / 2) + third) / static_cast<float>(pieces);
      const Vector3f point = a + s * (b - a) + t * (c - a);
      const Vector3i at = ((point - grid.low) / grid.cell).array().floor().cast<int>();
      grid.extinction[grid.index(at.cwiseMax(0).cwiseMin(grid.size - Vector3i::Ones()))] += share;
    }
  }
}

// Cell centres around a point and how far between them it lies, for interpolation.
struct Corner {
  Vector3i cell;
  Vector3f share;
};

Corner corner_of(const FogGrid& grid, const Vector3f& point) {
  const Vector3f last = (grid.size - Vector3i::Constant(2)).cast<float>();
  const Vector3f position = ((point - grid.low) / grid.cell - Vector3f::Constant(0.5F))
                                .cwiseMax(0.0F)
                                .cwiseMin(last + Vector3f::Constant(0.9999F));
  const Vector3f floor = position.array().floor();
  return {floor.cast<int>(), position - floor};
}

}  // namespace

float FogGrid::transmittance(const Vector3f& point, const Vector3f& direction) const {
  // The part of the ray inside the grid.
  const Vector3f high = low + cell * size.cast<float>();
  float enter = 0;
  float leave = std::numeric_limits<float>::max();
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(direction[axis]) < 1e-6F) {
      if (point[axis] < low[axis] || point[axis] > high[axis]) return 1;
      continue;
    }
    const float one = (low[axis] - point[axis]) / direction[axis];
    const float two = (high[axis] - point[axis]) / direction[axis];
    enter = std::max(enter, std::min(one, two));
    leave = std::min(leave, std::max(one, two));
  }
  float depth = 0;  // in cells
  const auto high_cells = static_cast<float>(size.sum());
  Vector3f at = (point + (enter + 0.5F * cell) * direction - low) / cell;
  const int steps = static_cast<int>(std::min((leave - enter) / cell, 2 * high_cells) + 0.5F);
  for (int i = 0; i < steps && depth < 5 / cell; ++i, at += direction) {
    const Vector3i c = at.cast<int>();
    if ((c.array() < 0).any() || (c.array() >= size.array()).any()) break;
    depth += extinction[index(c)];
  }
  return std::exp(-depth * cell);
}

FogGrid make_fog(const Vector3f& low, const Vector3f& high, int cells) {
  FogGrid grid;
  grid.cell = std::max((high - low).maxCoeff(), 1e-4F) / static_cast<float>(cells);
  // One empty cell all around: the light there is that of the open.
  grid.size = ((high - low) / grid.cell).array().ceil().cast<int>().max(1) + 2;
  grid.low = (low + high) / 2 - 0.5F * grid.cell * grid.size.cast<float>();
  grid.extinction.assign(static_cast<std::size_t>(grid.size.prod()), 0.0F);
  return grid;
}

void add_fog(FogGrid& grid, std::span<const Vector3f> positions, const SurfacePart& part) {
  const float projection = part.material.two_sided ? 0.5F : 0.25F;  // closed: only half of the skin is seen
  for (std::size_t t = 0; t + 2 < part.triangles.size(); t += 3) {
    deposit(grid, positions[part.triangles[t]], positions[part.triangles[t + 1]],
            positions[part.triangles[t + 2]], projection);
  }
}

Rgb Surroundings::radiance(const Vector3f& direction) const {
  if (direction.z() < 0) return ground;
  return horizon + (zenith - horizon) * std::sqrt(direction.z());
}

AmbientLight::AmbientLight(const FogGrid& fog, const Surroundings& surroundings) : fog_(fog) {
  cells_.resize(fog_.extinction.size());
  constexpr int count = 24;
  const auto directions = sphere_directions<count>();
  const float solid_angle = 4 * pi / count;
  tbb::parallel_for(0, fog_.size.z(), [&](int z) {
    for (int y = 0; y < fog_.size.y(); ++y) {
      for (int x = 0; x < fog_.size.x(); ++x) {
        Harmonics& cell = cells_[fog_.index({x, y, z})];
        const Vector3f centre =
            fog_.low + fog_.cell * Vector3f(static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F,
                                            static_cast<float>(z) + 0.5F);
        for (const Vector3f& direction : directions) {
          const float open = fog_.transmittance(centre, direction);
          const Rgb light = open * surroundings.radiance(direction) + (1 - open) * surroundings.foliage;
          cell.mean += (0.25F * solid_angle) * light;
          for (int axis = 0; axis < 3; ++axis) {
            cell.slope[static_cast<std::size_t>(axis)] += (0.5F * solid_angle * direction[axis]) * light;
          }
        }
      }
    }
  });
}

Rgb AmbientLight::irradiance(const Vector3f& point, const Vector3f& normal) const {
  const Corner corner = corner_of(fog_, point);
  Rgb sum = Rgb::Zero();
  for (int i = 0; i < 8; ++i) {
    const Vector3i step(i & 1, i >> 1 & 1, i >> 2);
    float weight = 1;
    for (int axis = 0; axis < 3; ++axis)
      weight *= step[axis] != 0 ? corner.share[axis] : 1 - corner.share[axis];
    const Harmonics& cell = cells_[fog_.index(corner.cell + step)];
    sum += weight *
           (cell.mean + normal.x() * cell.slope[0] + normal.y() * cell.slope[1] + normal.z() * cell.slope[2]);
  }
  return sum.cwiseMax(0.0F);
}

GroundLight::GroundLight(const FogGrid& fog, const Eigen::Vector2f& centre, float ground_level,
                         float half_width)
    : centre_(centre), half_width_(half_width) {
  share_.resize(cells * cells);
  const auto directions = sphere_directions<64>();  // the first half of them look up
  tbb::parallel_for(0, cells, [&](int y) {
    for (int x = 0; x < cells; ++x) {
      // Cells are finest in the middle, where the stem stands: t |t|.
      const auto coordinate = [&](int i) {
        const float t = 2 * static_cast<float>(i) / (cells - 1) - 1;
        return half_width * t * std::abs(t);
      };
      const Vector3f point(centre.x() + coordinate(x), centre.y() + coordinate(y), ground_level);
      float open = 0, all = 0;
      for (std::size_t d = 0; d < 32; ++d) {
        open += directions[d].z() * fog.transmittance(point, directions[d]);
        all += directions[d].z();
      }
      share_[static_cast<std::size_t>(y * cells + x)] = open / all;
    }
  });
}

float GroundLight::sky_share(float x, float y) const {
  const auto place = [&](float at, float centre) {
    const float offset = std::clamp((at - centre) / half_width_, -1.0F, 1.0F);
    const float t = std::copysign(std::sqrt(std::abs(offset)), offset);
    return std::min((t + 1) / 2 * (cells - 1), cells - 1.001F);
  };
  const float px = place(x, centre_.x());
  const float py = place(y, centre_.y());
  const auto ix = static_cast<std::size_t>(px);
  const auto iy = static_cast<std::size_t>(py);
  const float fx = px - static_cast<float>(ix);
  const float fy = py - static_cast<float>(iy);
  const float* low = &share_[iy * cells + ix];
  const float* high = low + cells;
  return (1 - fy) * ((1 - fx) * low[0] + fx * low[1]) + fy * ((1 - fx) * high[0] + fx * high[1]);
}

}  // namespace tremula
