// Loads as forces on the ends of one member, for the tests.
#pragma once

#include "tremula/dynamics/lean.hpp"
#include "tremula/structure/structure.hpp"

#include <Eigen/Core>

namespace tremula::test {

// What S has of the lean: small displacements, and every branch in the free wind.
inline const LeanOptions small_and_free{.rotations = Rotations::small, .shelter = {.on = false}};

// Forces and moments on the start and the end of a member whose ends are both free, from the forces on its
// own sites; in the order of EndDisplacements.
template <class ForceOn>
Eigen::Matrix<double, 12, 1> end_forces(const Structure& structure, const Sites& sites, int member,
                                        const ForceOn& force_on) {
  Eigen::Matrix3Xd forces = Eigen::Matrix3Xd::Zero(3, static_cast<Eigen::Index>(sites.sites.size()));
  for (std::size_t s = 0; s < sites.sites.size(); ++s) {
    if (sites.sites[s].point == member) forces.col(static_cast<Eigen::Index>(s)) = force_on(s);
  }
  const Eigen::VectorXd rows = sites.gather(forces);
  const Member& self = structure.members[static_cast<std::size_t>(member)];
  Eigen::Matrix<double, 12, 1> ends;
  ends << rows.segment<6>(self.start_row), rows.segment<6>(self.end_row);
  return ends;
}

inline Eigen::Matrix<double, 12, 1> mean_end_forces(const Structure& structure, const Sites& sites,
                                                    const Loads& loads, int member) {
  return end_forces(structure, sites, member, [&](std::size_t s) { return loads.sites[s].mean; });
}

// Per velocity of the wind at the member's point, in each world axis.
inline Eigen::Matrix<double, 12, 3> gust_end_forces(const Structure& structure, const Sites& sites,
                                                    const Loads& loads, int member) {
  Eigen::Matrix<double, 12, 3> forces;
  for (int axis = 0; axis < 3; ++axis) {
    forces.col(axis) = end_forces(structure, sites, member, [&](std::size_t s) -> Vec3 {
      return loads.sites[s].gust_share * loads.sites[s].per_velocity.col(axis);
    });
  }
  return forces;
}

}  // namespace tremula::test
