#include "tremula/numerics/columns.hpp"

#include "tremula/base/simd.hpp"

#include <algorithm>
#include <cmath>
#include <new>

#include <tbb/parallel_for.h>

// Vectors never cross a function that is not inlined.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace tremula {
namespace {

constexpr std::align_val_t alignment{64};

// Rows are worked on in tiles of one size, and the tiles' sums are added in order: the result is the same on
// any number of threads, and a tile of a vector stays in the first-level cache while the basis streams by.
constexpr Eigen::Index tile_rows = 1024;
constexpr Eigen::Index parallel_rows = 60000;  // fewer: one thread is faster
constexpr int width = 8;
using Wide = Lanes<width>;

Eigen::Index tile_count(Eigen::Index rows) { return (rows + tile_rows - 1) / tile_rows; }

template <class Work>
void for_each_tile(Eigen::Index rows, const Work& work) {
  const auto tile = [&](Eigen::Index t) {
    const Eigen::Index first = t * tile_rows;
    work(t, first, std::min(tile_rows, rows - first));
  };
  if (rows < parallel_rows) {
    for (Eigen::Index t = 0; t < tile_count(rows); ++t) tile(t);
  } else {
    tbb::parallel_for(Eigen::Index{0}, tile_count(rows), tile);
  }
}

double sum_of_tiles(const std::vector<double>& parts) {
  double sum = 0;
  for (const double part : parts) sum += part;
  return sum;
}

TREMULA_INLINE double sum_of_lanes(const Wide& value) {
  alignas(64) double parts[width];
  store(value, parts);
  return ((parts[0] + parts[1]) + (parts[2] + parts[3])) + ((parts[4] + parts[5]) + (parts[6] + parts[7]));
}

TREMULA_CLONES double step_tile(double* next, const double* current, const double* previous,
                                Eigen::Index rows, double a, double b, double c) {
  Wide sum{};
  Eigen::Index i = 0;
  for (; i + width <= rows; i += width) {
    Wide x, y, z;
    load(next + i, x), load(current + i, y), load(previous + i, z);
    x = a * x - b * y - c * z;
    store(x, next + i);
    sum += x * x;
  }
  double result = sum_of_lanes(sum);
  for (; i < rows; ++i) {
    next[i] = a * next[i] - b * current[i] - c * previous[i];
    result += next[i] * next[i];
  }
  return result;
}

TREMULA_CLONES double dot_tile(const double* a, const double* b, Eigen::Index rows) {
  Wide sum0{}, sum1{};
  Eigen::Index i = 0;
  for (; i + 2 * width <= rows; i += 2 * width) {
    Wide x, y;
    load(a + i, x), load(b + i, y);
    sum0 += x * y;
    load(a + i + width, x), load(b + i + width, y);
    sum1 += x * y;
  }
  double result = sum_of_lanes(sum0 + sum1);
  for (; i < rows; ++i) result += a[i] * b[i];
  return result;
}

// products[0 … 3], [4 … 7]: of four columns with the two vectors.
template <bool both>
TREMULA_INLINE void four_dots(const double* const* columns, const double* first, const double* second,
                              Eigen::Index rows, double* products) {
  Wide sums[8]{};
  Eigen::Index i = 0;
  for (; i + width <= rows; i += width) {
    Wide x, y{}, q;
    load(first + i, x);
    if constexpr (both) load(second + i, y);
    for (int c = 0; c < 4; ++c) {
      load(columns[c] + i, q);
      sums[c] += q * x;
      if constexpr (both) sums[4 + c] += q * y;
    }
  }
  for (int c = 0; c < 4; ++c) {
    products[c] = sum_of_lanes(sums[c]);
    products[4 + c] = both ? sum_of_lanes(sums[4 + c]) : 0;
  }
  for (; i < rows; ++i) {
    for (int c = 0; c < 4; ++c) {
      products[c] += columns[c][i] * first[i];
      if constexpr (both) products[4 + c] += columns[c][i] * second[i];
    }
  }
}
TREMULA_CLONES void dots_with_one(const double* const* columns, const double* first, Eigen::Index rows,
                                  double* products) {
  four_dots<false>(columns, first, nullptr, rows, products);
}
TREMULA_CLONES void dots_with_two(const double* const* columns, const double* first, const double* second,
                                  Eigen::Index rows, double* products) {
  four_dots<true>(columns, first, second, rows, products);
}

TREMULA_CLONES void subtract_four(const double* const* columns, const double* factors, double* target,
                                  Eigen::Index rows) {
  for (Eigen::Index i = 0; i < rows; ++i) {
    target[i] -= (factors[0] * columns[0][i] + factors[1] * columns[1][i]) +
                 (factors[2] * columns[2][i] + factors[3] * columns[3][i]);
  }
}

// result (rows x k, columns `stride` apart) += four columns times factors (4 x k).
TREMULA_CLONES void add_four(const double* const* columns, const double* factors, Eigen::Index k,
                             Eigen::Index rows, double* result, Eigen::Index stride) {
  for (Eigen::Index c = 0; c < k; ++c) {
    double* target = result + c * stride;
    const double f0 = factors[4 * c], f1 = factors[4 * c + 1], f2 = factors[4 * c + 2],
                 f3 = factors[4 * c + 3];
    for (Eigen::Index i = 0; i < rows; ++i) {
      target[i] += (f0 * columns[0][i] + f1 * columns[1][i]) + (f2 * columns[2][i] + f3 * columns[3][i]);
    }
  }
}

// Four columns from `first` on, at a row; past the end, the last one again, to be multiplied by 0.
struct FourColumns {
  const double* data[4];
  FourColumns(const Columns& basis, Eigen::Index first, Eigen::Index count, Eigen::Index row) {
    for (Eigen::Index c = 0; c < 4; ++c) data[c] = basis.data(std::min(first + c, count - 1)) + row;
  }
};

}  // namespace

