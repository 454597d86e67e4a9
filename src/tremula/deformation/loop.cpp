#include "tremula/deformation/loop.hpp"

#include "tremula/base/check.hpp"
#include "tremula/deformation/bent_pose.hpp"
#include "tremula/deformation/panel_pose.hpp"
#include "tremula/deformation/principal_shapes.hpp"
#include "tremula/deformation/sheet_pose.hpp"
#include "tremula/numerics/rotation.hpp"

#include <cmath>
#include <memory>
#include <string>
#include <utility>

namespace tremula {
namespace {

struct Source {
  Structure structure;
  Surface surface;
  Motion motion;
  BentLean lean;  // of a motion that bends far
};
using SharedSource = std::shared_ptr<const Source>;

void check_surface(const Structure& structure, const Surface& surface) {
  const auto vertices = static_cast<std::ptrdiff_t>(surface.vertex_count());
  check_equal("normals of the surface", static_cast<std::ptrdiff_t>(surface.normal.size()), vertices);
  check_equal("branches of the vertices", static_cast<std::ptrdiff_t>(surface.branch.size()), vertices);
  check_equal("places along the branches", static_cast<std::ptrdiff_t>(surface.along.size()), vertices);
  if (structure.sheet) return;  // sheet_surface knows its sheet
  const int carriers = carrier_count(structure);
  for (const std::int32_t member : surface.branch) {
    if (member < 0 || member >= carriers) {
      throw InputError("branch of a vertex", std::to_string(member), "0 to " + std::to_string(carriers - 1));
    }
  }
}

// pose_of(node) gives translation and rotation vector.
template <class PoseOf>
NodePoses poses_of_nodes(const Structure& structure, const PoseOf& pose_of) {
  NodePoses poses(6, static_cast<Eigen::Index>(structure.nodes.size()));
  for (Eigen::Index i = 0; i < poses.cols(); ++i) poses.col(i) = pose_of(index_of(i));
  return poses;
}

Vec6 pose_from_rest(const Structure& structure, const BentPoint& point, std::size_t node) {
  Vec6 pose;
  pose << point.position - structure.nodes[node].position, rotation_vector(point.frame);
  return pose;
}

// S eq. 1 for all that moves, the lean as well.
void superpose_from_rest(Loop& loop, const SharedSource& source) {
  loop.shape_of_skin = [source](Eigen::Index shape, double weight) {
    return deform_surface(source->structure, source->surface,
                          weight * source->motion.basis.columns.col(shape));
  };
  loop.skin_at = [source](double time) {
    return deform_surface(source->structure, source->surface, displacement_at(source->motion, time));
  };
  loop.nodes_at = [source](double time) {
    const Eigen::VectorXd displacement = displacement_at(source->motion, time);
    return poses_of_nodes(source->structure, [&](std::size_t node) {
      return node_displacement(source->structure, displacement, node);
    });
  };
}

SurfaceDelta scaled(SurfaceDelta delta, float factor) {
  for (Eigen::Vector3f& position : delta.position) position *= factor;
  for (Eigen::Vector3f& normal : delta.normal) normal *= factor;
  return delta;
}

void give_shapes_about_lean(Loop& loop, const SharedSource& source) {
  loop.shape_of_skin = [source](Eigen::Index shape, double weight) {
    if (source->motion.basis.kind[index_of(shape)] == ShapeKind::lean) {
      return scaled(bend_surface(source->structure, source->surface, source->lean.bent),
                    static_cast<float>(weight));
    }
    const BentChange change = change_about(source->lean, weight * source->motion.basis.columns.col(shape));
    return change_of_surface(source->structure, source->surface, change);
  };
}

void bend_by_strains(Loop& loop, const SharedSource& source) {
  loop.skin_at = [source](double time) {
    return bend_surface(source->structure, source->surface, bent_at(source->lean, source->motion, time));
  };
  loop.nodes_at = [source](double time) {
    const std::vector<BentBranch> bent = bent_at(source->lean, source->motion, time);
    return poses_of_nodes(source->structure, [&](std::size_t node) {
      return pose_from_rest(source->structure, bent_node(source->structure, bent, node), node);
    });
  };
}

void superpose_on_lean(Loop& loop, const SharedSource& source) {
  loop.skin_at = [source](double time) {
    SurfaceDelta delta = bend_surface(source->structure, source->surface, source->lean.bent);
    const SurfaceDelta more =
        change_of_surface(source->structure, source->surface,
                          change_about(source->lean, displacement_about_lean(source->motion, time)));
    for (std::size_t i = 0; i < delta.position.size(); ++i) {
      delta.position[i] += more.position[i];
      delta.normal[i] += more.normal[i];
    }
    return delta;
  };
  loop.nodes_at = [source](double time) {
    const BentChange change = change_about(source->lean, displacement_about_lean(source->motion, time));
    return poses_of_nodes(source->structure, [&](std::size_t node) {
      const Vec6 moved = change_of_node(source->structure, change, node);
      BentPoint point = bent_node(source->structure, source->lean.bent, node);
      point.position += moved.head<3>();
      point.frame = rotation_matrix(moved.tail<3>()) * point.frame;
      return pose_from_rest(source->structure, point, node);
    });
  };
}

// The skin as it bends, and the principal shapes of that in place of the modes.
void bend_as_sheet(Loop& loop, const SharedSource& source) {
  constexpr double tolerance = 0.002;  // of the sheet's diagonal
  const bool in_space = source->motion.in_space;
  loop.skin_at = [source, pose = in_space ? carry_sheet : bend_sheet](double time) {
    return pose(source->structure, source->surface, displacement_at(source->motion, time));
  };
  loop.nodes_at = [source, pose = in_space ? carried_nodes : bent_nodes](double time) {
    const std::vector<BentPoint> bent = pose(source->structure, displacement_at(source->motion, time));
    return poses_of_nodes(source->structure, [&](std::size_t node) {
      return pose_from_rest(source->structure, bent[node], node);
    });
  };
  const int samples = loop.sample_count();
  const Sheet& sheet = *source->structure.sheet;
  const auto principal = std::make_shared<const PrincipalShapes>(principal_shapes(
      samples, [&](int sample) { return loop.skin_at(loop.period * sample / samples); },
      tolerance * std::hypot(sheet.width, sheet.height)));
  loop.kind.assign(principal->shapes.size(), ShapeKind::static_shape);
  loop.kind.front() = ShapeKind::lean;
  loop.frequency = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(principal->shapes.size()));
  loop.coordinates = principal->weights;
  loop.shape_of_skin = [principal](Eigen::Index shape, double weight) {
    return scaled(principal->shapes[index_of(shape)], static_cast<float>(weight));
  };
}

}  // namespace

