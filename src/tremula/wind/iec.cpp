#include "tremula/wind/iec.hpp"

#include "tremula/base/error.hpp"

#include <algorithm>
#include <string>

namespace tremula {

IecEdition iec_edition(int number) {
  if (number != 2 && number != 3)
    throw InputError("edition of IEC 61400-1", std::to_string(number), "2 or 3");
  return static_cast<IecEdition>(number);
}

double turbulence_scale(IecEdition edition, double hub_height) {
  return 0.7 * std::min(hub_height, edition == IecEdition::second ? 30.0 : 60.0);
}

IecCoherence iec_coherence(IecEdition edition, double hub_height) {
  const double scale = turbulence_scale(edition, hub_height);
  return edition == IecEdition::second ? IecCoherence{8.8, 3.5 * scale} : IecCoherence{12, 8.1 * scale};
}

}  // namespace tremula
