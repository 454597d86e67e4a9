#include "tremula/geometry/texels.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include <Eigen/Eigenvalues>

namespace tremula {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3d;
using Eigen::Vector3f;
using Sum6 = Eigen::Matrix<float, 6, 1>;

// What is in a texel, added up.
struct Heap {
  float area = 0;              // [m^2]
  Sum6 tensor = Sum6::Zero();  // area times t t^T: xx yy zz xy xz yz
  Vector3f color = Vector3f::Zero();
};

Sum6 tensor_of(const Vector3f& t) {
  Sum6 tensor;
  tensor << t.x() * t.x(), t.y() * t.y(), t.z() * t.z(), t.x() * t.y(), t.x() * t.z(), t.y() * t.z();
  return tensor;
}

// t and r of a mean of t t^T: its largest eigenvalue m is (2 - r)/(2 + r).
void set_frame(const Sum6& mean, TexelValue& value) {
  Eigen::Matrix3f matrix;
  matrix << mean[0], mean[3], mean[4], mean[3], mean[1], mean[5], mean[4], mean[5], mean[2];
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> solver;
  solver.computeDirect(matrix);
  const Vector3f axis = solver.eigenvectors().col(2);
  const float largest = std::clamp(solver.eigenvalues()[2], 1.0F / 3, 1.0F);
  value.axis = axis.allFinite() && axis.squaredNorm() > 0.5F ? axis.normalized() : Vector3f::UnitZ();
  value.spread = std::clamp(2 * (1 - largest) / (1 + largest), 0.0F, 1.0F);
}

Sum6 tensor_of(const TexelValue& value) {
  const float m = (2 - value.spread) / (2 + value.spread), rest = (1 - m) / 2;
  Sum6 tensor = (m - rest) * tensor_of(value.axis);
  tensor.head<3>().array() += rest;
  return tensor;
}

TexelValue value_of(const Heap& heap, float volume) {
  TexelValue value;
  value.density = heap.area / volume;
  value.color = heap.color / heap.area;
  set_frame(heap.tensor / heap.area, value);
  return value;
}

std::array<std::uint8_t, 2> octahedral(const Vector3f& axis) {
  // Either way is the same axis: the upper half of the octahedron fills the square.
  const Vector3f t = (axis.z() < 0 ? -1.0F : 1.0F) * axis / axis.cwiseAbs().sum();
  const auto byte = [](float x) { return static_cast<std::uint8_t>(std::lround(127.5F * (x + 1))); };
  return {byte(t.x() + t.y()), byte(t.x() - t.y())};
}

Vector3f from_octahedral(const std::array<std::uint8_t, 2>& bytes) {
  const float sum = static_cast<float>(bytes[0]) / 127.5F - 1,
              difference = static_cast<float>(bytes[1]) / 127.5F - 1;
  const float x = (sum + difference) / 2, y = (sum - difference) / 2;
  return Vector3f(x, y, std::max(0.0F, 1 - std::abs(x) - std::abs(y))).normalized();
}

// Heaps of a grid, of which most are empty.
class Grid {
 public:
  explicit Grid(const Texels& like) : like_(like), slot_(like.values.size(), none) {}

  Heap& at(int x, int y, int z) {
    std::uint32_t& slot = slot_[like_.index(x, y, z)];
    if (slot == none) {
      slot = static_cast<std::uint32_t>(heaps_.size());
      heaps_.emplace_back();
    }
    return heaps_[slot];
  }

  // Into the texels, with the step that the densest needs.
  void pack(Texels& texels) const {
    const float volume = texels.cell.prod();
    float most = 0;
    for (const Heap& heap : heaps_) most = std::max(most, heap.area / volume);
    texels.density_step = most > 0 ? most / 65535 : 1;
    for (std::size_t i = 0; i < slot_.size(); ++i) {
      if (slot_[i] == none || !(heaps_[slot_[i]].area > 0)) continue;
      texels.values[i] = texel_of(value_of(heaps_[slot_[i]], volume), texels.density_step);
    }
  }

