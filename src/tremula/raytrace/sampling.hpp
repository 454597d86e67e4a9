// Points that fill the unit square evenly, and what they are turned into. Every number has an address: pixel,
// sample, dimension; so that a picture is the same however its pixels are shared out.
#pragma once

#include "tremula/base/noise.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include <Eigen/Core>

namespace tremula {

inline std::uint32_t reverse_bits(std::uint32_t x) {
  x = ((x >> 1) & 0x55555555U) | ((x & 0x55555555U) << 1);
  x = ((x >> 2) & 0x33333333U) | ((x & 0x33333333U) << 2);
  x = ((x >> 4) & 0x0f0f0f0fU) | ((x & 0x0f0f0f0fU) << 4);
  return (x << 24) | ((x & 0xff00U) << 8) | ((x >> 8) & 0xff00U) | (x >> 24);
}

// Owen's scrambling of a number whose bits are reversed: a bit is flipped by a hash of those below it
// (Burley, Practical hash-based Owen scrambling, JCGT 9 (4), 2020, after Laine and Karras; constants by
// Vegdahl).
inline std::uint32_t scramble_reversed(std::uint32_t x, std::uint32_t seed) {
  x ^= x * 0x3d20adeaU;
  x += seed;
  x *= (seed >> 16) | 1U;
  x ^= x * 0x05526c56U;
  x ^= x * 0x53a22864U;
  return x;
}

// The bits, reversed, of the second dimension of Sobol's sequence: its matrix is Pascal's triangle mod 2, by
// Lucas a sum over the places whose binary digits hold those of a place.
inline std::uint32_t pascal(std::uint32_t x) {
  x ^= (x & 0xaaaaaaaaU) >> 1;
  x ^= (x & 0xccccccccU) >> 2;
  x ^= (x & 0xf0f0f0f0U) >> 4;
  x ^= (x & 0xff00ff00U) >> 8;
  return x ^ (x >> 16);
}

inline float unit_of(std::uint32_t bits) { return static_cast<float>(bits >> 8) * 0x1p-24F; }  // [0, 1)

// Pairs of Sobol's first two dimensions, each pair shuffled and scrambled by itself. The first 2^k samples of
// a pixel fill every elementary interval of area 2^-k once.
class Sampler {
 public:
  Sampler(std::uint64_t seed, std::uint32_t pixel, std::uint32_t sample)
      : seed_(hash(pixel ^ hash(static_cast<std::uint32_t>(seed) ^
                                hash(static_cast<std::uint32_t>(seed >> 32) + 0x68bc21ebU)))),
        sample_(reverse_bits(sample)) {}

  Eigen::Vector2f pair() {
    const std::uint32_t seed = hash(seed_ + 0x9e3779b9U * ++dimension_);
    const std::uint32_t index = reverse_bits(scramble_reversed(sample_, seed));
    return {unit_of(reverse_bits(scramble_reversed(index, seed * 0x2c1b3c6dU + 1))),
            unit_of(reverse_bits(scramble_reversed(pascal(index), seed * 0x297a2d39U + 2)))};
  }
  float one() {
    const std::uint32_t seed = hash(seed_ + 0x9e3779b9U * ++dimension_);
    const std::uint32_t index = reverse_bits(scramble_reversed(sample_, seed));
    return unit_of(reverse_bits(scramble_reversed(index, seed * 0x2c1b3c6dU + 1)));
  }
  // A number for a ray that is shot now: another after every pair() and one(), and none of theirs is spent.
  std::uint32_t ticket() const {
    return hash(hash(sample_ ^ 0x7f4a7c15U) ^ (seed_ + 0x9e3779b9U * dimension_));
  }

 private:
  std::uint32_t seed_, sample_, dimension_ = 0;
};

inline Eigen::Vector2f to_disc(const Eigen::Vector2f& random) {  // Shirley and Chiu 1997
  const float a = 2 * random.x() - 1, b = 2 * random.y() - 1;
  if (a == 0 && b == 0) return Eigen::Vector2f::Zero();
  constexpr float quarter = std::numbers::pi_v<float> / 4;
  const bool wide = std::abs(a) > std::abs(b);
  const float radius = wide ? a : b, angle = wide ? quarter * b / a : quarter * (2 - a / b);
  return radius * Eigen::Vector2f(std::cos(angle), std::sin(angle));
}

// Two unit vectors at right angles to a third (Duff et al. 2017).
struct LocalAxes {
  Eigen::Vector3f x, y, z;

  explicit LocalAxes(const Eigen::Vector3f& n) : z(n) {
    const float sign = std::copysign(1.0F, n.z());
    const float a = -1 / (sign + n.z()), b = n.x() * n.y() * a;
    x = {1 + sign * n.x() * n.x() * a, sign * b, -sign * n.x()};
    y = {b, sign + n.y() * n.y() * a, -n.y()};
  }
  Eigen::Vector3f out(const Eigen::Vector3f& v) const { return v.x() * x + v.y() * y + v.z() * z; }
  Eigen::Vector3f in(const Eigen::Vector3f& v) const { return {v.dot(x), v.dot(y), v.dot(z)}; }
};

// Within the hemisphere of +z, with density cos / pi.
inline Eigen::Vector3f to_cosine_lobe(const Eigen::Vector2f& random) {
  const Eigen::Vector2f disc = to_disc(random);
  return {disc.x(), disc.y(), std::sqrt(std::max(0.0F, 1 - disc.squaredNorm()))};
}

inline Eigen::Vector3f to_sphere(const Eigen::Vector2f& random) {
  const float z = 1 - 2 * random.x(), r = std::sqrt(std::max(0.0F, 1 - z * z));
  const float angle = 2 * std::numbers::pi_v<float> * random.y();
  return {r * std::cos(angle), r * std::sin(angle), z};
}

// Evenly within the cone about `axis` whose half angle has this cosine.
inline Eigen::Vector3f to_cone(const Eigen::Vector2f& random, const LocalAxes& axes, float cosine) {
  const Eigen::Vector2f disc = to_disc(random);
  const float share = disc.squaredNorm(), down = share * (1 - cosine);  // 1 - z
  const float stretch = share > 0 ? std::sqrt(down * (2 - down) / share) : 0;
  return axes.out({disc.x() * stretch, disc.y() * stretch, 1 - down});
}

// From [0, 1) to (-1, 1) with the density of a tent: how far a sample lies from the middle of its pixel.
inline float to_tent(float random) {
  return random < 0.5F ? std::sqrt(2 * random) - 1 : 1 - std::sqrt(2 - 2 * random);
}

}  // namespace tremula
