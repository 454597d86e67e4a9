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

// Blocks of 16 x 8 nodes have their noise together.
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

// The sum of their squares: the variance of noise of unit variance through the spline, in one direction.
template <class Real>
Real spline_variance(Real t) {
  const Real q = t * (1 - t);
  return Real(0.5) - q * q * (Real(0.5) + Real(5.0 / 9) * q);
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

// Places on the finest lattice that counts, in its cells.
struct Places {
  std::span<const double> across, up;
  double columns_per_metre, rows_per_metre;
};

// A piece of a lattice.
struct Patch {
  std::int64_t first_column = 0, first_row = 0, last_column = 0, last_row = 0;

  std::int64_t columns() const { return last_column - first_column + 1; }
  std::int64_t rows() const { return last_row - first_row + 1; }
  double size() const { return static_cast<double>(columns()) * static_cast<double>(rows()); }
};

// All nodes that the splines at these places take.
Patch patch_of(const Places& places) {
  double low_column = std::numeric_limits<double>::infinity(), high_column = -low_column;
  double low_row = low_column, high_row = high_column;
  for (std::size_t i = 0; i < places.across.size(); ++i) {
    low_column = std::min(low_column, places.across[i]);
    high_column = std::max(high_column, places.across[i]);
    low_row = std::min(low_row, places.up[i]);
    high_row = std::max(high_row, places.up[i]);
  }
  return {floor_of(low_column * places.columns_per_metre) - 1, floor_of(low_row * places.rows_per_metre) - 1,
          floor_of(high_column * places.columns_per_metre) + 2,
          floor_of(high_row * places.rows_per_metre) + 2};
}

// The nodes of twice the spacing that these follow from.
Patch coarser(const Patch& patch) {
  return {floor_divide(patch.first_column, 2) - 1, floor_divide(patch.first_row, 2) - 1,
          floor_divide(patch.last_column, 2) + 1, floor_divide(patch.last_row, 2) + 1};
}

void add_noise(const LatticeNoise& noise, const Octave& octave, const Patch& patch,
               std::complex<float>* nodes) {
  const auto size = static_cast<float>(std::sqrt(octave.share));
  std::array<std::complex<float>, gaussian_block> block;
  const std::int64_t last_row = floor_divide(patch.last_row, block_rows),
                     last_column = floor_divide(patch.last_column, block_columns);
  for (std::int64_t row = floor_divide(patch.first_row, block_rows); row <= last_row; ++row) {
    for (std::int64_t column = floor_divide(patch.first_column, block_columns); column <= last_column;
         ++column) {
      complex_gaussian_block(noise.seed, noise.stream, noise.bin, block_address(octave.number, column, row),
                             block.data());
      const std::int64_t left = column * block_columns, low = row * block_rows;
      const std::int64_t from = std::max(left, patch.first_column),
                         to = std::min(left + block_columns - 1, patch.last_column);
      for (std::int64_t r = std::max(low, patch.first_row);
           r <= std::min(low + block_rows - 1, patch.last_row); ++r) {
        std::complex<float>* out = nodes + (r - patch.first_row) * patch.columns() - patch.first_column;
        const std::complex<float>* in = block.data() + (r - low) * block_columns - left;
        for (std::int64_t i = from; i <= to; ++i) out[i] += size * in[i];
      }
    }
  }
}

// A cubic B-spline is a sum of those of half its width, (1 4 6 4 1)/8 of them: the same field on a finer
// lattice.
void refine(const Patch& coarse, const std::complex<float>* from, const Patch& fine,
            std::vector<std::complex<float>>& rows, std::complex<float>* to) {
  const auto halve = [](const std::complex<float>* at, std::int64_t node, std::int64_t stride) {
    // at: of the coarse node floor(node / 2).
    return node % 2 == 0 ? 0.125F * (at[-stride] + at[stride]) + 0.75F * at[0] : 0.5F * (at[0] + at[stride]);
  };
  // Across first, on the coarse rows.
  rows.resize(static_cast<std::size_t>(coarse.rows() * fine.columns()));
  for (std::int64_t r = 0; r < coarse.rows(); ++r) {
    const std::complex<float>* row = from + r * coarse.columns() - coarse.first_column;
    for (std::int64_t i = fine.first_column; i <= fine.last_column; ++i)
      rows[static_cast<std::size_t>(r * fine.columns() + i - fine.first_column)] =
          halve(row + floor_divide(i, 2), i, 1);
  }
  for (std::int64_t k = fine.first_row; k <= fine.last_row; ++k) {
    const std::complex<float>* row = rows.data() + (floor_divide(k, 2) - coarse.first_row) * fine.columns();
    for (std::int64_t i = 0; i < fine.columns(); ++i)
      to[(k - fine.first_row) * fine.columns() + i] = halve(row + i, k, fine.columns());
  }
}

// All octaves on the finest lattice of them.
void fill_patch(const LatticeNoise& noise, const std::vector<Octave>& octaves, const Patch& finest,
                LatticeWork& work) {
  std::vector<Patch> patches{finest};
  while (patches.size() < octaves.size()) patches.push_back(coarser(patches.back()));
  for (std::size_t j = octaves.size(); j-- > 0;) {
    const Patch& patch = patches[j];
    if (j + 1 == octaves.size()) {
      work.nodes.assign(static_cast<std::size_t>(patch.size()), 0);
    } else {
      std::swap(work.nodes, work.coarse);
      work.nodes.resize(static_cast<std::size_t>(patch.size()));
      refine(patches[j + 1], work.coarse.data(), patch, work.rows, work.nodes.data());
    }
    add_noise(noise, octaves[j], patch, work.nodes.data());
  }
}

// Places are worked off in pieces that stay in the first-level cache.
constexpr int piece = 64;
struct Pieces {
  alignas(64) std::int32_t node[piece];  // the first of its sixteen
  alignas(64) float across[4][piece];
  alignas(64) float up[4][piece];
};

TREMULA_CLONES void find_weights(int count, const double* across, const double* up, double columns_per_metre,
                                 double rows_per_metre, double first_column, double first_row,
                                 std::int32_t columns, Pieces& out) {
  for (int i = 0; i < count; ++i) {
    const double x = across[i] * columns_per_metre - first_column, y = up[i] * rows_per_metre - first_row;
    const auto column = static_cast<std::int32_t>(x), row = static_cast<std::int32_t>(y);
    out.node[i] = (row - 1) * columns + column - 1;
    const auto t = static_cast<float>(x - column), s = static_cast<float>(y - row);
    const float u = 1 - t, v = 1 - s;
    constexpr float sixth = 1.0F / 6;
    out.across[0][i] = sixth * u * u * u, out.across[1][i] = sixth * (4 - 3 * t * t * (2 - t));
    out.across[2][i] = sixth * (4 - 3 * u * u * (2 - u)), out.across[3][i] = sixth * t * t * t;
    out.up[0][i] = sixth * v * v * v, out.up[1][i] = sixth * (4 - 3 * s * s * (2 - s));
    out.up[2][i] = sixth * (4 - 3 * v * v * (2 - v)), out.up[3][i] = sixth * s * s * s;
  }
}

TREMULA_CLONES void sum_nodes(int count, const Pieces& pieces, const float* nodes, std::int32_t columns,
                              float* values) {
  const std::ptrdiff_t next = 2 * static_cast<std::ptrdiff_t>(columns);
  for (int i = 0; i < count; ++i) {
    const float* row = nodes + 2 * static_cast<std::ptrdiff_t>(pieces.node[i]);
    const float y0 = pieces.up[0][i], y1 = pieces.up[1][i], y2 = pieces.up[2][i], y3 = pieces.up[3][i];
    float sum[8];
    for (int k = 0; k < 8; ++k)
      sum[k] = (y0 * row[k] + y1 * row[next + k]) + (y2 * row[2 * next + k] + y3 * row[3 * next + k]);
    const float x0 = pieces.across[0][i], x1 = pieces.across[1][i], x2 = pieces.across[2][i],
                x3 = pieces.across[3][i];
    values[2 * i] = (x0 * sum[0] + x1 * sum[2]) + (x2 * sum[4] + x3 * sum[6]);
    values[2 * i + 1] = (x0 * sum[1] + x1 * sum[3]) + (x2 * sum[5] + x3 * sum[7]);
  }
}

// What an octave adds to the variance of the sum (spline_variance of both directions).
TREMULA_CLONES void add_variances(int count, const double* across, const double* up, double columns_per_metre,
                                  double rows_per_metre, float share, float* variance) {
  for (int i = 0; i < count; ++i) {
    const double x = across[i] * columns_per_metre, y = up[i] * rows_per_metre;
    const auto t = static_cast<float>(x - std::floor(x)), s = static_cast<float>(y - std::floor(y));
    const float p = t * (1 - t), q = s * (1 - s);
    constexpr float ninths = 5.0F / 9;
    variance[i] += share * (0.5F - p * p * (0.5F + ninths * p)) * (0.5F - q * q * (0.5F + ninths * q));
  }
}

// Divides by the deviation.
void make_unit(const std::vector<Octave>& octaves, const Metric& metric, std::span<const double> across,
               std::span<const double> up, std::complex<float>* values) {
  float variance[piece];
  for (std::size_t start = 0; start < across.size(); start += piece) {
    const int count = static_cast<int>(std::min<std::size_t>(piece, across.size() - start));
    std::fill_n(variance, piece, 0.0F);
    for (const Octave& octave : octaves)
      add_variances(count, across.data() + start, up.data() + start, metric.across / octave.spacing,
                    metric.up / octave.spacing, static_cast<float>(octave.share), variance);
    for (int i = 0; i < count; ++i) values[start + static_cast<std::size_t>(i)] /= std::sqrt(variance[i]);
  }
}

void sum_patch(const Patch& patch, const Places& places, const LatticeWork& work,
               std::complex<float>* values) {
  Pieces pieces;
  const auto columns = static_cast<std::int32_t>(patch.columns());
  for (std::size_t start = 0; start < places.across.size(); start += piece) {
    const int count = static_cast<int>(std::min<std::size_t>(piece, places.across.size() - start));
    find_weights(count, places.across.data() + start, places.up.data() + start, places.columns_per_metre,
                 places.rows_per_metre, static_cast<double>(patch.first_column),
                 static_cast<double>(patch.first_row), columns, pieces);
    sum_nodes(count, pieces, reinterpret_cast<const float*>(work.nodes.data()), columns,
              reinterpret_cast<float*>(values + start));
  }
}

// For few places far from each other: octave by octave, from the blocks of noise that they need.
void add_block_by_block(const LatticeNoise& noise, const Octave& octave, const Places& places,
                        LatticeWork& work, std::complex<float>* values) {
  work.blocks.clear();
  const auto size = static_cast<float>(std::sqrt(octave.share));
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
  for (std::size_t i = 0; i < places.across.size(); ++i) {
    const double x = places.across[i] * places.columns_per_metre, y = places.up[i] * places.rows_per_metre;
    const std::int64_t column = floor_of(x), row = floor_of(y);
    const auto wx = spline_weights(static_cast<float>(x - std::floor(x))),
               wy = spline_weights(static_cast<float>(y - std::floor(y)));
    std::complex<float> sum = 0;
    for (std::int64_t r = 0; r < 4; ++r) {
      std::complex<float> of_row = 0;
      for (std::int64_t c = 0; c < 4; ++c)
        of_row += wx[static_cast<std::size_t>(c)] * node_at(column - 1 + c, row - 1 + r);
      sum += wy[static_cast<std::size_t>(r)] * of_row;
    }
    values[i] += size * sum;
  }
}

// Covariance of spline noise of unit variance at two coordinates, in cells.
double spline_covariance(double a, double b) {
  const double low = std::floor(a), other = std::floor(b);
  const auto wa = spline_weights(a - low), wb = spline_weights(b - other);
  double sum = 0;
  for (int i = 0; i < 4; ++i) {
    const double j = low + i - other;
    if (j >= 0 && j <= 3) sum += wa[static_cast<std::size_t>(i)] * wb[static_cast<std::size_t>(j)];
  }
  return sum;
}

}  // namespace