 private:
  static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
  const Texels& like_;
  std::vector<std::uint32_t> slot_;
  std::vector<Heap> heaps_;
};

int wrapped(int i, int count) {
  const int rest = i % count;
  return rest < 0 ? rest + count : rest;
}

// One straight piece of a strand with what it is at its ends.
struct Piece {
  Vector3d from, to;  // [m]
  float from_width, to_width;
  Vector3f from_color, to_color;
};

// `put(cell, low, high)` for every cell that the piece runs through, from low to high of its way, 0 to 1.
template <class Put>
void walk(const Vector3d& from, const Vector3d& to, const Put& put) {  // in cells
  const Vector3d way = to - from;
  Eigen::Vector3i cell = from.array().floor().cast<int>(), step;
  Vector3d next, each;
  for (int i = 0; i < 3; ++i) {
    step[i] = way[i] < 0 ? -1 : 1;
    const double wall = cell[i] + (way[i] < 0 ? 0 : 1);
    const bool still = std::abs(way[i]) < 1e-12;
    next[i] = still ? std::numeric_limits<double>::infinity() : (wall - from[i]) / way[i];
    each[i] = still ? 0 : 1 / std::abs(way[i]);
  }
  double at = 0;
  while (at < 1) {
    int first = 0;
    next.minCoeff(&first);
    const double until = std::min(1.0, next[first]);
    if (until > at) put(cell, at, until);
    at = until;
    cell[first] += step[first];
    next[first] += each[first];
  }
}

void put_piece(const Piece& piece, const Texels& texels, Grid& grid, float share) {
  const Vector3d way = piece.to - piece.from;
  const auto length = static_cast<float>(way.norm());
  if (!(length > 0)) return;
  const Vector3f tangent = way.cast<float>() / length;
  const Sum6 tensor = tensor_of(tangent);
  const Vector3d cell = texels.cell.cast<double>();
  walk(piece.from.cwiseQuotient(cell), piece.to.cwiseQuotient(cell),
       [&](const Eigen::Vector3i& at, double low, double high) {
         const auto middle = static_cast<float>((low + high) / 2);
         const float width = piece.from_width + middle * (piece.to_width - piece.from_width);
         const float area = share * static_cast<float>(high - low) * length * width;
         Heap& heap = grid.at(wrapped(at[0], texels.count[0]), wrapped(at[1], texels.count[1]),
                              std::clamp(at[2], 0, texels.count[2] - 1));
         heap.area += area;
         heap.tensor += area * tensor;
         heap.color += area * (piece.from_color + middle * (piece.to_color - piece.from_color));
       });
}

void put_strand(const Strand& strand, const Texels& texels, Grid& grid) {
  const std::size_t pieces = strand.points.size() - 1;
  const auto color_at = [&](std::size_t i) -> Vector3f {
    const float s = static_cast<float>(i) / static_cast<float>(pieces);
    return strand.first_color + s * (strand.last_color - strand.first_color);
  };
  for (std::size_t i = 0; i < pieces; ++i) {
    Piece piece{strand.points[i].cast<double>(),
                strand.points[i + 1].cast<double>(),
                strand.widths[i],
                strand.widths[i + 1],
                color_at(i),
                color_at(i + 1)};
    const float width = std::max(piece.from_width, piece.to_width), room = texels.cell.minCoeff();
    const int lines = std::clamp(static_cast<int>(std::ceil(width / room)), 1, 64);
    Vector3d across = (piece.to - piece.from).cross(Vector3d::UnitZ());
    if (across.squaredNorm() < 1e-20) across = Vector3d::UnitX();
    across.normalize();
    for (int k = 0; k < lines; ++k) {
      const double off = (k + 0.5) / lines - 0.5;
      Piece line = piece;
      line.from += off * static_cast<double>(piece.from_width) * across;
      line.to += off * static_cast<double>(piece.to_width) * across;
      put_piece(line, texels, grid, 1 / static_cast<float>(lines));
    }
  }
}

std::array<double, 3> counts_of(const StrandPatch& patch, double resolution, double height) {
  check_positive("resolution of the texels", resolution, " m");
  const auto width = static_cast<double>(patch.size.x()), depth = static_cast<double>(patch.size.y());
  check_positive("width of the patch", width, " m");
  check_positive("depth of the patch", depth, " m");
  const double tall = height > 0 ? height : static_cast<double>(patch.height);
  return {std::max(1.0, std::round(width / resolution)), std::max(1.0, std::round(depth / resolution)),
          std::max(1.0, std::ceil(tall / resolution - 1e-6))};
}

void check_strands(const StrandPatch& patch) {
  for (std::size_t i = 0; i < patch.strands.size(); ++i) {
    const Strand& strand = patch.strands[i];
    const std::string place = "strand " + std::to_string(i + 1);
    if (strand.points.size() < 2 || strand.widths.size() != strand.points.size()) {
      throw InputError(place,
                       std::to_string(strand.points.size()) + " points and " +
                           std::to_string(strand.widths.size()) + " widths",
                       "two points or more, and as many widths");
    }
    for (const Vector3f& point : strand.points) {
      if (!point.allFinite() || point.cwiseAbs().maxCoeff() > 1e6F)
        throw InputError(place, "a point that is not finite or far away", "points within 1000 km");
    }
    for (const float width : strand.widths) {
      if (!(width >= 0) || !std::isfinite(width))
        throw InputError(place, "a width of " + number_text(static_cast<double>(width)) + " m",
                         "widths of 0 or more");
    }
  }
}

Texels half_of(const Texels& fine) {
  Texels coarse;
  coarse.repeats = fine.repeats;
  for (std::size_t i = 0; i < 3; ++i) {
    coarse.count[i] = (fine.count[i] + 1) / 2;
    // Along x and y the size of the patch stays: it repeats.
    const auto k = static_cast<Eigen::Index>(i);
    coarse.cell[k] = i < 2 ? fine.size()[k] / static_cast<float>(coarse.count[i]) : 2 * fine.cell[k];
  }
  coarse.values.resize(static_cast<std::size_t>(coarse.count[0]) * static_cast<std::size_t>(coarse.count[1]) *
                       static_cast<std::size_t>(coarse.count[2]));
  Grid grid(coarse);
  const float volume = fine.cell.prod();
  // A texel of an odd number of them lies in two coarse ones, by its share of each.
  struct Share {
    int place;
    float much;
  };
  const auto shares = [](int i, int of, int among) {
    const double low = static_cast<double>(i) * among / of, high = static_cast<double>(i + 1) * among / of;
    const int first = static_cast<int>(low + 1e-9), second = std::min(first + 1, among - 1);
    const double wall = first + 1;
    const double much = high <= wall + 1e-9 ? 1 : (wall - low) / (high - low);
    return std::array<Share, 2>{{{first, static_cast<float>(much)}, {second, static_cast<float>(1 - much)}}};
  };
  for (int z = 0; z < fine.count[2]; ++z) {
    for (int y = 0; y < fine.count[1]; ++y) {
      const auto rows = shares(y, fine.count[1], coarse.count[1]);
      for (int x = 0; x < fine.count[0]; ++x) {
        const Texel& texel = fine.values[fine.index(x, y, z)];
        if (texel.density == 0) continue;
        const TexelValue value = value_of(texel, fine.density_step);
        const Sum6 tensor = tensor_of(value);
        for (const Share& column : shares(x, fine.count[0], coarse.count[0])) {
          for (const Share& row : rows) {
            const float area = column.much * row.much * value.density * volume;
            if (!(area > 0)) continue;
            Heap& heap = grid.at(column.place, row.place, z / 2);
            heap.area += area;
            heap.tensor += area * tensor;
            heap.color += area * value.color;
          }
        }
      }
    }
  }
  grid.pack(coarse);
  return coarse;
}

}  // namespace

