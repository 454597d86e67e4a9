#include "tremula/structure/uniform_beam.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/error.hpp"

#include <cmath>
#include <numbers>
#include <string>

namespace tremula {
namespace {

using std::numbers::pi;

void check_mode(int mode) {
  constexpr int most = 1000000;
  if (mode >= 1 && mode <= most) return;
  throw InputError("mode of a beam", std::to_string(mode), "1 to 1000000");
}

void check_place(double place) {
  if (place >= 0 && place <= 1) return;
  throw InputError("place on a beam", std::to_string(place), "0 (clamp) to 1 (free end)");
}

// lambda = (r - 1/2) pi + excess: sine and cosine of lambda come from the small excess, without the rounding
// of a large angle.
struct Root {
  double lambda, sine, cosine;
};

Root root_of(int mode) {
  const double near = (mode - 0.5) * pi, sign = mode % 2 == 1 ? 1 : -1;
  double excess = 0;
  for (int i = 0; i < 8; ++i) {  // Newton on sin(excess) = sign/cosh(lambda)
    const double lambda = near + excess, secant = 1 / std::cosh(lambda);
    excess -= (std::sin(excess) - sign * secant) / (std::cos(excess) + sign * secant * std::tanh(lambda));
  }
  return {near + excess, sign * std::cos(excess), -sign * std::sin(excess)};
}

// 1 - eta times sinh(lambda) e^-lambda 2, so that (1 - eta) sinh(z) = rest (e^(z - lambda) - e^(-z -
// lambda)).
double rest_of(const Root& root) {
  const double small = std::exp(-root.lambda);
  return (root.sine - root.cosine - small) / (1 - small * small + 2 * small * root.sine);
}

double eta_of(const Root& root) {
  const double small = std::exp(-root.lambda);
  return (1 + small * small + 2 * small * root.cosine) / (1 - small * small + 2 * small * root.sine);
}

}  // namespace

double clamped_free_root(int mode) {
  check_mode(mode);
  return root_of(mode).lambda;
}

double clamped_free_eta(int mode) {
  check_mode(mode);
  return eta_of(root_of(mode));
}

double natural_omega(const UniformBeam& beam, int mode) {
  check_positive("length of a beam", beam.length);
  check_positive("bending stiffness of a beam", beam.bending_stiffness);
  check_positive("mass per length of a beam", beam.mass_per_length);
  const double wave_number = clamped_free_root(mode) / beam.length;
  return wave_number * wave_number * std::sqrt(beam.bending_stiffness / beam.mass_per_length);
}

// cosh z - eta sinh z = e^-z + (1 - eta) sinh z, and its derivatives.
BeamShape clamped_free_shape(int mode, double place) {
  check_mode(mode);
  check_place(place);
  const Root root = root_of(mode);
  const double lambda = root.lambda, eta = eta_of(root), rest = rest_of(root), z = lambda * place;
  const double falling = std::exp(-z);
  const double rising = rest * std::exp(z - lambda), left = rest * std::exp(-z - lambda);
  const double even = falling + rising - left, odd = -falling + rising + left;
  const double cosine = std::cos(z), sine = std::sin(z);
  return {even - cosine + eta * sine, lambda * (odd + sine + eta * cosine),
          lambda * lambda * (even + cosine - eta * sine),
          lambda * lambda * lambda * (odd - sine - eta * cosine)};
}

double clamped_free_mean(int mode) {
  check_mode(mode);
  const Root root = root_of(mode);
  return 2 * eta_of(root) / root.lambda;
}

BeamShape fundamental_polynomial(double place) {
  check_place(place);
  const double x = place, rest = 1 - x;
  return {x * x * (x * x - 4 * x + 6) / 3, 4 * x * (x * x - 3 * x + 3) / 3, 4 * rest * rest, -8 * rest};
}

double clamp_shear(const UniformBeam& beam, int mode) {
  check_positive("length of a beam", beam.length);
  check_positive("bending stiffness of a beam", beam.bending_stiffness);
  check_mode(mode);
  const Root root = root_of(mode);
  return -2 * eta_of(root) * beam.bending_stiffness * std::pow(root.lambda / beam.length, 3);
}

double youngs_modulus_of(double frequency, double length, double density, const RoundSection& section) {
  check_positive("frequency of a branch", frequency);
  check_positive("length of a branch", length);
  check_positive("density of a branch", density);
  check_positive("area of a section", section.area);
  check_positive("second moment of a section", section.second_moment);
  const double omega = 2 * pi * frequency, root = clamped_free_root(1) / length;
  return omega * omega / (root * root * root * root) * density * (section.area / section.second_moment);
}

double stiffness_damping_of(double damping_time, double frequency) {
  check_positive("damping time of a branch", damping_time);
  check_positive("frequency of a branch", frequency);
  const double omega = 2 * pi * frequency;
  return 2 / (damping_time * omega * omega);
}

}  // namespace tremula
