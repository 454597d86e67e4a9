// What the wind is like at one place, without saying when.
#pragma once

#include "tremula/base/types.hpp"

namespace tremula {

// World axes.
struct GustStatistics {
  Vec3 mean = Vec3::Zero();        // [m/s]
  Mat3 covariance = Mat3::Zero();  // [(m/s)^2], symmetric; an eigenvalue below 0 counts as 0
};

}  // namespace tremula
