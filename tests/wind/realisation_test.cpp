// The wind of a seed is one, whatever does the Fourier transforms and on whatever machine: planes of the same
// size, the same random numbers in the same places, and sums of them that agree to the rounding of float. The
// numbers here were printed by the build with FFTW on x86-64; the build with KissFFT runs the same test.
#include <gtest/gtest.h>

#include <array>
#include <complex>

#include "tremula/numerics/fft.hpp"
#include "tremula/numerics/random.hpp"
#include "tremula/wind/synthesis.hpp"
#include "tremula/wind/turbulent_wind_at_points.hpp"

namespace tremula {
namespace {

constexpr double rounding = 2e-5;  // of sums of thousands of floats of order 1 m/s

TEST(Realisation, HasPlanesOfSizesThatDependOnNeitherLibraryNorMachine) {
  constexpr int sizes[][2] = {{12, 12},   {17, 24},   {25, 32},   {33, 40},   {41, 48},
                              {49, 56},   {57, 64},   {65, 80},   {81, 96},   {97, 112},
                              {113, 128}, {129, 160}, {161, 192}, {193, 224}, {225, 256}};
  for (const auto& [least, length] : sizes) EXPECT_EQ(fast_length(least), length) << least;
}

TEST(Realisation, DrawsTheSameNumbers) {
  std::array<std::complex<float>, 3> drawn;
  complex_gaussians(1, RandomStream::wind_u, 5, drawn.size(), drawn.data());
  // To the last bit: Philox in integers, logarithm and sine in float without fused multiply-add.
  EXPECT_EQ(drawn[0], (std::complex<float>(0x1.035ccap-2F, -0x1.0ea3b2p-2F)));
  EXPECT_EQ(drawn[2], (std::complex<float>(-0x1.f3b2e4p-1F, 0x1.42a274p-3F)));
  const std::complex<double> one = complex_gaussian({1, RandomStream::wind_u, 5, 2});
  EXPECT_NEAR(one.real(), 0.80213533681499449, 1e-15);
  EXPECT_NEAR(one.imag(), 0.0063751565583246199, 1e-15);
}

TEST(Realisation, OfAFieldIsTheSameToRounding) {
  const WindGrid grid{.y_count = 26,
                      .z_count = 26,
                      .step_count = 64,
                      .y_spacing = 2,
                      .z_spacing = 2,
                      .bottom = 2,
                      .step = 0.5};
  SynthesisReport report;
  const WindField field = synthesise_wind(turbulent_wind({.speed = 8}, 0.2), grid, {}, &report);
  EXPECT_EQ(report.largest_rows, 56);
  EXPECT_EQ(report.largest_columns, 56);
  const auto at = [&](std::size_t component, std::size_t step, std::size_t row, std::size_t column) {
    return static_cast<double>(field.velocity[component][(step * 26 + row) * 26 + column]);
  };
  EXPECT_NEAR(at(0, 0, 0, 0), 3.42519, rounding);
  EXPECT_NEAR(at(0, 17, 4, 12), 7.26168, rounding);
  EXPECT_NEAR(at(1, 40, 25, 25), -0.23176, rounding);
  EXPECT_NEAR(at(2, 63, 13, 3), -0.71032, rounding);
}

TEST(Realisation, AtPointsIsTheSameToRounding) {
  Eigen::Matrix3Xd points(3, 40);
  for (int k = 0; k < 40; ++k) points.col(k) << 0.1 * k, 0.25 * ((7 * k) % 40), 1 + 0.25 * k;
  const TurbulentWindAtPoints wind(turbulent_wind({.speed = 6}, 0.2), {20, 400}, points);
  const auto expect_plane = [&](int bin, int rows, int columns) {
    EXPECT_EQ(wind.plane(bin).rows, rows) << bin;
    EXPECT_EQ(wind.plane(bin).columns, columns) << bin;
  };
  expect_plane(1, 8, 8);
  expect_plane(30, 56, 64);
  expect_plane(150, 64, 64);
  const auto expect_velocity = [&](int bin, int point, int component, std::complex<double> wanted) {
    const std::complex<double> found = wind.velocity(bin)(component, point);
    EXPECT_NEAR(found.real(), wanted.real(), rounding) << bin;
    EXPECT_NEAR(found.imag(), wanted.imag(), rounding) << bin;
  };
  expect_velocity(1, 7, 0, {-0.53767, 0.05905});
  expect_velocity(30, 21, 1, {-0.00555, 0.03840});
  expect_velocity(150, 39, 2, {0.00201, -0.00060});
}

}  // namespace
}  // namespace tremula
