// The drag of a site in gusts that need not be small against the mean wind: averaged over a Gaussian wind.
#pragma once

#include "tremula/base/types.hpp"
#include "tremula/dynamics/foliage.hpp"
#include "tremula/wind/gust_statistics.hpp"

#include <vector>

namespace tremula {

// Of a force f(v) in the wind U + u, u Gaussian: E f, and E df/dv, which is also the best linear fit,
// E f u^T = (E df/dv) Sigma (Stein 1981, Ann. Stat. 9; "statistical linearisation", Roberts & Spanos 1990).
// Here per k = 1/2 rho C A, so that all sites that share a wind and an axis share the average.
struct AverageForce {
  Vec3 mean = Vec3::Zero();          // times k: [N]
  Mat3 per_velocity = Mat3::Zero();  // times k: [N s/m]
};

// |v| g(|v|) as a mixture of functions whose averages are known, prepared once a plant
// (docs/theory/dynamics).
struct FoldingMixture {
  FoliageLaw law;
  // At ln(t U_f^2) = -26, -25.75 … 28: the density of the mixture in t over that without folding, and what
  // lies below t of its first moment.
  std::vector<double> density, moment;
};

// Throws InputError as check_foliage does.
FoldingMixture mix_folding(const FoliageLaw& law);

// All within 1e-3 of the integral (a cylinder within 1e-4), for every mean and covariance, singular ones too;
// without gusts the derivative of the drag in the mean wind, to rounding. Numbers that are not
// finite give such.

// Of a cylinder: f = |v_n| v_n, v_n the part of v across the axis (unit vector).
AverageForce average_drag_across(const Vec3& axis, const GustStatistics& gusts);

// Of foliage that does not fold, f = |v| v, and of foliage that does, f = g(|v|) |v| v.
AverageForce average_drag(const GustStatistics& gusts);
AverageForce average_folding_drag(const FoldingMixture& mixture, const GustStatistics& gusts);

// Of a flat blade, f = |v| (v . n) n along its normal n (unit vector), from average_drag.
AverageForce along_normal(const AverageForce& average_drag, const Vec3& normal);

}  // namespace tremula
