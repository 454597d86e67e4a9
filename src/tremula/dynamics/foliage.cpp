#include "tremula/dynamics/foliage.hpp"

#include "tremula/base/error.hpp"

#include <cmath>
#include <string>

namespace tremula {

void check_foliage(const FoliageLaw& law) {
  constexpr double of_a_cone = -4.0 / 3;
  if (!(law.vogel_exponent >= of_a_cone && law.vogel_exponent <= 0))
    throw InputError("Vogel exponent of foliage", std::to_string(law.vogel_exponent), "-4/3 to 0");
  if (!std::isfinite(law.folding_speed) || law.folding_speed <= 0)
    throw InputError("folding speed", std::to_string(law.folding_speed), "a number above 0");
}

double folding_factor(const FoliageLaw& law, double speed) {
  const double x = speed / law.folding_speed;
  return std::pow(1 + x * x, law.vogel_exponent / 2);
}

double folding_slope(const FoliageLaw& law, double speed) {
  const double x = speed / law.folding_speed;
  return law.vogel_exponent * x * x / (1 + x * x);
}

}  // namespace tremula
