#include "tremula/wind/field_at_points.hpp"

#include "tremula/base/error.hpp"
#include "tremula/base/number_text.hpp"
#include "tremula/numerics/fft.hpp"
#include "tremula/wind/check_field.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace tremula {
namespace {

constexpr double pi = std::numbers::pi;

std::string seconds(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g s", value);
  return text;
}

// How many steps of the field the loop takes.
int steps_in_loop(const WindGrid& grid, const TimeAxis& loop) {
  const double steps = loop.period / grid.step;
  if (!(steps >= 0.5))
    throw InputError("period of the loop", seconds(loop.period),
                     "at least a step of the wind field, " + seconds(grid.step));
  if (!(steps < grid.step_count + 0.5)) {
    throw InputError("period of the loop", seconds(loop.period),
                     "at most the " + seconds(grid.period()) + " of the wind field (or a longer field)");
  }
  return std::max(static_cast<int>(std::lround(steps)), 1);
}

// The last `fade` rows go over into the first, backwards, with their variance kept.
void close_loop(Eigen::MatrixXd& fluctuation, Eigen::Index fade) {
  const Eigen::Index count = fluctuation.rows();
  for (Eigen::Index k = 1; k <= fade; ++k) {
    const double angle = 0.5 * pi * static_cast<double>(k) / static_cast<double>(fade + 1);
    const Eigen::Index t = count - 1 - fade + k;
    fluctuation.row(t) = std::cos(angle) * fluctuation.row(t) + std::sin(angle) * fluctuation.row(count - t);
  }
}

struct Between {
  int below;
  double share;  // of the grid point above
  bool outside;
};

Between locate(double position, int count) {
  const double last = count - 1, inside = std::clamp(position, 0.0, last);
  const int below = std::min(static_cast<int>(inside), std::max(count - 2, 0));
  // Rounding puts points at the edge a hair beyond it.
  return {below, inside - below, std::abs(position - inside) > 1e-6};
}

}  // namespace

