// What the editions of IEC 61400-1 say differently of one and the same spectra.
#pragma once

namespace tremula {

enum class IecEdition {
  second = 2,  // 1999
  third = 3,   // 2005; the fourth (2019) left these numbers alone
};

// Throws InputError for other numbers than 2 and 3.
IecEdition iec_edition(int number);

// Lambda_1, the length that all others are multiples of [m]: 0.7 of the height of the hub, up to 21 m in the
// second edition and up to 42 m in the third.
double turbulence_scale(IecEdition edition, double hub_height);

// The coherence exp(-decay sqrt((f r/U)^2 + (0.12 r/L_c)^2)): 8.8 and L_c = 3.5 Lambda_1 in the second
// edition, 12 and 8.1 Lambda_1 in the third.
struct IecCoherence {
  double decay, length;  // length [m]
};
IecCoherence iec_coherence(IecEdition edition, double hub_height);

}  // namespace tremula
