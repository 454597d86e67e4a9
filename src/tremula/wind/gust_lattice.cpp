#include "tremula/wind/gust_lattice.hpp"

#include "tremula/numerics/vector_math.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace tremula {
namespace {

// Standard deviation of the covariance of a cubic B-spline with itself, in cells: sqrt(2/3), a little less to
// make up for its tails being shorter than a Gaussian's.
constexpr double spline_deviation = 0.80;
constexpr double finest_step = 0.2;  // of a lattice, in decay lengths
constexpr double negligible_weight = 1e-4;
constexpr int finest_octave = -3, coarsest_octave = 28;  // 2^-3 m is finest_lattice
static_assert(finest_lattice == 0.125);

// Cells of 16 x 8 nodes have their noise together.
constexpr std::int64_t block_columns = 16, block_rows = 8;
constexpr std::int64_t furthest_block = std::int64_t{1} << 25;

struct Octave {
  int number = 0;
  double spacing = 1;  // [m]
  double share = 1;    // of the variance
};

// a: decays per metre.
std::vector<Octave> octaves_of(double a) {
  const double wanted = a > 0 ? std::log2(finest_step / a) : coarsest_octave;
  int number =
      std::clamp(static_cast<int>(std::floor(std::min(wanted, 1e3))), finest_octave, coarsest_octave);
  std::vector<Octave> octaves;
  double below = 0;
  for (;; ++number) {
    const double spacing = std::ldexp(1.0, number);
    // The half-normal law up to the geometric mean of this octave's deviation and the next one's.
    const double to = a * spline_deviation * spacing * std::numbers::sqrt2;
    double share = std::erf(to / std::numbers::sqrt2) - below;
    below += share;
    const bool last = 1 - below < negligible_weight || number == coarsest_octave;
    if (last) share += 1 - below;
    octaves.push_back({number, spacing, share});
    if (last) return octaves;
  }
}

// Coordinates in which the decay is the same in both directions.
struct Metric {
  double decay = 0, across = 1, up = 1;
};
Metric metric_of(const CoherenceDecay& decay) {
  const double most = std::max(decay.y, decay.z);
  if (!(most > 0)) return {0, 0, 0};
  return {most, decay.y / most, decay.z / most};
}

template <class Real>
std::array<Real, 4> spline_weights(Real t) {
  const Real u = 1 - t, sixth = Real(1) / 6;
  return {sixth * u * u * u, sixth * (4 - 3 * t * t * (2 - t)), sixth * (4 - 3 * u * u * (2 - u)),
          sixth * t * t * t};
}

template <class Real>
Real sum_of_squares(const std::array<Real, 4>& w) {
  return w[0] * w[0] + w[1] * w[1] + w[2] * w[2] + w[3] * w[3];
}

std::int64_t floor_of(double x) { return static_cast<std::int64_t>(std::floor(std::clamp(x, -4e15, 4e15))); }
std::int64_t floor_divide(std::int64_t a, std::int64_t b) { return a >= 0 ? a / b : -((-a + b - 1) / b); }

std::uint64_t block_address(int octave, std::int64_t column, std::int64_t row) {
  const auto part = [](std::int64_t block) {
    const std::int64_t inside = std::clamp(block, -furthest_block, furthest_block - 1);
    return static_cast<std::uint64_t>(inside + furthest_block);
  };
  const auto number = static_cast<std::uint64_t>(octave - finest_octave);
  return (number << 52U) | (part(row) << 26U) | part(column);
}

// Where the lattice is asked for: the cell of a place, and how far into it.
struct Cell {
  std::int64_t column, row;
  float across, up;
};
Cell cell_of(double across, double up) {
  const std::int64_t column = floor_of(across), row = floor_of(up);
  return {column, row, static_cast<float>(across - static_cast<double>(column)),
          static_cast<float>(up - static_cast<double>(row))};
}

// A piece of the lattice, with its noise.
struct Patch {
  std::int64_t first_column = 0, first_row = 0, columns = 0, rows = 0;
};

Patch patch_of(std::span<const double> across, std::span<const double> up, double columns_per_metre,
               double rows_per_metre) {
  double low_column = std::numeric_limits<double>::infinity(), high_column = -low_column;
  double low_row = low_column, high_row = high_column;
  for (std::size_t i = 0; i < across.size(); ++i) {
    low_column = std::min(low_column, across[i] * columns_per_metre);
    high_column = std::max(high_column, across[i] * columns_per_metre);
    low_row = std::min(low_row, up[i] * rows_per_metre);
    high_row = std::max(high_row, up[i] * rows_per_metre);
  }
  Patch patch;
  patch.first_column = floor_divide(floor_of(low_column) - 1, block_columns) * block_columns;
  patch.first_row = floor_divide(floor_of(low_row) - 1, block_rows) * block_rows;
  patch.columns =
      (floor_divide(floor_of(high_column) + 2, block_columns) + 1) * block_columns - patch.first_column;
  patch.rows = (floor_divide(floor_of(high_row) + 2, block_rows) + 1) * block_rows - patch.first_row;
  return patch;
}

void fill_patch(const LatticeNoise& noise, int octave, const Patch& patch, LatticeWork& work) {
  work.nodes.resize(static_cast<std::size_t>(patch.columns * patch.rows));
  std::array<std::complex<float>, gaussian_block> block;
  for (std::int64_t row = 0; row < patch.rows; row += block_rows) {
    for (std::int64_t column = 0; column < patch.columns; column += block_columns) {
      complex_gaussian_block(noise.seed, noise.stream, noise.bin,
                             block_address(octave, (patch.first_column + column) / block_columns,
                                           (patch.first_row + row) / block_rows),
                             block.data());
      for (std::int64_t r = 0; r < block_rows; ++r) {
        std::copy_n(block.data() + r * block_columns, block_columns,
                    work.nodes.data() + (row + r) * patch.columns + column);
      }
    }
  }
}

std::complex<float> weighted(const std::complex<float>* row, const std::array<float, 4>& weights) {
  float real = 0, imaginary = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    real += weights[i] * row[i].real();
    imaginary += weights[i] * row[i].imag();
  }
  return {real, imaginary};
}

