// Impressionist trees as a ray meets them (F section 5.3): the crown's quadrics, shifted level by level as
// the trunk is, with leaves and holes where Gardner's texture says, which trembles with the gusts.
#pragma once

#include "tremula/deformation/loop.hpp"
#include "tremula/dynamics/trunk_sway.hpp"
#include "tremula/geometry/impression.hpp"
#include "tremula/raytrace/ray_shape.hpp"
#include "tremula/wind/travelling_field.hpp"

#include <memory>
#include <vector>

namespace tremula {

// How the trees of one kind move, wherever they stand.
struct ImpressionMotion {
  double heading = 0;  // what along is [degrees]
  // Of the trunk, as in TrunkSway; empty: it stands still.
  std::vector<double> heights = {};  // [m]
  std::vector<Eigen::Vector2d> lean = {}, share = {};
  std::shared_ptr<const TravellingField> sway = {};     // displacement of the top about the lean [m]
  std::shared_ptr<const TravellingField> tremble = {};  // of the texture [m]; null: it keeps still
};

// How leaves tremble: an oscillator as a twig of a metre is, which swings at 2 Hz (F section 6.1), but damped
// as leaves are, and that draws on its neighbours (F eq. 5). By what gusts move: `give` [m s/m].
FieldResponse tremble_response(double give = 0.012);

// The motion of a sway in gusts on a plane with the layer sway.gust_height. Throws as respond does.
ImpressionMotion impression_motion(const TrunkSway& sway, const TravellingField& gusts,
                                   const FieldResponse& tremble = tremble_response());

// Copies of a tree. Every copy sways in the gusts of its own place, and its time shift counts besides; two
// copies never have the same leaves. `leaf_color` and bark are the tree's. Closes over the period of the
// fields, bit for bit. Throws InputError for a tree that is none, no instances or ones that are not finite,
// and a motion whose parts do not belong together.
std::shared_ptr<const RayShape> impression_shape(const ImpressionistTree& tree,
                                                 std::vector<Instance> instances,
                                                 const ImpressionMotion& motion = {});

}  // namespace tremula
