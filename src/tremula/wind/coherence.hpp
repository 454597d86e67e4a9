// How far gusts reach: the root-coherence of two points, the part of their cross spectrum that
// sqrt(S(z0) S(z1)) leaves. In all models here it is exp(-sqrt((a_y dy)^2 + (a_z dz)^2)) of the separation
// across the wind, with decays a that depend on the frequency and the component alone. So the wind is a
// homogeneous field with scaled rows, which is what the synthesis by FFT needs (errata F3).
#pragma once

#include "tremula/wind/iec.hpp"
#include "tremula/wind/profile.hpp"

#include <array>
#include <string>

namespace tremula {

enum class CoherenceKind {
  shinya_fournier,  // F eq. 2: a = c f/U
  davenport,        // the same form with Davenport's coefficients
  iec,              // IEC 61400-1 (iec.hpp)
  none,             // every point for itself
};

// "shinya-fournier", "davenport", "iec", "none". Throws InputError for other names.
CoherenceKind coherence_named(const std::string& name);
std::string name_of(CoherenceKind kind);

struct Coherence {
  CoherenceKind kind = CoherenceKind::shinya_fournier;
  double speed = 6;  // U at the reference height [m/s], for all three components (F3)
  std::array<double, 3> decay_y = {3.6, 2.4, 8};  // c_1y, c_2y and the 8 of w (F section 3.2)
  std::array<double, 3> decay_z = {6, 4, 8};      // c_1z, c_2z; F has none for w: as across, our choice
  double iec_decay = 12;                          // of IEC 61400-1: IecCoherence
  double iec_length = 340.2;                      // [m]
  bool iec_for_u_only = false;  // as the standard has it; else v and w take the coherence of u
};

// The model with the numbers its source gives. davenport: 16 across and 10 up for all three components (Simiu
// & Scanlan, where F's coefficients come from too). iec: iec_coherence of the edition at the reference
// height.
Coherence coherence_model(CoherenceKind kind, const MeanWind& mean, IecEdition edition = IecEdition::third);

void check_coherence(const Coherence& coherence);  // throws InputError

struct CoherenceDecay {
  double y = 0, z = 0;  // [1/m]; infinite: no coherence
};

// Of component c (0 u, 1 v, 2 w) at a frequency [Hz].
CoherenceDecay coherence_decay(const Coherence& coherence, int component, double frequency);

// exp(-sqrt((a_y dy)^2 + (a_z dz)^2)), 1 at no separation. dy, dz [m].
double root_coherence(const CoherenceDecay& decay, double dy, double dz);
double root_coherence(const Coherence& coherence, int component, double frequency, double dy, double dz);

}  // namespace tremula
