#include "tremula/wind/turbulent_wind_at_points.hpp"

#include "tremula/base/error.hpp"
#include "tremula/base/number_text.hpp"
#include "tremula/numerics/vector_math.hpp"
#include "tremula/wind/coherent_plane.hpp"
#include "tremula/wind/gust_lattice.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <tbb/enumerable_thread_specific.h>

namespace tremula {
namespace {

constexpr RandomStream streams[3] = {RandomStream::wind_u, RandomStream::wind_v, RandomStream::wind_w};
constexpr RandomStream lattice_streams[3] = {RandomStream::lattice_u, RandomStream::lattice_v,
                                             RandomStream::lattice_w};

// Part of the root-coherence that may come from the far side of the plane.
constexpr double padding_tolerance = 0.02;

// Amplitudes are tabulated at heights this far apart, in the logarithm, and interpolated linearly.
constexpr double level_step = 0.02;
constexpr Eigen::Index fewest_interpolated = 512;

// A node holds u, v, w as complex numbers, and fills a vector register: a corner of a cell is one load.
// Beside them is the noise of the cell that begins at the node; together they fill a cache line.
constexpr int node_size = 16, noise_of_cell = 8, lanes = 8;

// Noise of the cells has bins of its own.
constexpr std::uint32_t cell_bins = 1U << 31;

// Points are worked off in pieces that stay in the first-level cache.
constexpr int piece = 128;

struct BinPlane {
  const CoherentPlane* plane = nullptr;
  int kept_rows = 1, kept_columns = 1;
  double row_spacing = 1, column_spacing = 1;
  std::array<CoherenceDecay, 3> decays;
  std::array<bool, 3> coherent;
};

struct Work {
  CoherentPlaneWork plane;
  FftArray<float> nodes;
  std::vector<float> levels;
  std::array<std::vector<std::complex<float>>, 3> noise;  // of points that are no part of a plane
  LatticeWork lattice;
  std::vector<std::complex<float>> cell_noise;
};

// Corner weights of a piece of points, and how much noise of the cell restores the variance of each
// component.
struct Corners {
  std::int32_t node[piece];  // first float of the lower left node
  alignas(64) float weight[4][piece];
  alignas(64) float missing[3][piece];
};

struct CellShape {
  float columns_per_metre, rows_per_metre;
  std::int32_t last_column, last_row, row_size;
  float across[3], up[3], diagonal[3];  // root-coherence of neighbouring nodes, by component
};

TREMULA_CLONES void find_corners(int count, const float* across, const float* up, const CellShape& cell,
                                 Corners& corners) {
  for (int i = 0; i < count; ++i) {
    const float y = across[i] * cell.columns_per_metre, z = up[i] * cell.rows_per_metre;
    const std::int32_t column = std::clamp(static_cast<std::int32_t>(y), 0, cell.last_column);
    const std::int32_t row = std::clamp(static_cast<std::int32_t>(z), 0, cell.last_row);
    const float a = y - static_cast<float>(column), b = z - static_cast<float>(row);
    corners.node[i] = row * cell.row_size + column * node_size;
    corners.weight[0][i] = (1 - a) * (1 - b);
    corners.weight[1][i] = a * (1 - b);
    corners.weight[2][i] = (1 - a) * b;
    corners.weight[3][i] = a * b;
    const float same_column = (1 - a) * (1 - a) + a * a, same_row = (1 - b) * (1 - b) + b * b;
    const float two_columns = 2 * a * (1 - a), two_rows = 2 * b * (1 - b);
    for (int c = 0; c < 3; ++c) {
      const float variance = same_column * same_row + two_columns * same_row * cell.across[c] +
                             same_column * two_rows * cell.up[c] + two_columns * two_rows * cell.diagonal[c];
      corners.missing[c][i] = std::sqrt(std::max(0.0F, 1 - variance));
    }
  }
}

TREMULA_CLONES void interpolate(int count, const float* nodes, std::int32_t next_column,
                                std::int32_t next_row, const Corners& corners, float* values) {
  for (int i = 0; i < count; ++i) {
    const float* low = nodes + corners.node[i];
    const float* high = low + next_row;
    const float w0 = corners.weight[0][i], w1 = corners.weight[1][i], w2 = corners.weight[2][i],
                w3 = corners.weight[3][i];
    for (int k = 0; k < lanes; ++k) {
      values[lanes * i + k] =
          (w0 * low[k] + w1 * low[next_column + k]) + (w2 * high[k] + w3 * high[next_column + k]);
    }
  }
}

// exp(-2 pi i turns_per_metre x), float enough: 2^-24 of the turns.
TREMULA_CLONES void phases_along(int count, float turns_per_metre, const float* along, float* cosines,
                                 float* sines) {
  for (int i = 0; i < count; ++i) {
    const float turns = -turns_per_metre * along[i];
    // Beyond 2^22 turns nothing is left of the phase, but it stays one.
    const float rest = std::clamp(turns - ((turns + 12582912.0F) - 12582912.0F), -0.5F, 0.5F);
    const SinCos angle = sincos_of_turns(static_cast<std::int32_t>(rest * 4294967040.0F));
    cosines[i] = angle.cosine;
    sines[i] = angle.sine;
  }
}

double largest_of(const std::vector<float>& values) {
  return values.empty() ? 0 : static_cast<double>(*std::max_element(values.begin(), values.end()));
}

}  // namespace

struct TurbulentWindAtPoints::State {
  TurbulentWind wind;
  TimeAxis axis;
  Eigen::Index count;
  double width, height;                  // of the box around the points, across the wind and up [m]
  std::vector<float> along, across, up;  // from the corner of the box around the points [m]
  bool blows = false, of_world = false;
  // Of the world: from its origin [m].
  std::vector<double> world_across, world_up;
  std::vector<std::array<float, 2>> heading;  // of the mean wind at the points: cosine and sine
  double coherency_uw;
  std::vector<std::int32_t> level;
  std::vector<float> level_share;  // of the level above
  std::vector<double> level_height, level_speed;
  std::map<std::pair<int, int>, std::unique_ptr<CoherentPlane>> planes;
  std::vector<BinPlane> of_bin;
  mutable tbb::enumerable_thread_specific<Work> works;