void Columns::Free::operator()(double* memory) const { ::operator delete(memory, alignment); }

void Columns::append() {
  const std::size_t bytes = static_cast<std::size_t>(rows_) * sizeof(double);
  columns_.emplace_back(static_cast<double*>(::operator new(bytes, alignment)));
  scale.push_back(1);
}

void Columns::drop_from(Eigen::Index count) {
  columns_.resize(static_cast<std::size_t>(count));
  scale.resize(static_cast<std::size_t>(count));
}

double three_term_step(double* next, const double* current, const double* previous, Eigen::Index rows,
                       double a, double b, double c) {
  std::vector<double> parts(static_cast<std::size_t>(tile_count(rows)));
  const double* before = previous ? previous : current;
  const double factor = previous ? c : 0;
  for_each_tile(rows, [&](Eigen::Index t, Eigen::Index first, Eigen::Index count) {
    parts[static_cast<std::size_t>(t)] =
        step_tile(next + first, current + first, before + first, count, a, b, factor);
  });
  return sum_of_tiles(parts);
}

double dot(const double* a, const double* b, Eigen::Index rows) {
  std::vector<double> parts(static_cast<std::size_t>(tile_count(rows)));
  for_each_tile(rows, [&](Eigen::Index t, Eigen::Index first, Eigen::Index count) {
    parts[static_cast<std::size_t>(t)] = dot_tile(a + first, b + first, count);
  });
  return sum_of_tiles(parts);
}

double remove_projection(const Columns& basis, Eigen::Index count, double* first, double* second) {
  if (count == 0) return 0;
  const Eigen::Index rows = basis.rows(), fours = (count + 3) / 4;
  Eigen::MatrixXd products(8 * fours, tile_count(rows));
  for_each_tile(rows, [&](Eigen::Index t, Eigen::Index row, Eigen::Index tile) {
    for (Eigen::Index four = 0; four < fours; ++four) {
      const FourColumns columns(basis, 4 * four, count, row);
      double* to = products.col(t).data() + 8 * four;
      if (second) {
        dots_with_two(columns.data, first + row, second + row, tile, to);
      } else {
        dots_with_one(columns.data, first + row, tile, to);
      }
    }
  });
  Eigen::VectorXd factors = products.rowwise().sum();
  double largest = 0;
  for (Eigen::Index i = 0; i < 4 * fours; ++i) {
    const double scale = i < count ? basis.scale[static_cast<std::size_t>(i)] : 0;
    const Eigen::Index of_first = 8 * (i / 4) + i % 4, of_second = of_first + 4;
    largest = std::max(largest, std::abs(scale * factors[second ? of_second : of_first]));
    factors[of_first] *= scale * scale;
    factors[of_second] *= scale * scale;
  }
  for_each_tile(rows, [&](Eigen::Index, Eigen::Index row, Eigen::Index tile) {
    for (Eigen::Index four = 0; four < fours; ++four) {
      const FourColumns columns(basis, 4 * four, count, row);
      subtract_four(columns.data, factors.data() + 8 * four, first + row, tile);
      if (second) subtract_four(columns.data, factors.data() + 8 * four + 4, second + row, tile);
    }
  });
  return largest;
}

void rotate(Columns& basis, const Eigen::MatrixXd& coefficients) {
  const Eigen::Index count = coefficients.rows(), k = coefficients.cols(), fours = (count + 3) / 4;
  Eigen::MatrixXd factors = Eigen::MatrixXd::Zero(4 * k, fours);  // by four columns: (4 x k)
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index c = 0; c < k; ++c)
      factors(4 * c + i % 4, i / 4) = basis.scale[static_cast<std::size_t>(i)] * coefficients(i, c);
  }
  constexpr Eigen::Index part = 64;  // rows whose results stay in the first-level cache
  for_each_tile(basis.rows(), [&](Eigen::Index, Eigen::Index row, Eigen::Index tile) {
    std::vector<double> result(static_cast<std::size_t>(part * k));
    for (Eigen::Index first = 0; first < tile; first += part) {
      const Eigen::Index height = std::min(part, tile - first);
      std::fill(result.begin(), result.end(), 0.0);
      for (Eigen::Index four = 0; four < fours; ++four) {
        const FourColumns columns(basis, 4 * four, count, row + first);
        add_four(columns.data, factors.col(four).data(), k, height, result.data(), part);
      }
      for (Eigen::Index c = 0; c < k; ++c)
        std::copy_n(result.data() + c * part, height, basis.data(c) + row + first);
    }
  });
  basis.drop_from(k);
  std::fill(basis.scale.begin(), basis.scale.end(), 1.0);
}

}  // namespace tremula
