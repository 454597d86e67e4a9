// What the modes that were left out add: they still follow the slow wind.
#pragma once

#include "tremula/dynamics/loads.hpp"
#include "tremula/dynamics/motion.hpp"
#include "tremula/modes/modes.hpp"

#include <Eigen/Core>

namespace tremula {

// Up to three: with them, the static deflection under a gust that is the same everywhere, in any direction,
// is the exact K^-1 f of the loads, however few the modes (residual flexibility; load-dependent vectors of
// Wilson, Yuan & Dickens 1982, Earthquake Eng. Struct. Dyn. 10). None where the modes already say all.
StaticShapes static_shapes(const Structure& structure, const Loads& loads, const Modes& modes);

// The modes and the static shapes behind them, in one table, as Motion's coordinates count them.
Modes with_static_shapes(const Modes& modes, const StaticShapes& shapes);

}  // namespace tremula
