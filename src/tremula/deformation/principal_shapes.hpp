// What bends, as a few shapes that superpose: the mean and the principal components of the motion about it
// (Karhunen and Loève; "proper orthogonal decomposition"). So morph targets can play what S eq. 1 cannot say.
#pragma once

#include "tremula/deformation/pose.hpp"

#include <functional>
#include <vector>

#include <Eigen/Core>

namespace tremula {

struct PrincipalShapes {
  std::vector<SurfaceDelta> shapes;  // (c) the first is the mean
  Eigen::MatrixXd weights;           // (samples x c), 1 for the mean
  double largest_error = 0;          // of any vertex at any sample that was looked at [m]
};

// skin(sample) of a loop of `samples`: as few shapes as keep every vertex within `tolerance` [m] at the
// samples that are looked at, some 200 spread over the loop, but not more than `most`. Normals follow the
// same weights by least squares. Throws InputError without samples.
PrincipalShapes principal_shapes(int samples, const std::function<SurfaceDelta(int sample)>& skin,
                                 double tolerance, int most = 32);

}  // namespace tremula
