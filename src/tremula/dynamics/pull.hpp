// Pull and release: a structure that stands still under a force is let go.
#pragma once

#include "tremula/dynamics/free_decay.hpp"
#include "tremula/dynamics/gauge_reading.hpp"
#include "tremula/dynamics/transfer.hpp"
#include "tremula/geometry/skeleton.hpp"
#include "tremula/numerics/time_axis.hpp"
#include "tremula/structure/structure.hpp"

#include <optional>
#include <string>

#include <Eigen/Core>

namespace tremula {

struct Pull {
  Gauge place;                // where the rope is tied, on the axis of a branch
  Vec3 force = Vec3::Zero();  // [N]
};

// In words, PLACE:FORCE, the force horizontal and towards `heading`, from x towards y [degrees]:
//   1.3m:200N            where the main stem is 1.3 m above the foot of the thickest one
//   stem:1.3:200N        1.3 m along it; branch:12:0.5:2kN as place_gauge has them
// Throws InputError for other words, places that are not on the plant or that the ground holds, and a force
// that is not above 0.
Pull place_pull(const Skeleton& skeleton, const std::string& text, double heading);

// How the place of a gauge moves with the rows of the structure: the transpose of this (rows x 3) times the
// displacement; this times a force there [N] is that on the rows. Throws InputError for a place that is not
// on the structure.
Eigen::MatrixX3d place_shape(const Structure& structure, const Gauge& place);

// From rest under modal forces (c) that end at t = 0: coordinates at the samples, (M x c), exact whatever the
// step.
Eigen::MatrixXd let_go(const ModalSystem& system, const TimeAxis& axis, const Eigen::VectorXd& forces);

// A field test beside what the modes say.
struct PullTest {
  Pull pull;
  Vec3 released_from = Vec3::Zero();  // how far the place was pulled [m]
  // The mode that holds most of the energy of the pull, what it is without the others and its share in that
  // energy.
  int mode = 0;
  double frequency = 0;                                // [Hz]
  double of_structure = 0, of_medium = 0, energy = 0;  // damping ratios, which add up; 0 to 1
  // What a record of that mode's part in the displacement gives, as where sensors all over the plant tell
  // modes apart; and one of the whole displacement of the place along the pull, which near modes make beat:
  // none where that has no cycles to count. None of both where the record is too short.
  std::optional<FreeDecay> of_mode, of_place;
};

// moving (rows x c) and their frequencies; the first mode_count of them are modes. `structural`: what of the
// damping is not the medium's (c) [1/s]. The record is as long as the axis and fine enough for the peaks.
PullTest test_pull(const Pull& pull, const Structure& structure, Eigen::Ref<const Eigen::MatrixXd> moving,
                   int mode_count, const ModalSystem& system, const Eigen::VectorXd& structural,
                   const TimeAxis& axis);

}  // namespace tremula
