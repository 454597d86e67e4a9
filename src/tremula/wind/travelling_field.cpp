#include "tremula/wind/travelling_field.hpp"

#include "tremula/base/error.hpp"
#include "tremula/base/number_text.hpp"
#include "tremula/numerics/fft.hpp"
#include "tremula/wind/profile.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <string>

#include <tbb/parallel_for.h>

namespace tremula {
namespace {

struct Between {
  int low = 0, high = 0;
  float share = 0;  // of the high one
};

Between between(double position, int count) {
  const double inside = std::clamp(position, 0.0, static_cast<double>(count - 1));
  const int low = std::min(static_cast<int>(inside), std::max(count - 2, 0));
  return {low, std::min(low + 1, count - 1), static_cast<float>(inside - low)};
}

Between between_layers(const std::vector<double>& heights, double height) {
  const auto above = std::ranges::upper_bound(heights, height);
  if (above == heights.begin()) return {};
  const int last = static_cast<int>(heights.size()) - 1;
  if (above == heights.end()) return {last, last, 0};
  const int high = static_cast<int>(above - heights.begin());
  const double low = heights[index_of(high - 1)];
  return {high - 1, high, static_cast<float>((height - low) / (*above - low))};
}

// Where in the loop, so that t + T has the bits of t.
Between between_samples(double time, const TimeAxis& loop) {
  double periods = std::fmod(time / loop.period, 1.0);
  if (periods < 0) periods += 1;
  double position = periods * loop.sample_count;
  if (std::abs(position - std::round(position)) < 1e-9 * loop.sample_count) position = std::round(position);
  const int low = static_cast<int>(position) % loop.sample_count;
  return {low, (low + 1) % loop.sample_count, static_cast<float>(position - std::floor(position))};
}

}  // namespace

FieldPlane plane_across(std::span<const Vec3> points, double heading, double spacing,
                        std::vector<double> heights) {
  const Vec3 along = heading_direction(heading), across(-along.y(), along.x(), 0);
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (const Vec3& point : points) {
    least = std::min(least, point.dot(across));
    most = std::max(most, point.dot(across));
  }
  if (!(most >= least)) least = most = 0;
  FieldPlane plane{.first_column = least, .heights = std::move(heights)};
  const double cells = std::ceil((most - least) / spacing);
  if (!(spacing > 0) || !(cells < 1e8))
    throw InputError("spacing of the field", number_text(spacing) + " m", "one that fits the field");
  plane.columns = 1 + static_cast<int>(cells);
  plane.spacing = cells > 0 ? (most - least) / cells : spacing;
  return plane;
}

void check_plane(const FieldPlane& plane, const TimeAxis& loop) {
  if (plane.columns < 1 || !(plane.spacing > 0) || !std::isfinite(plane.spacing) ||
      !std::isfinite(plane.first_column)) {
    throw InputError("plane of the field",
                     std::to_string(plane.columns) + " columns " + number_text(plane.spacing) + " m apart",
                     "one column or more, at finite places");
  }
  const bool rising = std::ranges::adjacent_find(plane.heights, std::greater_equal{}) == plane.heights.end();
  const bool finite = std::ranges::all_of(plane.heights, [](double z) { return std::isfinite(z); });
  if (plane.heights.empty() || !rising || !finite)
    throw InputError("layers of the field", "heights that do not rise", "one finite height or more, rising");
  if (!(loop.period > 0) || !std::isfinite(loop.period) || loop.sample_count < 1)
    throw InputError("loop of the field", number_text(loop.period) + " s", "a period above 0 s, and samples");
  const double values =
      static_cast<double>(plane.columns) * static_cast<double>(plane.heights.size()) * loop.sample_count;
  if (values > most_field_values) {
    throw InputError(
        "plane of the field", number_text(values) + " values",
        "at most " + number_text(most_field_values) + ": take a larger spacing or a shorter loop");
  }
}

Eigen::Vector3f local_value_at(const TravellingField& field, const Vec3& place, double time) {
  const Vec3 along = heading_direction(field.heading);
  const double x = place.dot(along), y = place.y() * along.x() - place.x() * along.y();
  const Between t = between_samples(field.speed > 0 ? time - x / field.speed : time, field.loop);
  const Between c = between((y - field.plane.first_column) / field.plane.spacing, field.plane.columns);
  const Between z = between_layers(field.plane.heights, place.z() - field.ground);
  const auto at = [&](int layer, int sample, int column) {
    return Eigen::Vector3f::Map(field.values[field.index(layer, sample, column)].data());
  };
  const auto row = [&](int layer, int sample) -> Eigen::Vector3f {
    return (1 - c.share) * at(layer, sample, c.low) + c.share * at(layer, sample, c.high);
  };
  const auto layer = [&](int number) -> Eigen::Vector3f {
    return (1 - t.share) * row(number, t.low) + t.share * row(number, t.high);
  };
  if (z.share == 0) return layer(z.low);
  return (1 - z.share) * layer(z.low) + z.share * layer(z.high);
}

Vec3 mean_at(const TravellingField& field, double z) {
  const Between layer = between_layers(field.plane.heights, z - field.ground);
  const auto share = static_cast<double>(layer.share);
  return (1 - share) * field.mean[index_of(layer.low)] + share * field.mean[index_of(layer.high)];
}

Vec3 value_at(const TravellingField& field, const Vec3& place, double time) {
  const Vec3 along = heading_direction(field.heading);
  const Vec3 local = local_value_at(field, place, time).cast<double>();
  const Vec3 across(-along.y(), along.x(), 0);
  return mean_at(field, place.z()) + local.x() * along + local.y() * across + local.z() * Vec3::UnitZ();
}

TravellingField gust_field(const Wind& wind, const TimeAxis& loop, const FieldPlane& plane) {
  check_plane(plane, loop);
  const Vec3 along = heading_direction(wind.reference.heading), across(-along.y(), along.x(), 0);
  const int columns = plane.columns, layers = static_cast<int>(plane.heights.size());
  const auto count = Eigen::Index{layers} * columns;
  Eigen::Matrix3Xd points(3, count);
  for (int i = 0; i < layers; ++i) {
    for (int j = 0; j < columns; ++j) {
      points.col(Eigen::Index{i} * columns + j) =
          (plane.first_column + j * plane.spacing) * across + plane.heights[index_of(i)] * Vec3::UnitZ();
    }
  }
  const PointWind at = wind_at_points(wind, loop, points);
  const int bins = loop.bin_count();
  // One series of every component of every point; a block of points goes through the transform together.
  std::vector<std::complex<float>> spectra(index_of(3 * count) * index_of(bins));
  tbb::parallel_for(at.has_slow_gusts ? 0 : 1, bins, [&](int bin) {
    const Eigen::Matrix3Xcd velocity = at.velocity(bin, 0);
    for (Eigen::Index k = 0; k < count; ++k) {
      const Eigen::Vector3cd v = velocity.col(k);
      const Eigen::Vector3cd local(along.x() * v.x() + along.y() * v.y(),
                                   along.x() * v.y() - along.y() * v.x(), v.z());
      for (int c = 0; c < 3; ++c) {
        // Bin 0 is real, with the power of both sides (BinTransfer::respond).
        const std::complex<double> value = bin == 0 ? std::numbers::sqrt2 * local[c].real() : local[c];
        spectra[index_of(3 * k + c) * index_of(bins) + index_of(bin)] =
            static_cast<std::complex<float>>(value);
      }
    }
  });
  TravellingField field{.loop = loop,
                        .heading = wind.reference.heading,
                        .speed = wind.reference.speed,
                        .plane = plane,
                        .mean = {},
                        .values = {}};
  for (int i = 0; i < layers; ++i) field.mean.emplace_back(at.mean.col(Eigen::Index{i} * columns));
  field.values.resize(index_of(count) * index_of(loop.sample_count));
  constexpr int batch = 3;
  const RealSeries series(loop.sample_count, batch);
  tbb::parallel_for(Eigen::Index{0}, count, [&](Eigen::Index k) {
    FftArray<std::complex<float>> half(index_of(batch) * index_of(bins));
    FftArray<float> samples(index_of(batch) * index_of(series.pitch()));
    std::copy_n(spectra.data() + index_of(3 * k) * index_of(bins), half.size(), half.data());
    series.sum(half.data(), samples.data());
    const int layer = static_cast<int>(k / columns), column = static_cast<int>(k % columns);
    for (int p = 0; p < loop.sample_count; ++p) {
      auto& value = field.values[field.index(layer, p, column)];
      for (int c = 0; c < batch; ++c)
        value[index_of(c)] = samples[index_of(c) * index_of(series.pitch()) + index_of(p)];
    }
  });
  return field;
}

}  // namespace tremula
