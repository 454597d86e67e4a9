#include "tremula/numerics/random.hpp"

#include <cmath>
#include <numbers>

#include <Random123/philox.h>

namespace tremula {
namespace {

struct Words {
  std::uint64_t first, second;
};

Words words_at(const RandomAddress& a) {
  const r123::Philox4x32::ctr_type counter = {{static_cast<std::uint32_t>(a.place),
                                               static_cast<std::uint32_t>(a.place >> 32), a.bin,
                                               static_cast<std::uint32_t>(a.stream)}};
  const r123::Philox4x32::key_type key = {
      {static_cast<std::uint32_t>(a.seed), static_cast<std::uint32_t>(a.seed >> 32)}};
  const auto block = r123::Philox4x32{}(counter, key);
  return {(std::uint64_t{block[1]} << 32) | block[0], (std::uint64_t{block[3]} << 32) | block[2]};
}

double to_unit_interval(std::uint64_t word) { return static_cast<double>(word >> 11) * 0x1p-53; }

}  // namespace

double uniform(const RandomAddress& address) { return to_unit_interval(words_at(address).first); }

std::complex<double> complex_gaussian(const RandomAddress& address) {
  const Words words = words_at(address);
  // 1 - u is in (0, 1]: the logarithm is finite. |w|^2 is exponential with mean 1.
  const double magnitude = std::sqrt(-std::log(1.0 - to_unit_interval(words.first)));
  return std::polar(magnitude, 2 * std::numbers::pi * to_unit_interval(words.second));
}

}  // namespace tremula
