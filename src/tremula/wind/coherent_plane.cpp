#include "tremula/wind/coherent_plane.hpp"

#include "tremula/numerics/vector_math.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace tremula {
namespace {

constexpr int lanes = 8;

// Squares of the minimum-image separations on an axis, in decay lengths.
void square_separations(int length, double decay_per_cell, FftArray<float>& squares) {
  squares.resize(static_cast<std::size_t>(length));
  for (int i = 0; i < length; ++i) {
    const double separation = std::min(1e3, decay_per_cell) * std::min(i, length - i);
    squares[static_cast<std::size_t>(i)] = static_cast<float>(separation * separation);
  }
}

TREMULA_CLONES void coherence_row(int columns, float up_0, const float* across_0, float up_1,
                                  const float* across_1, float* row) {
  for (int c = 0; c < columns; ++c) {
    row[2 * c] = exp_minus(std::sqrt(up_0 + across_0[c]));
    row[2 * c + 1] = exp_minus(std::sqrt(up_1 + across_1[c]));
  }
}

// Roots of what is positive, and the sums of positive and of negative eigenvalues.
TREMULA_CLONES void roots_of_row(int columns, const float* row, float* root_0, float* root_1, double* sums) {
  alignas(64) float positive[2 * lanes] = {}, negative[2 * lanes] = {};
  const auto add = [&](int first, int count) {
    for (int i = 0; i < count; ++i) {
      positive[i] += std::max(0.0F, row[2 * first + i]);
      negative[i] += std::min(0.0F, row[2 * first + i]);
    }
  };
  int c = 0;
  for (; c + lanes <= columns; c += lanes) add(c, 2 * lanes);
  add(c, 2 * (columns - c));
  for (int i = 0; i < 2 * lanes; ++i) {
    sums[i % 2] += static_cast<double>(positive[i]);
    sums[2 + i % 2] -= static_cast<double>(negative[i]);
  }
  for (c = 0; c < columns; ++c) {
    root_0[c] = std::sqrt(std::max(0.0F, row[2 * c]));
    root_1[c] = std::sqrt(std::max(0.0F, row[2 * c + 1]));
  }
}

TREMULA_CLONES void multiply_row(int columns, const float* noise, const float* amplitude, float* row) {
  for (int c = 0; c < columns; ++c) {
    row[2 * c] = noise[2 * c] * amplitude[c];
    row[2 * c + 1] = noise[2 * c + 1] * amplitude[c];
  }
}

float* floats(std::complex<float>* values) { return reinterpret_cast<float*>(values); }

}  // namespace

int whole_number_from(double x) { return static_cast<int>(std::ceil(x * (1 - 1e-9))); }

int periodic_length(int points, double spacing, double decay, double tolerance) {
  if (points == 1) return 1;
  const double reach = -std::log(tolerance) / (decay * spacing);
  const int twice = 2 * (points - 1);
  return reach < points - 1 ? points - 1 + whole_number_from(reach) : twice;
}

void CoherentPlane::set_coherences(const std::array<CoherenceDecay, 2>& decays, double row_spacing,
                                   double column_spacing, CoherentPlaneWork& work) const {
  work.plane.resize(series_.size());
  for (FftArray<float>& amplitude : work.amplitude) amplitude.resize(series_.size());
  square_separations(rows(), decays[0].z * row_spacing, work.squared_separations[0]);
  square_separations(columns(), decays[0].y * column_spacing, work.squared_separations[1]);
  square_separations(rows(), decays[1].z * row_spacing, work.squared_separations[2]);
  square_separations(columns(), decays[1].y * column_spacing, work.squared_separations[3]);
  const auto& [up_0, across_0, up_1, across_1] = work.squared_separations;
  for (int r = 0; r < rows(); ++r) {
    std::complex<float>* row = work.plane.data() + static_cast<std::ptrdiff_t>(r) * pitch();
    const int mirror = rows() - r;
    if (r > mirror) {
      std::copy_n(work.plane.data() + static_cast<std::ptrdiff_t>(mirror) * pitch(), columns(), row);
    } else {
      const auto at = static_cast<std::size_t>(r);
      coherence_row(columns(), up_0[at], across_0.data(), up_1[at], across_1.data(), floats(row));
    }
  }
  series_.sum(work.plane.data());

  double sums[4] = {};
  for (int r = 0; r < rows(); ++r) {
    const std::ptrdiff_t start = static_cast<std::ptrdiff_t>(r) * pitch();
    roots_of_row(columns(), floats(work.plane.data() + start), work.amplitude[0].data() + start,
                 work.amplitude[1].data() + start, sums);
  }
  for (std::size_t k = 0; k < 2; ++k) {
    work.scale[k] = static_cast<float>(1 / std::sqrt(sums[k]));
    work.clipped_share[k] = sums[2 + k] / (sums[k] + sums[2 + k]);
  }
}

