#include "tremula/numerics/pairwise_filter.hpp"

#include "tremula/base/check.hpp"
#include "tremula/numerics/vector_math.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace tremula {
namespace {

constexpr int block_size = 64, lanes = 8, channels = PairwiseFilter::channels;

// One block of points with what goes in and what comes out; the channels are rows. The padding has mask 0.
struct alignas(64) Tile {
  float x[3][block_size];
  float mask[block_size];
  float noise[channels][block_size];
  float filtered[channels][block_size];
  float squared_weights[block_size];
};

inline float sum_of_lanes(const float* values) {
  return ((values[0] + values[1]) + (values[2] + values[3])) +
         ((values[4] + values[5]) + (values[6] + values[7]));
}

// Adds what each tile's noise gives to the other. Where both are one tile, the second half is left out.
// Columns go four at a time, so that what is accumulated is loaded and stored a quarter as often.
TREMULA_CLONES void filter_pair(float decay, Tile& rows, Tile& columns, bool same) {
  constexpr int group = 4;
  alignas(64) float weight[group][block_size];
  for (int first = 0; first < block_size; first += group) {
    for (int g = 0; g < group; ++g) {
      const int c = first + g;
      const float x = columns.x[0][c], y = columns.x[1][c], z = columns.x[2][c], mask = columns.mask[c];
      for (int i = 0; i < block_size; ++i) {
        const float dx = rows.x[0][i] - x, dy = rows.x[1][i] - y, dz = rows.x[2][i] - z;
        weight[g][i] = mask * rows.mask[i] * exp_minus(decay * std::sqrt(dx * dx + dy * dy + dz * dz));
      }
    }
    for (int q = 0; q < channels; ++q) {
      const float* noise = columns.noise[q] + first;
      for (int i = 0; i < block_size; ++i) {
        rows.filtered[q][i] += (weight[0][i] * noise[0] + weight[1][i] * noise[1]) +
                               (weight[2][i] * noise[2] + weight[3][i] * noise[3]);
      }
    }
    for (int i = 0; i < block_size; ++i) {
      rows.squared_weights[i] += (weight[0][i] * weight[0][i] + weight[1][i] * weight[1][i]) +
                                 (weight[2][i] * weight[2][i] + weight[3][i] * weight[3][i]);
    }
    if (same) continue;
    for (int q = 0; q < channels; ++q) {
      alignas(32) float sums[group][lanes] = {};
      for (int i = 0; i < block_size; i += lanes) {
        for (int g = 0; g < group; ++g) {
          for (int lane = 0; lane < lanes; ++lane)
            sums[g][lane] += weight[g][i + lane] * rows.noise[q][i + lane];
        }
      }
      for (int g = 0; g < group; ++g) columns.filtered[q][first + g] += sum_of_lanes(sums[g]);
    }
    for (int g = 0; g < group; ++g) {
      alignas(32) float sums[lanes] = {};
      for (int i = 0; i < block_size; i += lanes) {
        for (int lane = 0; lane < lanes; ++lane) sums[lane] += weight[g][i + lane] * weight[g][i + lane];
      }
      columns.squared_weights[first + g] += sum_of_lanes(sums);
    }
  }
}

// Splits the points in half along the longer side of their box until a block is small.
void sort_into_blocks(const Eigen::Matrix3Xd& points, std::vector<int>& order, int first, int last,
                      std::vector<int>& starts) {
  if (last - first <= block_size) {
    starts.push_back(first);
    return;
  }
  const auto point = [&](int i) { return points.col(order[static_cast<std::size_t>(i)]); };
  Eigen::Vector3d low = point(first), high = low;
  for (int i = first; i < last; ++i) {
    low = low.cwiseMin(point(i));
    high = high.cwiseMax(point(i));
  }
  Eigen::Index axis = 0;
  (high - low).maxCoeff(&axis);
  // Halves that are whole blocks keep the number of blocks small.
  const int middle = first + ((last - first + block_size - 1) / block_size) / 2 * block_size;
  std::nth_element(order.begin() + first, order.begin() + middle, order.begin() + last, [&](int a, int b) {
    return std::pair(points(axis, a), a) < std::pair(points(axis, b), b);
  });
  sort_into_blocks(points, order, first, middle, starts);
  sort_into_blocks(points, order, middle, last, starts);
}

}  // namespace

PairwiseFilter::PairwiseFilter(const Eigen::Matrix3Xd& points)
    : order_(static_cast<std::size_t>(points.cols())) {
  const int count = static_cast<int>(points.cols());
  std::iota(order_.begin(), order_.end(), 0);
  std::vector<int> starts;
  if (count > 0) sort_into_blocks(points, order_, 0, count, starts);
  coordinates_.assign(starts.size() * 3 * block_size, 0.0F);
  for (std::size_t b = 0; b < starts.size(); ++b) {
    const int first = starts[b], last = b + 1 < starts.size() ? starts[b + 1] : count;
    Block block{first, last - first, Eigen::Array3f::Constant(std::numeric_limits<float>::max()),
                Eigen::Array3f::Constant(std::numeric_limits<float>::lowest())};
    for (int i = first; i < last; ++i) {
      const Eigen::Array3f point = points.col(order_[static_cast<std::size_t>(i)]).cast<float>().array();
      block.low = block.low.min(point);
      block.high = block.high.max(point);
      for (int axis = 0; axis < 3; ++axis) {
        coordinates_[(3 * b + static_cast<std::size_t>(axis)) * block_size +
                     static_cast<std::size_t>(i - first)] = point[axis];
      }
    }
    blocks_.push_back(block);
  }
}

PairwiseFilter::Result PairwiseFilter::apply(double decay, double cutoff, const Channels& noise) const {
  check_equal("rows of the noise", noise.rows(), static_cast<std::ptrdiff_t>(order_.size()));
  if (!(std::isfinite(decay) && decay >= 0)) {
    throw InputError("decay of a filter", std::to_string(decay), "0 per metre or more");
  }
  std::vector<Tile> tiles(blocks_.size());
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    Tile& tile = tiles[b];
    tile = Tile{};
    std::copy_n(coordinates_.data() + 3 * b * block_size, 3 * block_size, &tile.x[0][0]);
    for (int i = 0; i < blocks_[b].count; ++i) {
      tile.mask[i] = 1;
      const int caller = order_[static_cast<std::size_t>(blocks_[b].first + i)];
      for (int q = 0; q < channels; ++q) tile.noise[q][i] = noise(caller, q);
    }
  }

  const double reach =
      cutoff > 0 && decay > 0 ? -std::log(cutoff) / decay : std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    for (std::size_t j = i; j < blocks_.size(); ++j) {
      const Eigen::Array3f gap =
          (blocks_[i].low - blocks_[j].high).max(blocks_[j].low - blocks_[i].high).max(0.0F);
      if (static_cast<double>(gap.matrix().norm()) > reach) continue;
      filter_pair(static_cast<float>(decay), tiles[i], tiles[j], i == j);
    }
  }

  Result result{Channels(noise.rows(), channels), Eigen::VectorXf(noise.rows())};
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    for (int i = 0; i < blocks_[b].count; ++i) {
      const int caller = order_[static_cast<std::size_t>(blocks_[b].first + i)];
      for (int q = 0; q < channels; ++q) result.filtered(caller, q) = tiles[b].filtered[q][i];
      result.squared_weights[caller] = tiles[b].squared_weights[i];
    }
  }
  return result;
}

}  // namespace tremula