// Places are worked off in pieces that stay in the first-level cache.
constexpr int piece = 64;
struct Pieces {
  alignas(64) std::int32_t node[piece];  // the first of its sixteen
  alignas(64) float across[4][piece];
  alignas(64) float up[4][piece];  // with the octave's weight and the variance of the place in them
};

TREMULA_CLONES void find_weights(int count, const double* across, const double* up, double columns_per_metre,
                                 double rows_per_metre, double first_column, double first_row,
                                 std::int32_t columns, float share, Pieces& out) {
  for (int i = 0; i < count; ++i) {
    const double x = across[i] * columns_per_metre - first_column, y = up[i] * rows_per_metre - first_row;
    const auto column = static_cast<std::int32_t>(x), row = static_cast<std::int32_t>(y);
    out.node[i] = (row - 1) * columns + column - 1;
    const auto t = static_cast<float>(x - column), s = static_cast<float>(y - row);
    const float u = 1 - t, v = 1 - s;
    constexpr float sixth = 1.0F / 6;
    const float x0 = sixth * u * u * u, x1 = sixth * (4 - 3 * t * t * (2 - t)),
                x2 = sixth * (4 - 3 * u * u * (2 - u)), x3 = sixth * t * t * t;
    const float y0 = sixth * v * v * v, y1 = sixth * (4 - 3 * s * s * (2 - s)),
                y2 = sixth * (4 - 3 * v * v * (2 - v)), y3 = sixth * s * s * s;
    const float variance = (x0 * x0 + x1 * x1 + x2 * x2 + x3 * x3) * (y0 * y0 + y1 * y1 + y2 * y2 + y3 * y3);
    const float size = std::sqrt(share / variance);
    out.across[0][i] = x0, out.across[1][i] = x1, out.across[2][i] = x2, out.across[3][i] = x3;
    out.up[0][i] = size * y0, out.up[1][i] = size * y1, out.up[2][i] = size * y2, out.up[3][i] = size * y3;
  }
}

TREMULA_CLONES void add_nodes(int count, const Pieces& pieces, const float* nodes, std::int32_t columns,
                              float* values) {
  for (int i = 0; i < count; ++i) {
    const float* row = nodes + 2 * static_cast<std::ptrdiff_t>(pieces.node[i]);
    const std::ptrdiff_t next = 2 * static_cast<std::ptrdiff_t>(columns);
    const float y0 = pieces.up[0][i], y1 = pieces.up[1][i], y2 = pieces.up[2][i], y3 = pieces.up[3][i];
    float sum[8];
    for (int k = 0; k < 8; ++k)
      sum[k] = (y0 * row[k] + y1 * row[next + k]) + (y2 * row[2 * next + k] + y3 * row[3 * next + k]);
    const float x0 = pieces.across[0][i], x1 = pieces.across[1][i], x2 = pieces.across[2][i],
                x3 = pieces.across[3][i];
    values[2 * i] += (x0 * sum[0] + x1 * sum[2]) + (x2 * sum[4] + x3 * sum[6]);
    values[2 * i + 1] += (x0 * sum[1] + x1 * sum[3]) + (x2 * sum[5] + x3 * sum[7]);
  }
}

void add_from_patch(const Patch& patch, const Octave& octave, std::span<const double> across,
                    std::span<const double> up, double columns_per_metre, double rows_per_metre,
                    const LatticeWork& work, std::complex<float>* values) {
  Pieces pieces;
  const auto columns = static_cast<std::int32_t>(patch.columns);
  for (std::size_t start = 0; start < across.size(); start += piece) {
    const int count = static_cast<int>(std::min<std::size_t>(piece, across.size() - start));
    find_weights(count, across.data() + start, up.data() + start, columns_per_metre, rows_per_metre,
                 static_cast<double>(patch.first_column), static_cast<double>(patch.first_row), columns,
                 static_cast<float>(octave.share), pieces);
    add_nodes(count, pieces, reinterpret_cast<const float*>(work.nodes.data()), columns,
              reinterpret_cast<float*>(values + start));
  }
}

