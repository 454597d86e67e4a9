#include "tremula/wind/stam_wind.hpp"

#include "tremula/base/error.hpp"
#include "tremula/numerics/random.hpp"
#include "tremula/wind/spectrum.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>

namespace tremula {
namespace {

constexpr int block_size = 64;
constexpr double lowest_height = 0.5;
constexpr RandomStream streams[3] = {RandomStream::wind_u, RandomStream::wind_v, RandomStream::wind_w};

// Splits the points in half along the longer side of their box until a block is small: near points, near
// indices.
void sort_into_blocks(const Eigen::Matrix3Xd& points, std::vector<int>& order, int first, int last,
                      std::vector<std::pair<int, int>>& blocks) {
  if (last - first <= block_size) {
    blocks.emplace_back(first, last - first);
    return;
  }
  Vec3 low = points.col(order[static_cast<std::size_t>(first)]), high = low;
  for (int i = first; i < last; ++i) {
    low = low.cwiseMin(points.col(order[static_cast<std::size_t>(i)]));
    high = high.cwiseMax(points.col(order[static_cast<std::size_t>(i)]));
  }
  Eigen::Index axis = 0;
  (high - low).maxCoeff(&axis);
  // Halves that are whole blocks keep the number of blocks small.
  const int blocks_in_range = (last - first + block_size - 1) / block_size;
  const int middle = first + blocks_in_range / 2 * block_size;
  std::nth_element(order.begin() + first, order.begin() + middle, order.begin() + last, [&](int a, int b) {
    return std::pair(points(axis, a), a) < std::pair(points(axis, b), b);
  });
  sort_into_blocks(points, order, first, middle, blocks);
  sort_into_blocks(points, order, middle, last, blocks);
}

}  // namespace

void check_stam_wind(const StamWind& wind) {
  check_mean_wind(wind.mean);
  const auto check = [](bool good, const char* what, double value, const char* wanted) {
    if (!good || !std::isfinite(value)) throw InputError(what, std::to_string(value), wanted);
  };
  check(wind.turbulence_intensity >= 0 && wind.turbulence_intensity <= 2, "turbulence intensity",
        wind.turbulence_intensity, "0 to 2");
  check(wind.correlation_time >= 0, "correlation time", wind.correlation_time, "0 s or more");
  check(wind.correlation_length > 0, "correlation length", wind.correlation_length, "a length above 0 m");
  check(wind.cutoff >= 0 && wind.cutoff < 1, "filter cut-off", wind.cutoff, "0 to below 1");
}

StamWindAtPoints::StamWindAtPoints(const StamWind& wind, const TimeAxis& axis, const Eigen::Matrix3Xd& points)
    : wind_(wind),
      axis_(axis),
      friction_velocity_(friction_velocity_from_intensity(wind.turbulence_intensity, wind.mean.speed)),
      heights_(points.row(2).transpose().cwiseMax(lowest_height)),
      speeds_(points.cols()),
      order_(static_cast<std::size_t>(points.cols())),
      points_(points.cols(), 3) {
  check_stam_wind(wind);
  for (Eigen::Index i = 0; i < points.cols(); ++i) speeds_[i] = mean_speed(wind.mean, heights_[i]);
  std::iota(order_.begin(), order_.end(), 0);
  std::vector<std::pair<int, int>> ranges;
  sort_into_blocks(points, order_, 0, static_cast<int>(points.cols()), ranges);
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    points_.row(i) = points.col(order_[static_cast<std::size_t>(i)]).cast<float>().transpose();
  }
  for (const auto& [first, count] : ranges) {
    const auto block = points_.middleRows(first, count);
    blocks_.push_back({first, count, block.colwise().minCoeff().transpose().array(),
                       block.colwise().maxCoeff().transpose().array()});
  }
}

