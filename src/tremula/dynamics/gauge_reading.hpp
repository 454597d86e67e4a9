// What a strain gauge on a plant reads, as a linear function of the motion.
#pragma once

#include "tremula/base/types.hpp"

#include <string>

#include <Eigen/Core>

namespace tremula {

struct Gauge {
  std::string name;
  int branch = 0;    // or other member
  double place = 0;  // along it, 0 start … 1 end
};

// What lies beyond the section does this to it. Components along the axes of the section as it stands in the
// lean: the axial force, positive where it pulls, two shears [N]; the torsion moment, two bending moments
// about the point of the section on the axis [N m].
struct GaugeReading {
  Gauge gauge;
  Mat3 axes;                     // columns: along the beam; horizontal, across it; across both; right-handed
  double radius = 0;             // of the section [m]
  double bending_stiffness = 0;  // EI [N m^2]
  double axial_stiffness = 0;    // EA [N]
  Vec6 lean = Vec6::Zero();      // under the mean wind, and under the weight that the lean was found with
  Eigen::MatrixXd per_coordinate;  // (6 x c) of what moves about the lean; 0 for the lean itself
};

}  // namespace tremula
