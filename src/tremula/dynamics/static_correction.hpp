// What the modes that were left out add: they still follow the wind.
#pragma once

#include "tremula/modes/modes.hpp"
#include "tremula/structure/structure.hpp"

#include <Eigen/Core>

namespace tremula {

struct Loads;

// Shapes beside the modes, at right angles to them in mass and in stiffness and mass-normalised like them.
// They move as modes of their frequencies would; what the wind adds to damping and stiffness takes them in.
struct StaticShapes {
  Eigen::VectorXd frequency;  // (k) Rayleigh quotients [Hz]
  Eigen::MatrixXd shapes;     // (rows x k)

  int count() const { return static_cast<int>(frequency.size()); }
};

// Up to three: with them, the static deflection under a gust that is the same everywhere, in any direction,
// is the exact K^-1 f of the loads, however few the modes (residual flexibility; load-dependent vectors of
// Wilson, Yuan & Dickens 1982, Earthquake Eng. Struct. Dyn. 10). None where the modes already say all.
// turning: the loads change as the structure turns in the wind, and the deflection is that of
// aerodynamic_stiffness besides K.
StaticShapes static_shapes(const Structure& structure, const Sites& sites, const Loads& loads,
                           const Modes& modes, bool turning = false);

// The same for one given force on the rows, one shape or none: modes and it together deflect under that force
// as K^-1 f says.
StaticShapes static_shape(const Structure& structure, const Eigen::VectorXd& force, const Modes& modes);

}  // namespace tremula