FieldAtPoints::FieldAtPoints(const WindField& field, double heading, const TimeAxis& loop,
                             const Eigen::Matrix3Xd& points)
    : loop_(loop), grid_points_(field.grid.point_count()) {
  check_wind_field(field);
  const WindGrid& grid = field.grid;
  if (!std::isfinite(heading)) throw InputError("heading", number_text(heading), "an angle in degrees");
  if (loop.sample_count < 1)
    throw InputError("samples of the loop", std::to_string(loop.sample_count), "1 or more");
  if (!(grid.mean_speed > 0)) {
    throw InputError("mean speed of the wind field", number_text(grid.mean_speed),
                     "above 0 m/s, to carry the gusts along");
  }
  const int steps = steps_in_loop(grid, loop);
  const bool whole = steps == grid.step_count && grid.periodic;
  const int fade = whole ? 0 : steps / 10;
  if (steps < grid.step_count) {
    warnings_.push_back("the loop of " + seconds(loop.period) + " takes the beginning of a wind field of " +
                        seconds(grid.period()) + " and fades its end into its start over " +
                        seconds(fade * grid.step) + "; gusts slower than the loop are cut off");
  } else if (!whole) {
    warnings_.push_back("the wind field is not periodic: its last " + seconds(fade * grid.step) +
                        " fade into its start");
  }

  const double angle = heading * pi / 180;
  axes_ << std::cos(angle), -std::sin(angle), 0, std::sin(angle), std::cos(angle), 0, 0, 0, 1;
  places_.reserve(static_cast<std::size_t>(points.cols()));
  for (Eigen::Index k = 0; k < points.cols(); ++k) {
    const Eigen::Vector3d local = axes_.transpose() * points.col(k);
    if (!local.allFinite()) throw InputError("point " + std::to_string(k), "not finite", "a place in metres");
    const Between across =
                      locate(grid.y_count == 1 ? 0 : (local.y() - grid.y(0)) / grid.y_spacing, grid.y_count),
                  up = locate(grid.z_count == 1 ? 0 : (local.z() - grid.bottom) / grid.z_spacing,
                              grid.z_count);
    outside_ += across.outside || up.outside;
    Place place;
    place.delay = local.x() / grid.mean_speed;
    for (int corner = 0; corner < 4; ++corner) {
      const bool right = corner % 2 == 1, upper = corner / 2 == 1;
      const int j = std::min(across.below + right, grid.y_count - 1),
                i = std::min(up.below + upper, grid.z_count - 1);
      const auto n = static_cast<std::size_t>(corner);
      place.corner[n] =
          static_cast<std::size_t>(i) * static_cast<std::size_t>(grid.y_count) + static_cast<std::size_t>(j);
      place.weight[n] =
          static_cast<float>((right ? across.share : 1 - across.share) * (upper ? up.share : 1 - up.share));
    }
    places_.push_back(place);
  }

  bin_count_ = std::min(steps / 2 + 1, loop.bin_count());
  for (std::size_t c = 0; c < 3; ++c) {
    spectra_[c].resize(static_cast<std::size_t>(bin_count_) * grid_points_);
    // A row of the grid at a time, so that the samples in double are few.
    for (int i = 0; i < grid.z_count; ++i) {
      const std::size_t first = static_cast<std::size_t>(i) * static_cast<std::size_t>(grid.y_count);
      Eigen::MatrixXd series(steps, grid.y_count);
      for (int t = 0; t < steps; ++t) {
        const float* values = field.velocity[c].data() + static_cast<std::size_t>(t) * grid_points_ + first;
        for (int j = 0; j < grid.y_count; ++j) series(t, j) = static_cast<double>(values[j]);
      }
      if (fade > 0) {
        const Eigen::RowVectorXd mean = series.colwise().mean();
        series.rowwise() -= mean;
        close_loop(series, fade);
        series.rowwise() += mean;
      }
      const Eigen::MatrixXcd spectra = half_spectra_from_samples(series);
      for (int p = 0; p < bin_count_; ++p) {
        // The Nyquist bin of the field is the sum of +f and -f; where the loop is finer, these are two.
        const bool both = 2 * p == steps && loop.sample_count > steps;
        std::complex<float>* bins = spectra_[c].data() + static_cast<std::size_t>(p) * grid_points_ + first;
        for (int j = 0; j < grid.y_count; ++j)
          bins[j] = static_cast<std::complex<float>>((both ? 0.5 : 1.0) * spectra(p, j));
      }
    }
  }
}

Eigen::Matrix3Xcd FieldAtPoints::interpolated(int bin) const {
  Eigen::Matrix3Xcd local(3, static_cast<Eigen::Index>(places_.size()));
  const std::size_t first = static_cast<std::size_t>(bin) * grid_points_;
  for (std::size_t k = 0; k < places_.size(); ++k) {
    const Place& place = places_[k];
    for (std::size_t c = 0; c < 3; ++c) {
      std::complex<float> sum = 0;
      for (std::size_t n = 0; n < 4; ++n) sum += place.weight[n] * spectra_[c][first + place.corner[n]];
      local(static_cast<Eigen::Index>(c), static_cast<Eigen::Index>(k)) = sum;
    }
  }
  return local;
}

Eigen::Matrix3Xcd FieldAtPoints::velocity(int bin) const {
  const auto count = static_cast<Eigen::Index>(places_.size());
  if (bin == 0 || bin >= bin_count_) return Eigen::Matrix3Xcd::Zero(3, count);
  Eigen::Matrix3Xcd local = interpolated(bin);
  for (Eigen::Index k = 0; k < count; ++k)
    local.col(k) *= std::polar(1.0, -loop_.omega(bin) * places_[static_cast<std::size_t>(k)].delay);
  return axes_ * local;
}

Eigen::Matrix3Xd FieldAtPoints::mean_velocity() const { return axes_ * interpolated(0).real(); }

}  // namespace tremula
