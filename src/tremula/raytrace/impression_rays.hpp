// Impressionist trees as a ray meets them (F section 5.3): the crown's quadrics, shifted level by level as
// the trunk is, with leaves and holes where Gardner's texture says, which trembles with the gusts.
#pragma once

#include "tremula/deformation/impression_motion.hpp"
#include "tremula/geometry/impression.hpp"
#include "tremula/raytrace/ray_shape.hpp"

#include <memory>
#include <vector>

namespace tremula {

// Copies of a tree. Every copy sways in the gusts of its own place, and its time shift counts besides; two
// copies never have the same leaves. `leaf_color` and bark are the tree's. Closes over the period of the
// fields, bit for bit. Throws InputError for a tree that is none, no instances or ones that are not finite,
// and a motion whose parts do not belong together.
std::shared_ptr<const RayShape> impression_shape(const ImpressionistTree& tree,
                                                 std::vector<Instance> instances,
                                                 const ImpressionMotion& motion = {});

}  // namespace tremula