void draw_on_lattice(const LatticeNoise& noise, const CoherenceDecay& decay, std::span<const double> across,
                     std::span<const double> up, LatticeWork& work, std::complex<float>* values) {
  if (across.empty()) return;
  const Metric metric = metric_of(decay);
  const std::vector<Octave> octaves = octaves_of(metric.decay);
  constexpr double few_nodes = 1 << 14, nodes_a_place = 64;
  const double most_nodes = std::max(few_nodes, nodes_a_place * static_cast<double>(across.size()));
  const auto places_on = [&](const Octave& octave) {
    return Places{across, up, metric.across / octave.spacing, metric.up / octave.spacing};
  };
  const Places finest = places_on(octaves.front());
  const Patch patch = patch_of(finest);
  if (patch.size() <= most_nodes) {
    fill_patch(noise, octaves, patch, work);
    sum_patch(patch, finest, work, values);
  } else {
    std::fill_n(values, across.size(), std::complex<float>(0));
    for (const Octave& octave : octaves) add_block_by_block(noise, octave, places_on(octave), work, values);
  }
  make_unit(octaves, metric, across, up, values);
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
  double sum = 0, here = 0, there = 0;
  for (const Octave& octave : octaves_of(metric.decay)) {
    const double columns = metric.across / octave.spacing, rows = metric.up / octave.spacing;
    const auto covariance = [&](const std::array<double, 2>& a, const std::array<double, 2>& b) {
      return octave.share * spline_covariance(a[0] * columns, b[0] * columns) *
             spline_covariance(a[1] * rows, b[1] * rows);
    };
    sum += covariance(place, other);
    here += covariance(place, place);
    there += covariance(other, other);
  }
  return sum / std::sqrt(here * there);
}

}  // namespace tremula
