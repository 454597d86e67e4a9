// The beam whose vibrations are known in closed form: uniform, clamped at its start, free at its end (F
// section 4.3, eq. 6 to 10). A branch that is about uniform moves like this, and a whole tree of them makes
// the oscillators of F section 6.1 (dynamics/oscillators.hpp).
#pragma once

#include "tremula/structure/round_section.hpp"

namespace tremula {

struct UniformBeam {
  double length;             // l [m]
  double bending_stiffness;  // EI [N m^2]
  double mass_per_length;    // rho A [kg/m]
};

// Modes are numbered 1, 2, … to a million. Functions throw InputError for others, for a place that is not on
// the beam, and for lengths, stiffnesses, masses and times that are not above 0.

// lambda_r, the r-th root of cos(lambda) cosh(lambda) = -1; it nears (r - 1/2) pi.
double clamped_free_root(int mode);
// eta_r of F section 4.3 as a beam with a free end has it, (cosh + cos)/(sinh + sin) (errata F6).
double clamped_free_eta(int mode);
// omega_r = (lambda_r/l)^2 sqrt(EI/(rho A)) [rad/s] (F eq. 6, errata F5).
double natural_omega(const UniformBeam& beam, int mode);

// A shape and its derivatives by x/l.
struct BeamShape {
  double value, slope, curvature, third;
};
// V_r of F section 4.3 at place = x/l, 0 clamped to 1 free, with B_r = 1: the mean of V_r^2 over the beam is
// 1, that of V_r V_s is 0, and the tip is at 2, -2, 2, …. Sums of cosh and sinh that would cancel are
// decaying exponentials here, so that shapes of high modes keep their digits.
BeamShape clamped_free_shape(int mode, double place);
// The mean of V_r over the beam, 2 eta_r/lambda_r: how much of an even load drives the mode.
double clamped_free_mean(int mode);
// The polynomial that F offers for the first shape, (x^4 - 4 x^3 + 6 x^2)/3, 1 at the tip: within 1.5 % of it
// (errata F10), with the square of the frequency 162/13 instead of lambda_1^4 = 12.36.
BeamShape fundamental_polynomial(double place);

// EI V_r'''(0) [N/m]: the shear force that the clamp takes for every metre of the modal coordinate, and that
// the branch hands to its parent (F eq. 10 and section 6.1). For a positive coordinate it is negative in the
// first mode: the branch pulls the clamp after it with minus this.
double clamp_shear(const UniformBeam& beam, int mode);

// What F section 6.1 takes from a look at a branch: how often it swings and how long it goes on. E [Pa] from
// the first frequency [Hz], with the section's own second moment (errata F9), and c [s] of F eq. 7 and 9 from
// the time [s] in which the mode falls to 1/e (errata F7, F8).
double youngs_modulus_of(double frequency, double length, double density, const RoundSection& section);
double stiffness_damping_of(double damping_time, double frequency);

}  // namespace tremula
