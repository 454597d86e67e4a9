// Where a tree comes to rest under loads that may bend it as far as they like.
//
// Every branch answers to the wrench at its end with its compliance, in the axes that carry it, while the
// wrench is summed on the shape that all branches make together (bent_tree.hpp). Newton's method on the
// strains solves that by elimination from the tips to the roots and back, without a stiffness matrix: what
// hangs on the end of a branch is a 6 x 6 stiffness there. Where steps go astray, the tree is let down
// through syrup (pseudo-transient continuation, Kelley & Keyes 1998, SIAM J. Numer. Anal. 35).
#pragma once

#include "tremula/structure/bent_tree.hpp"
#include "tremula/structure/prestress.hpp"

#include <functional>
#include <optional>
#include <vector>

#include <Eigen/Core>

namespace tremula {

using EndGrowth = Eigen::Matrix<double, 12, 12>;

// What loads a branch, as forces [N] and moments [N m] at the start of its beam and at its end; world axes.
struct EndLoads {
  Vec3 start_force = Vec3::Zero(), start_moment = Vec3::Zero();
  Vec3 end_force = Vec3::Zero(), end_moment = Vec3::Zero();
  // How all twelve (force and moment at the start, then at the end) grow when the start and the end move and
  // turn, start first: drag that turns, springs, and what inertia is in one step of time. It speeds the
  // search up and changes no result.
  std::optional<EndGrowth> growth = {};
};

// Adds a force on the axis where the beam has this shape (shape_at), and how it grows when the section there
// turns [N/rad], shared by the ends as the shape functions of the straight beam share it (point_shape,
// turn_shape). direction: of the chord as it stands.
void add_force(const Shape& shape, const Vec3& direction, const Vec3& force, const Mat3& turning,
               EndLoads& loads);

// Dead loads (prestress.hpp) as loads on branches that bend.
class DeadLoadsOnBranches {
 public:
  // Throws as geometric_stiffness does.
  DeadLoadsOnBranches(const BeamTree& tree, const DeadLoads& loads);
  void add_to(int k, const BentBranch& branch, EndLoads& loads) const;

 private:
  // A force on a branch, by how it is shared: axial and deflection of Shape, summed over where it acts.
  struct Shared {
    Vec3 force;
    Eigen::Vector2d axial;
    Eigen::Vector4d deflection;
  };
  const BeamTree& tree_;
  std::vector<std::size_t> first_;
  std::vector<Shared> forces_;
};

// The loads on branch k as it stands. Called once for each branch and shape; by several threads.
using BranchLoads = std::function<EndLoads(int k, const BentBranch& branch)>;

// Force and moment on the end of every branch, about it, of all that loads the branch there and beyond, and
// the same at its start, with what loads it there (6N) [N, N m]; world axes. And what the ground carries (the
// sum of what all roots hand down), about the origin.
struct Wrenches {
  Eigen::VectorXd at_end, at_start = {};
  Vec3 ground_force = Vec3::Zero(), ground_moment = Vec3::Zero();
};
Wrenches sum_wrenches(const BeamTree& tree, const std::vector<BentBranch>& bent, const BranchLoads& loads);

// The wrenches at the ends as forces on the strains: what they are times the compliance. (6N)
Eigen::VectorXd forces_on_strains(const BeamTree& tree, const Eigen::VectorXd& strains,
                                  const std::vector<BentBranch>& bent, const Eigen::VectorXd& at_end);

struct EquilibriumOptions {
  // Forces on the strains that the given shape already answers to (6N), as its own weight; empty: none.
  Eigen::VectorXd at_rest = {};
  Eigen::VectorXd start = {};  // strains to begin with; empty: the shape at rest
  // For loads that depend on how the whole tree stands, as shelter does: told each shape before they are
  // asked for. False where it has not settled and would make other loads of the same shape, so that the tree
  // cannot be at rest yet.
  std::function<bool(const std::vector<BentBranch>&)> on_shape = {};
  double tolerance = 1e-10;  // of strains: of angles [rad], and of deflections by length
  int most_steps = 400;
};

struct Equilibrium {
  Eigen::VectorXd strains;
  std::vector<BentBranch> bent;
  Wrenches wrenches;
  int steps = 0;
};

// strains = compliance (forces(strains) - at_rest). Throws InputError for sizes that do not agree, and Error
// where the tree does not come to rest.
Equilibrium find_equilibrium(const BeamTree& tree, const BranchLoads& loads,
                             const EquilibriumOptions& options = {});

}  // namespace tremula
