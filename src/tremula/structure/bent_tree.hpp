// A tree bent as far as one likes: strains of its branches, and the shape they make.
//
// The strain of a branch is what its end does against its rigidly carried start, in the axes of the tree at
// rest: the translation (a d + v), d along the branch, a its elongation and v / length the tangent of the
// angle by which its chord turns; and the rotation vector phi of its end. For small strains these are the e =
// B u of beam_tree.hpp. The shape is one sweep of rotations from the roots to the tips: chords keep their
// length whatever the angles, and to first order in the strains it is S eq. 1. Strains are (6N), rows as
// those of displacements.
#pragma once

#include "tremula/structure/beam_tree.hpp"

#include <vector>

#include <Eigen/Core>

namespace tremula {

// A branch as it stands. Frames are rotations from the axes at rest.
struct BentBranch {
  Vec3 start = Vec3::Zero(), end = Vec3::Zero();  // of the beam, a rigid arm away from what carries it [m]
  Mat3 start_frame = Mat3::Identity(), end_frame = Mat3::Identity();
  Mat3 chord_frame = Mat3::Identity();  // turns the direction at rest into that from start to end
};

// (N) The whole tree. Throws InputError for strains of another size.
std::vector<BentBranch> bend(const BeamTree& tree, const Eigen::VectorXd& strains);

// The strains, beyond those of a bent shape, of a small displacement about it: the derivative of bend, solved
// for the strains. bent: of these strains. (6N) -> (6N)
Eigen::VectorXd strains_about(const BeamTree& tree, const Eigen::VectorXd& strains,
                              const std::vector<BentBranch>& bent, const Eigen::VectorXd& displacement);

// The same in two steps, for whoever asks about one bent shape again and again: by what to multiply, branch
// by branch, the displacement of the end against its carried start. (N) each
struct StrainMaps {
  std::vector<Mat3> translation, rotation;  // [1]
  std::vector<Vec3> reach;  // from the node that carries the start to the end of the branch, as it stands [m]
};
StrainMaps strain_maps(const BeamTree& tree, const Eigen::VectorXd& strains,
                       const std::vector<BentBranch>& bent);
Eigen::VectorXd strains_about(const BeamTree& tree, const StrainMaps& maps,
                              const Eigen::VectorXd& displacement);

// Translations [m] and rotation vectors [rad] of the ends, from rest. (6N)
Eigen::VectorXd displacement_of(const BeamTree& tree, const std::vector<BentBranch>& bent);

// The tree as it stands, its branches straight between their ends: for what is small about the bent shape.
BeamTree tree_at(const BeamTree& tree, const std::vector<BentBranch>& bent);

// The cross section at s (0 start … 1 end) of a bent branch: where its axis is, on a cubic through both ends
// in their directions, and how it has turned from rest. On a spring of the ground the section at 0 moves.
struct BentPoint {
  Vec3 position;  // [m]
  Mat3 frame;
};
BentPoint point_on(const Member& member, const BentBranch& branch, double s);

// The same in two steps, for whoever asks about many sections of a branch.
struct BentCurve {
  Vec3 start = Vec3::Zero(), end = Vec3::Zero();              // of the axis [m]
  Vec3 start_slope = Vec3::Zero(), end_slope = Vec3::Zero();  // by s [m]
  Mat3 start_frame = Mat3::Identity();
  Vec3 turn = Vec3::Zero();        // rotation vector from the start to the end, in the axes of the start
  Vec3 direction = Vec3::UnitX();  // at rest
};
BentCurve curve_of(const Member& member, const BentBranch& branch);
BentPoint point_on(const BentCurve& curve, double s);
// Less of it: the position alone, and the unit vector along the axis, frame * direction.
Vec3 position_on(const BentCurve& curve, double s);
Vec3 direction_on(const BentCurve& curve, double s);

}  // namespace tremula