// For few places far from each other.
void add_block_by_block(const LatticeNoise& noise, const Octave& octave, std::span<const double> across,
                        std::span<const double> up, double columns_per_metre, double rows_per_metre,
                        LatticeWork& work, std::complex<float>* values) {
  work.blocks.clear();
  const auto node_at = [&](std::int64_t column, std::int64_t row) {
    const std::int64_t block_column = floor_divide(column, block_columns),
                       block_row = floor_divide(row, block_rows);
    const std::uint64_t address = block_address(octave.number, block_column, block_row);
    auto found = work.blocks.find(address);
    if (found == work.blocks.end()) {
      found = work.blocks.try_emplace(address).first;
      complex_gaussian_block(noise.seed, noise.stream, noise.bin, address, found->second.data());
    }
    return found->second[static_cast<std::size_t>((row - block_row * block_rows) * block_columns + column -
                                                  block_column * block_columns)];
  };
  for (std::size_t i = 0; i < across.size(); ++i) {
    const Cell cell = cell_of(across[i] * columns_per_metre, up[i] * rows_per_metre);
    const auto wx = spline_weights(cell.across), wy = spline_weights(cell.up);
    std::complex<float> sum = 0;
    for (std::int64_t r = 0; r < 4; ++r) {
      std::array<std::complex<float>, 4> row;
      for (std::int64_t c = 0; c < 4; ++c)
        row[static_cast<std::size_t>(c)] = node_at(cell.column - 1 + c, cell.row - 1 + r);
      sum += wy[static_cast<std::size_t>(r)] * weighted(row.data(), wx);
    }
    values[i] +=
        std::sqrt(static_cast<float>(octave.share) / (sum_of_squares(wx) * sum_of_squares(wy))) * sum;
  }
}

// Covariance of the normalised spline noise at two coordinates, in cells.
double spline_covariance(double a, double b) {
  const double low = std::floor(a), other = std::floor(b);
  const auto wa = spline_weights(a - low), wb = spline_weights(b - other);
  double sum = 0;
  for (int i = 0; i < 4; ++i) {
    const double j = low + i - other;
    if (j >= 0 && j <= 3) sum += wa[static_cast<std::size_t>(i)] * wb[static_cast<std::size_t>(j)];
  }
  return sum / std::sqrt(sum_of_squares(wa) * sum_of_squares(wb));
}

}  // namespace

void draw_on_lattice(const LatticeNoise& noise, const CoherenceDecay& decay, std::span<const double> across,
                     std::span<const double> up, LatticeWork& work, std::complex<float>* values) {
  std::fill_n(values, across.size(), std::complex<float>(0));
  if (across.empty()) return;
  const Metric metric = metric_of(decay);
  constexpr double few_nodes = 1 << 14, nodes_a_place = 64;
  const double most_nodes = std::max(few_nodes, nodes_a_place * static_cast<double>(across.size()));
  for (const Octave& octave : octaves_of(metric.decay)) {
    const double columns_per_metre = metric.across / octave.spacing,
                 rows_per_metre = metric.up / octave.spacing;
    const Patch patch = patch_of(across, up, columns_per_metre, rows_per_metre);
    if (static_cast<double>(patch.columns) * static_cast<double>(patch.rows) <= most_nodes) {
      fill_patch(noise, octave.number, patch, work);
      add_from_patch(patch, octave, across, up, columns_per_metre, rows_per_metre, work, values);
    } else {
      add_block_by_block(noise, octave, across, up, columns_per_metre, rows_per_metre, work, values);
    }
  }
}

void draw_at_places(const LatticeNoise& noise, std::span<const double> across, std::span<const double> up,
                    std::complex<float>* values) {
  const auto millimetres = [](double x) {
    return static_cast<std::uint64_t>(
        static_cast<std::uint32_t>(std::llround(std::clamp(1e3 * x, -1e15, 1e15))));
  };
  for (std::size_t i = 0; i < across.size(); ++i) {
    values[i] = static_cast<std::complex<float>>(complex_gaussian(
        {noise.seed, noise.stream, noise.bin, (millimetres(across[i]) << 32U) | millimetres(up[i])}));
  }
}

double lattice_coherence(const CoherenceDecay& decay, const std::array<double, 2>& place,
                         const std::array<double, 2>& other) {
  const Metric metric = metric_of(decay);
  double sum = 0;
  for (const Octave& octave : octaves_of(metric.decay)) {
    const double columns = metric.across / octave.spacing, rows = metric.up / octave.spacing;
    sum += octave.share * spline_covariance(place[0] * columns, other[0] * columns) *
           spline_covariance(place[1] * rows, other[1] * rows);
  }
  return sum;
}

}  // namespace tremula