  BinPlane choose_plane(int bin, const WindAtPointsOptions& options, int largest);
  void set_levels(const Eigen::Matrix3Xd& points);
  void draw_nodes(int bin, int draw, Work& work) const;
  void draw_of_world(int bin, int draw, Work& work) const;
};

BinPlane TurbulentWindAtPoints::State::choose_plane(int bin, const WindAtPointsOptions& options,
                                                    int largest) {
  BinPlane result;
  CoherenceDecay fastest, slowest{1e6, 1e6};
  for (int c = 0; c < 3; ++c) {
    const auto at = static_cast<std::size_t>(c);
    const CoherenceDecay decay = coherence_decay(wind.coherence, c, axis.middle_frequency(bin));
    result.decays[at] = decay;
    result.coherent[at] = std::isfinite(decay.y) && std::isfinite(decay.z);
    if (!result.coherent[at]) continue;
    fastest = {std::max(fastest.y, decay.y), std::max(fastest.z, decay.z)};
    slowest = {std::min(slowest.y, decay.y), std::min(slowest.z, decay.z)};
  }
  // A cell covers what hardly decays; without decay, all.
  const auto cells = [](double size, double decays, double spacing) {
    return size > 0 ? std::max(1, whole_number_from(std::min(size * decays / spacing, 1e6))) : 0;
  };
  for (double spacing = options.resolution;; spacing *= 1.1) {
    const int across_cells = cells(width, fastest.y, spacing), up_cells = cells(height, fastest.z, spacing);
    const auto too_large = [&](int rows, int columns) {
      const bool coarsest = across_cells <= 1 && up_cells <= 1;
      return !coarsest && static_cast<double>(rows) * columns > largest;
    };
    result.kept_columns = across_cells + 1;
    result.kept_rows = up_cells + 1;
    if (too_large(result.kept_rows, result.kept_columns)) continue;
    result.column_spacing = across_cells > 0 ? width / across_cells : 1;
    result.row_spacing = up_cells > 0 ? height / up_cells : 1;
    const int columns = fast_length(
        periodic_length(result.kept_columns, result.column_spacing, slowest.y, padding_tolerance));
    const int rows =
        fast_length(periodic_length(result.kept_rows, result.row_spacing, slowest.z, padding_tolerance));
    if (too_large(rows, columns)) continue;
    auto& plane = planes[{rows, columns}];
    // Bins share planes of one size, whatever part of it they keep.
    if (!plane) plane = std::make_unique<CoherentPlane>(rows, columns, rows);
    result.plane = plane.get();
    return result;
  }
}

void TurbulentWindAtPoints::State::set_levels(const Eigen::Matrix3Xd& points) {
  level.resize(static_cast<std::size_t>(count));
  level_share.assign(static_cast<std::size_t>(count), 0.0F);
  const Eigen::VectorXd heights = points.row(2).transpose().cwiseMax(lowest_spectrum_height);
  if (count < fewest_interpolated) {
    for (Eigen::Index k = 0; k < count; ++k) {
      level[static_cast<std::size_t>(k)] = static_cast<std::int32_t>(k);
      level_height.push_back(heights[k]);
    }
    level_height.push_back(1);  // the level above the last
  } else {
    const auto logarithm = [](double z) { return std::log(std::max(z, lowest_spectrum_height)); };
    const double lowest = logarithm(heights.minCoeff()), range = logarithm(heights.maxCoeff()) - lowest;
    const int steps = std::max(1, static_cast<int>(std::ceil(range / level_step)));
    const double step = std::max(range / steps, 1e-9);
    for (int i = 0; i <= steps; ++i) level_height.push_back(std::exp(lowest + i * step));
    for (Eigen::Index k = 0; k < count; ++k) {
      const double at = (std::log(heights[k]) - lowest) / step;
      const int below = std::clamp(static_cast<int>(at), 0, steps - 1);
      level[static_cast<std::size_t>(k)] = below;
      level_share[static_cast<std::size_t>(k)] = static_cast<float>(at - below);
    }
  }
  for (const double z : level_height) level_speed.push_back(mean_speed(wind.mean, z));
}

TurbulentWindAtPoints::TurbulentWindAtPoints(const TurbulentWind& wind, const TimeAxis& axis,
                                             const Eigen::Matrix3Xd& points,
                                             const WindAtPointsOptions& options) {
  check_turbulent_wind(wind);
  if (!(axis.period > 0) || !std::isfinite(axis.period) || axis.sample_count < 1) {
    throw InputError("loop",
                     number_text(axis.period) + " s and " + std::to_string(axis.sample_count) + " samples",
                     "a period above 0 s and 1 sample or more");
  }
  if (!(options.resolution > 0 && options.resolution <= 10)) {
    throw InputError("resolution of the wind at points", number_text(options.resolution),
                     "above 0, up to 10");
  }
  if (options.largest_plane < 0) {
    throw InputError("largest plane of the wind at points", std::to_string(options.largest_plane),
                     "0 or more");
  }
  if (!points.allFinite())
    throw InputError("points in the wind", "one that is not finite", "finite coordinates");

  auto state = std::make_unique<State>();
  state->wind = wind;
  state->axis = axis;
  state->count = points.cols();
  const Vec3 along = heading_direction(wind.mean), across(-along[1], along[0], 0);
  state->of_world = options.realisation == Realisation::of_world;
  if (state->of_world && wind.amplitudes != Amplitudes::gaussian)
    throw InputError("amplitudes of a wind that many share", "phases only", "gaussian");
  const auto coordinates = [&](const Vec3& direction) {
    Eigen::VectorXd values = points.transpose() * direction;
    if (values.size() > 0 && !state->of_world) values.array() -= values.minCoeff();
    return std::vector<float>(values.begin(), values.end());
  };
  state->along = coordinates(along);
  state->across = coordinates(across);
  state->up = coordinates(Vec3::UnitZ());
  if (state->of_world) {
    const Eigen::VectorXd values = points.transpose() * across;
    state->world_across.assign(values.begin(), values.end());
    for (Eigen::Index k = 0; k < points.cols(); ++k) state->world_up.push_back(points(2, k));
  }
  // What is thinner than a micrometre is flat to gusts, and cells of it would be beyond floats.
  constexpr double flat = 1e-6;
  const auto thick = [](double length) { return length < flat ? 0 : length; };
  state->width = thick(largest_of(state->across));
  state->height = thick(largest_of(state->up));
  for (Eigen::Index k = 0; k < points.cols(); ++k) {
    const Vec3 direction = heading_direction(wind.mean, points(2, k));
    state->heading.push_back({static_cast<float>(direction[0]), static_cast<float>(direction[1])});
  }
  state->coherency_uw = tremula::coherency_uw(wind);
  state->set_levels(points);
  state->blows = state->count > 0 && wind.mean.speed > 0;
  if (state->blows && !state->of_world) {
    const int largest = options.largest_plane > 0
                            ? options.largest_plane
                            : static_cast<int>(std::clamp<Eigen::Index>(3 * state->count, 4096, 32768));
    for (int bin = 0; bin < axis.bin_count(); ++bin) {
      state->of_bin.push_back(state->choose_plane(bin, options, largest));
    }
  }
  state_ = std::move(state);
}

TurbulentWindAtPoints::~TurbulentWindAtPoints() = default;

TurbulentWindAtPoints::Plane TurbulentWindAtPoints::plane(int bin) const {
  if (state_->of_world) return {};
  const BinPlane& chosen = state_->of_bin.at(static_cast<std::size_t>(bin));
  if (chosen.plane == nullptr) return {};
  return {chosen.plane->rows(), chosen.plane->columns(), chosen.row_spacing, chosen.column_spacing};
}

void TurbulentWindAtPoints::State::draw_nodes(int bin, int draw, Work& work) const {
  const std::uint32_t address = bin_of_draw(bin, draw);
  const BinPlane& chosen = of_bin[static_cast<std::size_t>(bin)];
  const auto columns = static_cast<std::size_t>(chosen.kept_columns),
             rows = static_cast<std::size_t>(chosen.kept_rows);
  work.nodes.resize(columns * rows * node_size);
  const auto same = [](const CoherenceDecay& a, const CoherenceDecay& b) { return a.y == b.y && a.z == b.z; };
  std::array<CoherenceDecay, 2> set = {};
  bool any_set = false;
  for (std::size_t c = 0; c < 3; ++c) {
    Noise noise{.amplitudes = wind.amplitudes,
                .seed = wind.seed,
                .stream = streams[c],
                .bin = address,
                .shared = c == 2 ? coherency_uw : 0};
    if (!chosen.coherent[c]) {
      work.noise[c].resize(static_cast<std::size_t>(count));
      draw_noise(noise, work.noise[c].size(), work.noise[c].data());
      for (std::size_t node = 0; node < columns * rows; ++node) {
        std::fill_n(work.nodes.data() + node * node_size + 2 * c, 2, 0.0F);
        std::fill_n(work.nodes.data() + node * node_size + noise_of_cell + 2 * c, 2, 0.0F);
      }
      continue;
    }
    Noise of_plane = noise;
    if (noise.shared != 0) {
      set = {chosen.decays[0], chosen.decays[c]};
      chosen.plane->set_coherences(set, chosen.row_spacing, chosen.column_spacing, work.plane);
      of_plane.shared = std::clamp(coherency_uw / chosen.plane->likeness(work.plane), -1.0, 1.0);
    } else if (!any_set || (!same(chosen.decays[c], set[0]) && !same(chosen.decays[c], set[1]))) {
      set = {chosen.decays[c], chosen.decays[c]};
      if (c < 2 && chosen.coherent[c + 1]) set[1] = chosen.decays[c + 1];
      any_set = true;
      chosen.plane->set_coherences(set, chosen.row_spacing, chosen.column_spacing, work.plane);
    }
    const int which = same(chosen.decays[c], set[0]) ? 0 : 1;
    chosen.plane->draw(of_plane, which, work.plane);
    work.cell_noise.resize(columns * rows);
    noise.bin = cell_bins + address;
    draw_noise(noise, work.cell_noise.size(), work.cell_noise.data());
    const float scale = work.plane.scale[static_cast<std::size_t>(which)];
    for (std::size_t row = 0; row < rows; ++row) {
      const std::complex<float>* from =
          work.plane.plane.data() + row * static_cast<std::size_t>(chosen.plane->pitch());
      float* to = work.nodes.data() + row * columns * node_size + 2 * c;
      for (std::size_t i = 0; i < columns; ++i) {
        to[node_size * i] = scale * from[i].real();
        to[node_size * i + 1] = scale * from[i].imag();
        to[node_size * i + noise_of_cell] = work.cell_noise[row * columns + i].real();
        to[node_size * i + noise_of_cell + 1] = work.cell_noise[row * columns + i].imag();
      }
    }
  }
}

void TurbulentWindAtPoints::State::draw_of_world(int bin, int draw, Work& work) const {
  const std::uint32_t address = bin_of_draw(bin, draw);
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<std::complex<float>>& values = work.noise[c];
    values.resize(static_cast<std::size_t>(count));
    const CoherenceDecay decay =
        coherence_decay(wind.coherence, static_cast<int>(c), axis.middle_frequency(bin));
    const LatticeNoise noise{wind.seed, lattice_streams[c], address};
    if (std::isfinite(decay.y) && std::isfinite(decay.z)) {
      draw_on_lattice(noise, decay, world_across, world_up, work.lattice, values.data());
    } else {
      draw_at_places(noise, world_across, world_up, values.data());
    }
  }
  if (coherency_uw == 0) return;
  const auto shared = static_cast<float>(coherency_uw), own = std::sqrt(1 - shared * shared);
  for (std::size_t k = 0; k < work.noise[2].size(); ++k)
    work.noise[2][k] = own * work.noise[2][k] + shared * work.noise[0][k];
}

