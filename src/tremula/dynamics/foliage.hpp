// Leaves fold in the wind: the faster it is, the less of them it meets.
#pragma once

namespace tremula {

// An empirical law by speed. The drag 1/2 rho C A |v| v of a leaf is multiplied by
//
//   g(|v|) = (1 + (|v|/U_f)^2)^(E/2):
//
// the square of the speed far below the folding speed, F ~ U^(2 + E) far above it.
// E = -1: the leaves of a cherry tree of 3 m in a wind tunnel went over from U^2 to about U as they folded
// (de Langre, Tadrist et al. 2015, APS DFD M40.8); plants have -0.2 … -1.2, most of them with their branches
// in it (Vogel 1984, 1989). U_f is a choice: the grown oak in its own shelter then has a drag of U^1.73
// between 6 and 20 m/s with rigid branches, where an open-grown oak had 1.60 to 1.68, and 1.90 to 2.01
// without leaves (Angelou, Dellwik & Mann 2019, Forestry 92). Branches that bend come on top, elsewhere.
struct FoliageLaw {
  double vogel_exponent = -1;  // E
  double folding_speed = 3;    // U_f [m/s], of the wind at the leaf
};

// Throws InputError for an exponent outside [-4/3, 0], the lower end that of a disk that rolls up to a cone
// (Schouveiler & Boudaoud 2006), or a folding speed that is not above 0.
void check_foliage(const FoliageLaw& law);

double folding_factor(const FoliageLaw& law, double speed);  // g, in (0, 1]; speed [m/s]

// d ln g/d ln |v|, from 0 to E: what a little more wind takes from the drag of a leaf by its folding alone.
double folding_slope(const FoliageLaw& law, double speed);

}  // namespace tremula
