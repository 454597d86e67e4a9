#include "tremula/wind/coherence.hpp"

#include "tremula/base/error.hpp"
#include "tremula/base/number_text.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace tremula {
namespace {

constexpr std::pair<const char*, CoherenceKind> names[] = {
    {"shinya-fournier", CoherenceKind::shinya_fournier},
    {"davenport", CoherenceKind::davenport},
    {"iec", CoherenceKind::iec},
    {"none", CoherenceKind::none}};

}  // namespace

CoherenceKind coherence_named(const std::string& name) {
  for (const auto& [known, kind] : names) {
    if (name == known) return kind;
  }
  throw InputError("coherence", name, "shinya-fournier, davenport, iec or none");
}

std::string name_of(CoherenceKind kind) {
  for (const auto& [name, known] : names) {
    if (kind == known) return name;
  }
  return {};
}

Coherence coherence_model(CoherenceKind kind, const MeanWind& mean, IecEdition edition) {
  Coherence coherence{.kind = kind, .speed = mean.speed};
  if (kind == CoherenceKind::davenport) {
    coherence.decay_y = {16, 16, 16};
    coherence.decay_z = {10, 10, 10};
  }
  const IecCoherence of_edition = iec_coherence(edition, mean.reference_height);
  coherence.iec_decay = of_edition.decay;
  coherence.iec_length = of_edition.length;
  return coherence;
}

void check_coherence(const Coherence& coherence) {
  const auto check = [](bool good, const char* what, double value, const char* wanted) {
    if (!good || !std::isfinite(value)) throw InputError(what, number_text(value), wanted);
  };
  check(coherence.speed >= 0, "speed of the coherence", coherence.speed, "0 m/s or more");
  for (std::size_t c = 0; c < 3; ++c) {
    check(coherence.decay_y[c] >= 0, "coherence decay across the wind", coherence.decay_y[c], "0 or more");
    check(coherence.decay_z[c] >= 0, "coherence decay with height", coherence.decay_z[c], "0 or more");
  }
  check(coherence.iec_decay >= 0, "coherence decay", coherence.iec_decay, "0 or more");
  check(coherence.iec_length > 0, "coherence length", coherence.iec_length, "above 0 m");
}

CoherenceDecay coherence_decay(const Coherence& coherence, int component, double frequency) {
  constexpr double infinite = std::numeric_limits<double>::infinity();
  const auto c = static_cast<std::size_t>(component);
  if (coherence.speed <= 0) return {infinite, infinite};
  const double wave_number = frequency / coherence.speed;  // [1/m]
  switch (coherence.kind) {
    case CoherenceKind::shinya_fournier:
    case CoherenceKind::davenport:
      return {coherence.decay_y[c] * wave_number, coherence.decay_z[c] * wave_number};
    case CoherenceKind::iec: {
      if (component > 0 && coherence.iec_for_u_only) break;
      const double decay = coherence.iec_decay * std::hypot(wave_number, 0.12 / coherence.iec_length);
      return {decay, decay};
    }
    case CoherenceKind::none:
      break;
  }
  return {infinite, infinite};
}

double root_coherence(const CoherenceDecay& decay, double dy, double dz) {
  // Infinity times no separation is no number.
  return std::exp(-std::hypot(dy == 0 ? 0 : decay.y * dy, dz == 0 ? 0 : decay.z * dz));
}

double root_coherence(const Coherence& coherence, int component, double frequency, double dy, double dz) {
  return root_coherence(coherence_decay(coherence, component, frequency), dy, dz);
}

}  // namespace tremula