Eigen::Matrix3Xcd TurbulentWindAtPoints::velocity(int bin, int draw) const {
  const State& s = *state_;
  if (!s.blows) return Eigen::Matrix3Xcd::Zero(3, s.count);
  Work& work = s.works.local();
  BinPlane chosen;
  if (s.of_world) {
    s.draw_of_world(bin, draw, work);
    chosen.coherent = {};
    work.nodes.assign(node_size, 0.0F);
  } else {
    s.draw_nodes(bin, draw, work);
    chosen = s.of_bin[static_cast<std::size_t>(bin)];
  }

  work.levels.resize(4 * s.level_height.size());
  for (std::size_t i = 0; i < s.level_height.size(); ++i) {
    const Vec3 power =
        spectrum(s.wind.spectrum, s.axis.middle_frequency(bin), s.level_height[i], s.level_speed[i]);
    for (int c = 0; c < 3; ++c) {
      work.levels[4 * i + static_cast<std::size_t>(c)] =
          static_cast<float>(std::sqrt(power[c] / (2 * s.axis.period)));
    }
  }

  CellShape cell{static_cast<float>(1 / chosen.column_spacing),
                 static_cast<float>(1 / chosen.row_spacing),
                 std::max(0, chosen.kept_columns - 2),
                 std::max(0, chosen.kept_rows - 2),
                 chosen.kept_columns * node_size,
                 {},
                 {},
                 {}};
  for (std::size_t c = 0; c < 3; ++c) {
    if (!chosen.coherent[c]) continue;
    const CoherenceDecay& decay = chosen.decays[c];
    cell.across[c] = static_cast<float>(root_coherence(decay, chosen.column_spacing, 0));
    cell.up[c] = static_cast<float>(root_coherence(decay, 0, chosen.row_spacing));
    cell.diagonal[c] = static_cast<float>(root_coherence(decay, chosen.column_spacing, chosen.row_spacing));
  }
  const std::int32_t next_column = chosen.kept_columns > 1 ? node_size : 0;
  const std::int32_t next_row = chosen.kept_rows > 1 ? cell.row_size : 0;
  // In a world that loops, what is slower than the loop is the same all along the wind.
  const double carried = s.of_world ? s.axis.frequency(bin) : s.axis.middle_frequency(bin);
  const auto turns_per_metre = static_cast<float>(std::min(1e9, carried / s.wind.mean.speed));

  Eigen::Matrix3Xcd velocity(3, s.count);
  Corners corners;
  alignas(64) float values[piece * lanes], cosines[piece], sines[piece];
  for (Eigen::Index start = 0; start < s.count; start += piece) {
    const int count = static_cast<int>(std::min<Eigen::Index>(piece, s.count - start));
    find_corners(count, s.across.data() + start, s.up.data() + start, cell, corners);
    interpolate(count, work.nodes.data(), next_column, next_row, corners, values);
    for (std::size_t c = 0; c < 3; ++c) {
      if (chosen.coherent[c]) continue;
      for (int i = 0; i < count; ++i) {
        const std::complex<float> noise = work.noise[c][static_cast<std::size_t>(start + i)];
        corners.missing[c][i] = 0;
        values[lanes * i + 2 * static_cast<int>(c)] = noise.real();
        values[lanes * i + 2 * static_cast<int>(c) + 1] = noise.imag();
      }
    }
    phases_along(count, turns_per_metre, s.along.data() + start, cosines, sines);
    for (int i = 0; i < count; ++i) {
      const auto point = static_cast<std::size_t>(start + i);
      const float* level = work.levels.data() + 4 * s.level[point];
      const float share = s.level_share[point];
      const float* noise = work.nodes.data() + corners.node[i] + noise_of_cell;
      float real[3], imaginary[3];
      for (int c = 0; c < 3; ++c) {
        const float amplitude = level[c] + share * (level[4 + c] - level[c]), missing = corners.missing[c][i];
        const float x = amplitude * (values[lanes * i + 2 * c] + missing * noise[2 * c]);
        const float y = amplitude * (values[lanes * i + 2 * c + 1] + missing * noise[2 * c + 1]);
        real[c] = x * cosines[i] - y * sines[i];
        imaginary[c] = x * sines[i] + y * cosines[i];
      }
      const auto [cosine, sine] = s.heading[point];
      auto out = velocity.col(start + i);
      out[0] =
          std::complex<float>(cosine * real[0] - sine * real[1], cosine * imaginary[0] - sine * imaginary[1]);
      out[1] =
          std::complex<float>(sine * real[0] + cosine * real[1], sine * imaginary[0] + cosine * imaginary[1]);
      out[2] = std::complex<float>(real[2], imaginary[2]);
    }
  }
  return velocity;
}

}  // namespace tremula