void StamWindAtPoints::filter(double omega, const Eigen::Matrix<float, Eigen::Dynamic, 6>& noise,
                              Eigen::Matrix<float, Eigen::Dynamic, 6>& filtered,
                              Eigen::VectorXf& squared_weights) const {
  filtered.setZero(noise.rows(), 6);
  squared_weights.setZero(noise.rows());
  const auto decay = static_cast<float>(wind_.correlation_time * omega / wind_.correlation_length);  // [1/m]
  const double reach = wind_.cutoff > 0 && decay > 0 ? -std::log(wind_.cutoff) / static_cast<double>(decay)
                                                     : std::numeric_limits<double>::infinity();
  Eigen::ArrayXXf weights;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const Block& rows = blocks_[i];
    for (std::size_t j = i; j < blocks_.size(); ++j) {
      const Block& columns = blocks_[j];
      const Eigen::Array3f gap = (rows.low - columns.high).max(columns.low - rows.high).max(0.0F);
      if (static_cast<double>(gap.matrix().norm()) > reach) continue;

      weights.setZero(rows.count, columns.count);
      for (int axis = 0; axis < 3; ++axis) {
        const auto x = points_.col(axis).segment(rows.first, rows.count).array();
        for (int c = 0; c < columns.count; ++c) {
          weights.col(c) += (x - points_(columns.first + c, axis)).square();
        }
      }
      weights = (-decay * weights.sqrt()).exp();
      // The filter is symmetric: a pair of blocks is worked out once and serves both ways.
      filtered.middleRows(rows.first, rows.count).noalias() +=
          weights.matrix() * noise.middleRows(columns.first, columns.count);
      squared_weights.segment(rows.first, rows.count) += weights.square().rowwise().sum().matrix();
      if (i == j) continue;
      filtered.middleRows(columns.first, columns.count).noalias() +=
          weights.matrix().transpose() * noise.middleRows(rows.first, rows.count);
      squared_weights.segment(columns.first, columns.count) +=
          weights.square().colwise().sum().matrix().transpose();
    }
  }
}

Eigen::Matrix3Xcd StamWindAtPoints::velocity(int bin) const {
  const Eigen::Index count = points_.rows();
  Eigen::Matrix3Xcd velocity = Eigen::Matrix3Xcd::Zero(3, count);
  const bool as_printed = wind_.rows == StamRows::as_printed;
  if (!as_printed && (bin == 0 || wind_.mean.speed == 0)) return velocity;

  Eigen::Matrix<float, Eigen::Dynamic, 6> noise(count, 6), filtered;
  for (Eigen::Index i = 0; i < count; ++i) {
    for (int c = 0; c < 3; ++c) {
      const auto place = static_cast<std::uint64_t>(order_[static_cast<std::size_t>(i)]);
      const auto w = complex_gaussian({wind_.seed, streams[c], static_cast<std::uint32_t>(bin), place});
      noise(i, 2 * c) = static_cast<float>(w.real());
      noise(i, 2 * c + 1) = static_cast<float>(w.imag());
    }
  }
  Eigen::VectorXf squared_weights;
  filter(axis_.omega(bin), noise, filtered, squared_weights);

  const Vec3 along = heading_direction(wind_.mean), across(-along[1], along[0], 0);
  for (Eigen::Index i = 0; i < count; ++i) {
    const int caller = order_[static_cast<std::size_t>(i)];
    Vec3 amplitude = Vec3::Ones();
    if (!as_printed) {
      const double speed = speeds_[caller];
      if (speed <= 0) continue;
      const Vec3 spectrum =
          simiu_scanlan_spectrum(axis_.frequency(bin), heights_[caller], speed, friction_velocity_);
      amplitude = (spectrum / (2 * axis_.period * static_cast<double>(squared_weights[i]))).cwiseSqrt();
    }
    const auto component = [&](int c) {
      return amplitude[c] * std::complex<double>(static_cast<double>(filtered(i, 2 * c)),
                                                 static_cast<double>(filtered(i, 2 * c + 1)));
    };
    velocity.col(caller) = component(0) * along + component(1) * across + component(2) * Vec3::UnitZ();
  }
  return velocity;
}

}  // namespace tremula
