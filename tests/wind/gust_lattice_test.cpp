#include "tremula/wind/gust_lattice.hpp"

#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

namespace tremula {
namespace {

using Values = std::vector<std::complex<float>>;

Values draw(std::uint32_t bin, const CoherenceDecay& decay, const std::vector<double>& across,
            const std::vector<double>& up) {
  LatticeWork work;
  Values values(across.size());
  draw_on_lattice({.seed = 5, .bin = bin}, decay, across, up, work, values.data());
  return values;
}

// Places all over the world, not those of one cell.
std::array<double, 2> somewhere(std::uint32_t i) {
  const auto [y, z] = two_uniforms({.seed = 77, .place = i});
  return {2000 * y - 1000, 60 * z};
}

double mean_error(double decays_apart, double decay) {
  constexpr std::uint32_t places = 400;
  double sum = 0;
  for (std::uint32_t i = 0; i < places; ++i) {
    const std::array<double, 2> place = somewhere(i);
    const double angle = 2 * std::numbers::pi * uniform({.seed = 78, .place = i});
    const double r = decays_apart / decay;
    sum += lattice_coherence({decay, decay}, place,
                             {place[0] + r * std::cos(angle), place[1] + r * std::sin(angle)}) -
           std::exp(-decays_apart);
  }
  return sum / places;
}

TEST(GustLattice, HasTheCoherenceOfTheModelWithinTwoHundredthsAndNearlySoWhereItIsCusped) {
  for (const double decay : {0.013, 0.4, 1.5}) {
    for (const double r : {0.45, 0.7, 1.0, 1.6, 2.5, 4.0, 6.0})
      EXPECT_NEAR(mean_error(r, decay), 0, 0.02) << r;
    for (const double r : {0.02, 0.1, 0.2, 0.3}) EXPECT_NEAR(mean_error(r, decay), 0, 0.08) << r;
  }
}

TEST(GustLattice, IsItselfAtAPlaceAndForgetsWhatIsFar) {
  EXPECT_NEAR(lattice_coherence({0.3, 0.5}, {12.3, 4.5}, {12.3, 4.5}), 1, 1e-12);
  EXPECT_NEAR(lattice_coherence({0.3, 0.5}, {12.3, 4.5}, {112.3, 4.5}), 0, 1e-9);
  EXPECT_NEAR(lattice_coherence({0.3, 0}, {12.3, 4.5}, {12.3, 88}), 1, 1e-12);
}

TEST(GustLattice, OfManyDrawsHasTheCovarianceOfItsClosedForm) {
  const CoherenceDecay decay{0.5, 0.8};
  const std::vector<double> across{3.3, 3.6, 4.4, -2, 900}, up{2, 2.4, 5, 2.1, 30};
  constexpr std::uint32_t draws = 20000;
  Eigen::MatrixXcd covariance = Eigen::MatrixXcd::Zero(5, 5);
  for (std::uint32_t bin = 0; bin < draws; ++bin) {
    const Values values = draw(bin, decay, across, up);
    const Eigen::VectorXcd x =
        Eigen::Map<const Eigen::VectorXcf>(values.data(), 5).cast<std::complex<double>>();
    covariance += x * x.adjoint() / draws;
  }
  const double standard_error = 1 / std::sqrt(draws);
  for (int i = 0; i < 5; ++i) {
    for (int j = 0; j < 5; ++j) {
      const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
      const double wanted = lattice_coherence(decay, {across[a], up[a]}, {across[b], up[b]});
      EXPECT_LT(std::abs(covariance(i, j) - wanted), 4.5 * standard_error) << i << " " << j;
    }
  }
}

TEST(GustLattice, IsTheSameAtAPlaceWhoeverElseIsAsked) {
  const CoherenceDecay decay{2, 3};
  const std::vector<double> one{41.7}, at{3.2};
  std::vector<double> many{41.7}, at_many{3.2}, far{41.7, -3e4, 2e4}, at_far{3.2, 100, 1};
  for (int i = 0; i < 500; ++i) {
    many.push_back(35 + 0.02 * i);
    at_many.push_back(0.01 * i);
  }
  for (std::uint32_t bin = 1; bin < 20; ++bin) {
    const std::complex<float> alone = draw(bin, decay, one, at)[0];
    EXPECT_LT(std::abs(draw(bin, decay, many, at_many)[0] - alone), 1e-6F);
    EXPECT_LT(std::abs(draw(bin, decay, far, at_far)[0] - alone), 1e-6F);
  }
}

TEST(GustLattice, IsContinuousFromCellToCellAndAcrossTheOrigin) {
  std::vector<double> across, up;
  for (int i = -2000; i <= 2000; ++i) {
    across.push_back(0.001 * i);
    up.push_back(2 + 0.0007 * i);
  }
  const Values values = draw(3, {1, 1}, across, up);
  for (std::size_t i = 1; i < values.size(); ++i) EXPECT_LT(std::abs(values[i] - values[i - 1]), 0.06F) << i;
}

TEST(GustLattice, OfNoDecayIsOneGustForTheWorld) {
  const Values values = draw(4, {0, 0}, {-5e5, 0, 3, 7e5}, {0, 1, 80, 3});
  for (const std::complex<float>& value : values) EXPECT_LT(std::abs(value - values[0]), 1e-6F);
}

TEST(GustLattice, WithoutCoherenceGivesEveryMillimetreItsOwn) {
  Values values(3);
  draw_at_places({.seed = 5, .bin = 2}, std::vector<double>{1, 1.001, 1}, std::vector<double>{2, 2, 2},
                 values.data());
  EXPECT_EQ(values[0], values[2]);
  EXPECT_NE(values[0], values[1]);
}

}  // namespace
}  // namespace tremula
