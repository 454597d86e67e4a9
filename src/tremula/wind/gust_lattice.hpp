// A homogeneous random field of unit variance on the whole plane across the wind, without an edge: what it
// is at a place depends on the seed and the place alone, not on who else asks. The part of the wind of a
// scene that works in space, one frequency bin at a time.
//
// A root-coherence exp(-r), r in decay lengths, is a mean over Gaussians (r^2 under the Laplace transform of
// a stable law):
//
//   exp(-r) = integral over s > 0 of sqrt(2/pi) exp(-s^2/2) exp(-r^2/(2 s^2)) ds
//
// Each octave of s is noise on a lattice of the world, as wide as 2^j m, through cubic B-splines, whose
// covariance is nearly that Gaussian. Noise has an address, so no lattice has an end; variances are exactly
// 1 everywhere. Octaves begin where the field has no structure, at a fifth of a decay length, or at
// finest_lattice.
#pragma once

#include "tremula/numerics/random.hpp"
#include "tremula/wind/coherence.hpp"

#include <array>
#include <complex>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

namespace tremula {

// What is finer is not resolved: gusts of 1/8 m are below what anything feels as a whole.
inline constexpr double finest_lattice = 0.125;  // [m]

struct LatticeNoise {
  std::uint64_t seed = 1;
  RandomStream stream = RandomStream::lattice_u;
  std::uint32_t bin = 0;
};

// What one thread needs.
struct LatticeWork {
  std::vector<std::complex<float>> nodes;
  std::unordered_map<std::uint64_t, std::array<std::complex<float>, gaussian_block>> blocks;
};

// Values (count) at places [m] across and up. decay finite; 0 in a direction: the same along it.
void draw_on_lattice(const LatticeNoise& noise, const CoherenceDecay& decay, std::span<const double> across,
                     std::span<const double> up, LatticeWork& work, std::complex<float>* values);

// Without any coherence: every place, to a millimetre, for itself.
void draw_at_places(const LatticeNoise& noise, std::span<const double> across, std::span<const double> up,
                    std::complex<float>* values);

// The root-coherence that it has at a place and at another, in closed form: what exp(-r) has become.
double lattice_coherence(const CoherenceDecay& decay, const std::array<double, 2>& place,
                         const std::array<double, 2>& other);

}  // namespace tremula