void CoherentPlane::draw(const Noise& noise, int which, CoherentPlaneWork& work) const {
  const std::size_t count = static_cast<std::size_t>(rows()) * static_cast<std::size_t>(columns());
  work.noise.resize(count);
  draw_noise(noise, count, work.noise.data());
  const FftArray<float>& amplitude = work.amplitude[static_cast<std::size_t>(which)];
  for (int r = 0; r < rows(); ++r) {
    const std::ptrdiff_t start = static_cast<std::ptrdiff_t>(r) * pitch();
    multiply_row(columns(), floats(work.noise.data() + static_cast<std::ptrdiff_t>(r) * columns()),
                 amplitude.data() + start, floats(work.plane.data() + start));
  }
  series_.sum_kept(work.plane.data());
}

double CoherentPlane::likeness(const CoherentPlaneWork& work) const {
  double sum = 0;
  for (int r = 0; r < rows(); ++r) {
    const std::ptrdiff_t start = static_cast<std::ptrdiff_t>(r) * pitch();
    const float *a = work.amplitude[0].data() + start, *b = work.amplitude[1].data() + start;
    for (int c = 0; c < columns(); ++c) sum += static_cast<double>(a[c]) * static_cast<double>(b[c]);
  }
  return sum * static_cast<double>(work.scale[0]) * static_cast<double>(work.scale[1]);
}

std::array<double, 2> CoherentPlane::coherence_error(const std::array<CoherenceDecay, 2>& decays,
                                                     double row_spacing, double column_spacing,
                                                     int window_rows, int window_columns,
                                                     CoherentPlaneWork& work) const {
  for (std::size_t i = 0; i < work.plane.size(); ++i) {
    const float a = work.amplitude[0][i] * work.scale[0], b = work.amplitude[1][i] * work.scale[1];
    work.plane[i] = {a * a, b * b};
  }
  series_.sum(work.plane.data());
  std::array<double, 2> largest = {};
  for (int r = 0; r < window_rows; ++r) {
    for (int c = 0; c < window_columns; ++c) {
      const std::complex<double> found = work.plane[static_cast<std::size_t>(r * pitch() + c)];
      const auto wanted = [&](std::size_t k) {
        return root_coherence(decays[k], c * column_spacing, r * row_spacing);
      };
      largest[0] = std::max(largest[0], std::abs(found.real() - wanted(0)));
      largest[1] = std::max(largest[1], std::abs(found.imag() - wanted(1)));
    }
  }
  return largest;
}

void draw_noise(const Noise& noise, std::size_t count, std::complex<float>* values) {
  if (noise.amplitudes == Amplitudes::phases_only) {
    unit_phases(noise.seed, noise.stream, noise.bin, count, values);
    return;
  }
  complex_gaussians(noise.seed, noise.stream, noise.bin, count, values);
  if (noise.shared == 0) return;
  std::vector<std::complex<float>> other(count);
  complex_gaussians(noise.seed, noise.other, noise.bin, count, other.data());
  const auto shared = static_cast<float>(noise.shared), own = std::sqrt(1 - shared * shared);
  for (std::size_t i = 0; i < count; ++i) values[i] = own * values[i] + shared * other[i];
}

}  // namespace tremula