TexelValue value_of(const Texel& texel, float density_step) {
  TexelValue value;
  value.density = density_step * static_cast<float>(texel.density);
  value.axis = from_octahedral(texel.axis);
  value.spread = static_cast<float>(texel.spread) / 255;
  for (std::size_t i = 0; i < 3; ++i) {
    const float root = static_cast<float>(texel.color[i]) / 255;
    value.color[static_cast<Eigen::Index>(i)] = root * root;
  }
  return value;
}

Texel texel_of(const TexelValue& value, float density_step) {
  Texel texel;
  texel.density =
      static_cast<std::uint16_t>(std::lround(std::clamp(value.density / density_step, 0.0F, 65535.0F)));
  texel.axis = octahedral(value.axis);
  texel.spread = static_cast<std::uint8_t>(std::lround(255 * std::clamp(value.spread, 0.0F, 1.0F)));
  for (std::size_t i = 0; i < 3; ++i) {
    const float color = std::clamp(value.color[static_cast<Eigen::Index>(i)], 0.0F, 1.0F);
    texel.color[i] = static_cast<std::uint8_t>(std::lround(255 * std::sqrt(color)));
  }
  return texel;
}

float seen_share(const TexelValue& value, const Vector3f& direction) {
  const float along = value.axis.dot(direction), q = 2 / (2 + value.spread);
  return std::sqrt(std::max(0.0F, q * (1 - (1 - value.spread) * along * along)));
}

double texel_count(const StrandPatch& patch, double resolution, double height) {
  const auto counts = counts_of(patch, resolution, height);
  return counts[0] * counts[1] * counts[2];
}

Texels scan_convert(const StrandPatch& patch, double resolution, double height) {
  const auto counts = counts_of(patch, resolution, height);
  const double all = counts[0] * counts[1] * counts[2];
  if (!(all <= most_texels)) {
    throw InputError("resolution of the texels",
                     number_text(resolution) + " m, which makes " + number_text(all),
                     "at most " + number_text(most_texels) + " texels");
  }
  check_strands(patch);
  Texels texels;
  for (std::size_t i = 0; i < 3; ++i) texels.count[i] = static_cast<int>(counts[i]);
  texels.cell = {patch.size.x() / static_cast<float>(counts[0]),
                 patch.size.y() / static_cast<float>(counts[1]), static_cast<float>(resolution)};
  texels.values.resize(static_cast<std::size_t>(all));
  Grid grid(texels);
  for (const Strand& strand : patch.strands) put_strand(strand, texels, grid);
  grid.pack(texels);
  return texels;
}

std::vector<Texels> mip_levels(Texels finest, double coarsest) {
  std::vector<Texels> levels;
  levels.push_back(std::move(finest));
  while (static_cast<double>(levels.back().cell.maxCoeff()) < coarsest &&
         levels.back().count != std::array<int, 3>{1, 1, 1}) {
    levels.push_back(half_of(levels.back()));
  }
  return levels;
}

double area_of(const Texels& texels) {
  double steps = 0;
  for (const Texel& texel : texels.values) steps += texel.density;
  return steps * static_cast<double>(texels.density_step) * static_cast<double>(texels.cell.prod());
}

}  // namespace tremula
