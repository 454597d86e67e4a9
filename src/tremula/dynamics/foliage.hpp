// Leaves fold in the wind: the faster it is, the less of them it meets.
#pragma once

namespace tremula {

// An empirical law by speed. The drag 1/2 rho C A |v| v of a leaf is multiplied by
//
//   g(|v|) = (1 + (|v|/U_f)^2)^(E/2):
//
// the square of the speed far below the folding speed, F ~ U^(2 + E) far above it.
struct FoliageLaw {
  double vogel_exponent = -1;  // E
  double folding_speed = 3;    // U_f [m/s]
};

// Throws InputError for an exponent outside [-4/3, 0], the lower end that of a disk that rolls up to a cone
// (Schouveiler & Boudaoud 2006), or a folding speed that is not above 0.
void check_foliage(const FoliageLaw& law);

double folding_factor(const FoliageLaw& law, double speed);  // g, in (0, 1]; speed [m/s]

// d ln g/d ln |v|, from 0 to E: what a little more wind takes from the drag of a leaf by its folding alone.
double folding_slope(const FoliageLaw& law, double speed);

}  // namespace tremula
