#include "tremula/reference/response_as_printed.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

#include "tremula/base/error.hpp"
#include "tremula/dynamics/response.hpp"
#include "tremula/numerics/fft.hpp"
#include "tremula/numerics/random.hpp"
#include "tremula/reference/response_variance.hpp"

namespace tremula {
namespace {

using std::numbers::pi;

Modes two_modes() {
  Modes modes;
  modes.frequency = Eigen::Vector2d(0.7, 1.9);
  modes.shapes = Eigen::MatrixXd::Zero(6, 2);
  return modes;
}

Eigen::MatrixXcd random_forces(int bins) {
  Eigen::MatrixXcd forces(bins, 2);
  for (Eigen::Index i = 0; i < forces.size(); ++i) {
    forces.data()[i] = complex_gaussian({1, RandomStream::test, 2, static_cast<std::uint64_t>(i)});
  }
  return forces;
}

TEST(RespondAsPrinted, IsTheSumOfTheSeriesOfEquation7) {
  const TimeAxis axis{7, 40};
  const Modes modes = two_modes();
  const Eigen::MatrixXcd forces = random_forces(axis.bin_count());
  for (const Damping& damping : {Damping{.ratio = 0.03}, Damping{.mass_proportional = 0.4}}) {
    const Eigen::MatrixXd coordinates = respond_as_printed(modes, forces, axis, damping);
    for (int p = 0; p < 40; ++p) {
      const double t = p * axis.period / 40;
      for (int r = 0; r < 2; ++r) {
        const double omega_r = 2 * pi * modes.frequency[r];
        const double rate = damping.mass_proportional.value_or(2 * 0.03 * omega_r);
        double sum = forces(0, r).real() / (omega_r * omega_r);
        for (int k = 1; k <= 20; ++k) {
          const double omega = 2 * pi * k / axis.period;
          std::complex<double> y =
              forces(k, r) / std::complex(omega_r * omega_r - omega * omega, rate * omega);
          if (k == 20) y = y.real() / 2;  // the bin at the Nyquist frequency stands for itself alone
          sum += 2 * (y * std::polar(1.0, omega * t)).real();
        }
        EXPECT_NEAR(coordinates(p, r), sum, 1e-12) << "sample " << p << ", mode " << r;
      }
    }
  }
}

TEST(RespondAsPrinted, SolvesTheEquationOfMotionOfTheOscillator) {
  // y'' + c y' + omega_r^2 y = f for a force of one frequency, in the middle of the loop.
  const TimeAxis axis{10, 2000};
  Eigen::MatrixXcd forces = Eigen::MatrixXcd::Zero(axis.bin_count(), 2);
  forces(6, 0) = std::complex(0.3, -0.2);
  const Eigen::MatrixXd coordinates = respond_as_printed(two_modes(), forces, axis, {.ratio = 0.05});
  const double omega_r = 2 * pi * 0.7, h = axis.period / 2000;
  for (int p = 1; p < 1999; p += 97) {
    const double before = coordinates(p - 1, 0), here = coordinates(p, 0), after = coordinates(p + 1, 0);
    const double force = 2 * (forces(6, 0) * std::polar(1.0, 2 * pi * 6 * p * h / axis.period)).real();
    const double left = (after - 2 * here + before) / (h * h) +
                        2 * 0.05 * omega_r * (after - before) / (2 * h) + omega_r * omega_r * here;
    EXPECT_NEAR(left, force, 2e-4) << "sample " << p;
  }
}

// The cascade, sampled, without damping between the modes.
TEST(RespondAsPrinted, IsWhatTheCascadeGivesWhereBinsAreSampled) {
  const TimeAxis axis{7, 40};
  const Modes modes = two_modes();
  const Damping damping{.ratio = 0.03};
  const Eigen::MatrixXd participation = Eigen::MatrixXd::Random(9, 2);
  PointWind wind;
  wind.mean = Eigen::Matrix3Xd::Zero(3, 3);
  wind.velocity = [](int bin, int) {
    Eigen::Matrix3Xcd velocity(3, 3);
    for (Eigen::Index i = 0; i < velocity.size(); ++i) {
      velocity.data()[i] = complex_gaussian(
          {1, RandomStream::test, static_cast<std::uint32_t>(bin), static_cast<std::uint64_t>(i)});
    }
    return velocity;
  };
  const ModalSystem system{modes.omega(), structural_damping(damping, modes.omega()).asDiagonal()};
  const BinTransfer transfer(system, axis, Transfer::sampled);
  const Eigen::MatrixXd found =
      samples_from_half_spectra(respond(transfer, participation, axis, wind), axis.sample_count);
  const Eigen::MatrixXcd forces =
      project_loads(participation, axis, [&](int bin) { return wind.velocity(bin, 0); });
  const Eigen::MatrixXd wanted = respond_as_printed(modes, forces, axis, damping);
  EXPECT_LT((found - wanted).norm(), 1e-13 * wanted.norm());
}

TEST(RespondAsPrinted, RefusesDampingThatIsNotAboveZero) {
  const TimeAxis axis{7, 8};
  for (const double bad : {0.0, -0.1, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(respond_as_printed(two_modes(), random_forces(5), axis, {.ratio = bad}), InputError);
    EXPECT_THROW(respond_as_printed(two_modes(), random_forces(5), axis, {.mass_proportional = bad}),
                 InputError);
  }
}

TEST(ProjectLoads, MultipliesEveryBinByTheParticipation) {
  const TimeAxis axis{4, 12};
  const Eigen::MatrixXd participation = Eigen::MatrixXd::Random(9, 3);
  const auto wind = [](int bin) -> Eigen::Matrix3Xcd {
    return Eigen::Matrix3Xcd::Constant(3, 3, std::complex<double>(bin, 1)) +
           Eigen::Matrix3Xcd::Identity(3, 3);
  };
  const Eigen::MatrixXcd forces = project_loads(participation, axis, wind);
  ASSERT_EQ(forces.rows(), 7);
  for (int bin = 0; bin < 7; ++bin) {
    const Eigen::VectorXcd wanted =
        participation.cast<std::complex<double>>().transpose() * Eigen::VectorXcd(wind(bin).reshaped());
    EXPECT_LT((forces.row(bin).transpose() - wanted).norm(), 1e-13 * wanted.norm());
  }
}

TEST(ResponseVariance, OfWhiteNoiseIsTheClosedFormOfEveryOscillator) {
  // sigma^2 = S_0 / (8 zeta omega^3), S_0 one-sided per Hz; what lies beyond the highest frequency is left
  // out.
  const Eigen::Vector2d omega = 2 * pi * Eigen::Vector2d(0.83, 2.1), zeta(0.004, 0.07);
  const ModalSystem system{omega, (2 * zeta.cwiseProduct(omega)).asDiagonal()};
  const Eigen::Matrix2d force_spectrum = Eigen::Vector2d(1, 3).asDiagonal();
  const Eigen::VectorXd variance = response_variance(
      system, force_spectrum, [](double) { return 1.0; }, 0, 2e4);
  for (int r = 0; r < 2; ++r) {
    const double closed = force_spectrum(r, r) / (8 * zeta[r] * std::pow(omega[r], 3));
    EXPECT_NEAR(variance[r] / closed, 1, 1e-6) << r;
  }
}

TEST(ResponseVariance, OfModesThatDampEachOtherIsAFineSum) {
  Eigen::Matrix2d damping, spectrum;
  damping << 0.3, 0.15, 0.15, 0.4;
  spectrum << 1, 0.6, 0.6, 2;
  const ModalSystem system{2 * pi * Eigen::Vector2d(0.61, 0.64), damping};
  const auto power = [](double omega) { return std::pow(1 + 3 * omega, -5.0 / 3); };
  Eigen::Vector2d wanted = Eigen::Vector2d::Zero();
  const double step = 1e-3, lowest = 1, highest = 9;
  for (int i = 0; i < 8000; ++i) {
    const double omega = lowest + (i + 0.5) * step;
    const Eigen::MatrixXcd transfer = transfer_function(system, omega);
    wanted += step / (2 * pi) * power(omega) * (transfer * spectrum * transfer.adjoint()).diagonal().real();
  }
  const Eigen::VectorXd found = response_variance(system, spectrum, power, lowest, highest);
  EXPECT_LT((found - wanted).norm(), 1e-5 * wanted.norm());
}

}  // namespace
}  // namespace tremula