void check_instances(const std::vector<Instance>& instances, bool repeats) {
  if (instances.empty()) throw InputError("instances of the loop", "0", "1 or more");
  for (std::size_t i = 0; i < instances.size(); ++i) {
    const Instance& it = instances[i];
    const bool finite = it.position.allFinite() && std::isfinite(it.turn) && std::isfinite(it.time_shift);
    if (!finite || !(it.scale > 0) || !std::isfinite(it.scale)) {
      throw InputError("instance " + std::to_string(i) + " of the loop",
                       finite ? "scale " + std::to_string(it.scale) : "a number that is not finite",
                       "finite numbers and a scale above 0");
    }
    if (!repeats && it.time_shift != 0) {
      throw InputError("instance " + std::to_string(i) + " of a clip that does not repeat",
                       "a time shift of " + std::to_string(it.time_shift) + " s", "none");
    }
  }
}

Loop make_loop(const Structure& structure, Surface surface, Motion motion, const LoopFacts& facts,
               Poses poses) {
  check_motion(motion);
  check_equal("rows of the motion", motion.basis.columns.rows(), structure.size());
  check_surface(structure, surface);
  Loop loop;
  loop.facts = facts;
  loop.period = motion.period;
  loop.repeats = motion.repeats;
  loop.kind = motion.basis.kind;
  loop.frequency = motion.basis.frequency;
  loop.coordinates = motion.coordinates;
  loop.nodes.resize(3, static_cast<Eigen::Index>(structure.nodes.size()));
  for (Eigen::Index i = 0; i < loop.nodes.cols(); ++i)
    loop.nodes.col(i) = structure.nodes[index_of(i)].position;
  BentLean lean;
  const bool bends = motion.lean_strains.size() > 0, in_space = motion.in_space;
  loop.facts.scales = facts.scales && !in_space;
  if (bends) lean = bend_lean(structure, motion);
  const auto source = std::make_shared<const Source>(
      Source{structure, std::move(surface), std::move(motion), std::move(lean)});
  loop.rest = {source, &source->surface};
  if (structure.sheet && (poses == Poses::bent || in_space)) {
    bend_as_sheet(loop, source);
  } else if (!bends) {
    superpose_from_rest(loop, source);
  } else {
    give_shapes_about_lean(loop, source);
    poses == Poses::bent ? bend_by_strains(loop, source) : superpose_on_lean(loop, source);
  }
  return loop;
}

}  // namespace tremula
