#include "tremula/deformation/loop.hpp"

#include "tremula/base/check.hpp"

#include <cmath>
#include <memory>
#include <string>
#include <utility>

namespace tremula {

void check_instances(const std::vector<Instance>& instances) {
  if (instances.empty()) throw InputError("instances of the loop", "0", "1 or more");
  for (std::size_t i = 0; i < instances.size(); ++i) {
    const Instance& it = instances[i];
    const bool finite = it.position.allFinite() && std::isfinite(it.turn) && std::isfinite(it.time_shift);
    if (!finite || !(it.scale > 0) || !std::isfinite(it.scale)) {
      throw InputError("instance " + std::to_string(i) + " of the loop",
                       finite ? "scale " + std::to_string(it.scale) : "a number that is not finite",
                       "finite numbers and a scale above 0");
    }
  }
}

Loop make_loop(const Structure& structure, Surface surface, Motion motion, const LoopFacts& facts) {
  check_motion(motion);
  check_equal("rows of the motion", motion.basis.columns.rows(), structure.size());
  const auto vertices = static_cast<std::ptrdiff_t>(surface.vertex_count());
  check_equal("normals of the surface", static_cast<std::ptrdiff_t>(surface.normal.size()), vertices);
  check_equal("branches of the vertices", static_cast<std::ptrdiff_t>(surface.branch.size()), vertices);
  check_equal("places along the branches", static_cast<std::ptrdiff_t>(surface.along.size()), vertices);
  for (const std::int32_t member : surface.branch) {
    if (member < 0 || static_cast<std::size_t>(member) >= structure.members.size()) {
      throw InputError("branch of a vertex", std::to_string(member),
                       "0 to " + std::to_string(structure.members.size() - 1));
    }
  }
  Loop loop;
  loop.facts = facts;
  loop.period = motion.period;
  loop.kind = motion.basis.kind;
  loop.frequency = motion.basis.frequency;
  loop.coordinates = motion.coordinates;
  struct Source {
    Structure structure;
    Surface surface;
    Motion motion;
  };
  const auto source =
      std::make_shared<const Source>(Source{structure, std::move(surface), std::move(motion)});
  loop.rest = {source, &source->surface};
  loop.shape_of_skin = [source](Eigen::Index shape, double weight) {
    return deform_surface(source->structure, source->surface,
                          weight * source->motion.basis.columns.col(shape));
  };
  loop.skin_at = [source](double time) {
    return deform_surface(source->structure, source->surface, displacement_at(source->motion, time));
  };
  loop.nodes.resize(3, static_cast<Eigen::Index>(structure.nodes.size()));
  for (Eigen::Index i = 0; i < loop.nodes.cols(); ++i)
    loop.nodes.col(i) = structure.nodes[static_cast<std::size_t>(i)].position;
  loop.nodes_at = [source](double time) {
    const Eigen::VectorXd displacement = displacement_at(source->motion, time);
    NodePoses poses(6, static_cast<Eigen::Index>(source->structure.nodes.size()));
    for (Eigen::Index i = 0; i < poses.cols(); ++i)
      poses.col(i) = node_displacement(source->structure, displacement, static_cast<std::size_t>(i));
    return poses;
  };
  return loop;
}

}  // namespace tremula
