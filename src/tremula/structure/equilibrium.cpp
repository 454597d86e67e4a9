#include "tremula/structure/equilibrium.hpp"

#include "tremula/base/check.hpp"
#include "tremula/numerics/rotation.hpp"
#include "tremula/structure/element_blocks.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <tbb/parallel_for.h>
#include <Eigen/LU>

namespace tremula {
namespace {

using SixByThree = Eigen::Matrix<double, 6, 3>;
using SixBySeven = Eigen::Matrix<double, 6, 7>;

// How the strain of a branch moves its end, start held: (d x_end, d theta_end) = moves * d strain.
struct StrainMotion {
  Mat3 translation, rotation;  // world axes from those at rest
};
StrainMotion strain_motion(const Member& member, const BentBranch& branch, const Vec3& translation,
                           const Vec3& rotation) {
  const Vec3& d = member.direction;
  const Vec3 reach = branch.end - branch.start;
  const Mat3 turn = branch.start_frame * rotation_tangent(d.cross(translation) / member.beam.length) *
                    (cross_matrix(d) / member.beam.length);
  return {branch.chord_frame * d * d.transpose() - cross_matrix(reach) * turn,
          branch.start_frame * rotation_tangent(rotation)};
}

// How the force on the strain of a branch grows with the strain, the wrench held. Blocks for translation and
// rotation.
struct OwnGrowth {
  Mat3 translation, rotation;
};
OwnGrowth own_growth(const Member& member, const BentBranch& branch, const Vec3& translation,
                     const Vec3& rotation, const Vec3& force, const Vec3& moment) {
  const Vec3& d = member.direction;
  const double length = member.beam.length;
  const Vec3 turned = d.cross(translation) / length;
  const Mat3 tangent = rotation_tangent(turned), cross_d = cross_matrix(d);
  const Vec3 along = branch.start_frame.transpose() * (branch.chord_frame * d);
  const Vec3 reach = branch.start_frame.transpose() * (branch.end - branch.start);
  const Vec3 own_force = branch.start_frame.transpose() * force;
  const Vec3 own_moment = branch.start_frame.transpose() * moment;
  const Mat3 turn = tangent * cross_d / length;
  const Mat3 reach_growth = along * d.transpose() - cross_matrix(reach) * turn;
  const Mat3 moment_growth = -tangent.transpose() * cross_matrix(own_force) * reach_growth +
                             rotation_tangent_growth(turned, reach.cross(own_force)) * cross_d / length;
  return {d * along.cross(own_force).transpose() * turn - cross_d * moment_growth / length,
          rotation_tangent_growth(rotation, own_moment)};
}

// What hangs on a node: its wrench, and the change of that with the motion of the node, constant + stiffness
// u.
struct Hung {
  Vec6 wrench = Vec6::Zero(), constant = Vec6::Zero();
  Mat6 stiffness = Mat6::Zero();
};

// The strain of a branch as it follows the motion of its start: step + follow u.
struct Answer {
  Vec6 step;
  Mat6 follow;
};

Vec6 force_on_strain(const StrainMotion& moves, const Vec6& wrench) {
  Vec6 force;
  force << moves.translation.transpose() * wrench.head<3>(), moves.rotation.transpose() * wrench.tail<3>();
  return force;
}

// Everything that a step needs of one tree.
struct Solver {
  const BeamTree& tree;
  const BranchLoads& loads;
  const EquilibriumOptions& options;
  std::vector<Mat6> compliance{};

  std::vector<EndLoads> loads_now{};
  std::vector<Hung> hung{};
  std::vector<Answer> answers{};

  Solver(const BeamTree& tree_, const BranchLoads& loads_, const EquilibriumOptions& options_)
      : tree(tree_), loads(loads_), options(options_) {
    for (int k = 0; k < tree.branch_count(); ++k) {
      const Member& member = tree.members[index_of(k)];
      compliance.push_back(compliance_block(tree.compliances[index_of(k)], member.direction));
    }
    answers.resize(tree.parent.size());
  }

  void find_loads(const std::vector<BentBranch>& bent);
  // From the tips to the roots: the error of the strains [rad, deflection by length], and what each branch
  // answers. syrup: how much more than it gives way each branch resists to give way further, in one step.
  double gather(const Eigen::VectorXd& strains, const std::vector<BentBranch>& bent, double syrup);
  // From the roots to the tips: the step of the strains, and the farthest that it turns any node [rad].
  struct Step {
    Eigen::VectorXd strains;
    double turn = 0;
  };
  Step follow(const Eigen::VectorXd& strains, const std::vector<BentBranch>& bent) const;
};

void Solver::find_loads(const std::vector<BentBranch>& bent) {
  constexpr int together = 32;
  loads_now.resize(tree.parent.size());
  const int count = tree.branch_count();
  tbb::parallel_for(0, (count + together - 1) / together, [&](int part) {
    for (int k = part * together; k < std::min(count, (part + 1) * together); ++k)
      loads_now[index_of(k)] = loads(k, bent[index_of(k)]);
  });
}

double Solver::gather(const Eigen::VectorXd& strains, const std::vector<BentBranch>& bent, double syrup) {
  hung.assign(tree.parent.size(), Hung{});
  find_loads(bent);
  double largest_error = 0;
  for (int k = tree.branch_count() - 1; k >= 0; --k) {
    const Member& member = tree.members[index_of(k)];
    const BentBranch& branch = bent[index_of(k)];
    const EndLoads& load = loads_now[index_of(k)];
    Hung& end = hung[index_of(k)];
    end.wrench.head<3>() += load.end_force;
    end.wrench.tail<3>() += load.end_moment;
    if (load.growth) end.stiffness += load.growth->bottomRightCorner<6, 6>();

    const Vec6 strain = strains.segment<6>(6 * k);
    const Vec3 force = end.wrench.head<3>(), moment = end.wrench.tail<3>(), reach = branch.end - branch.start;
    const StrainMotion moves = strain_motion(member, branch, strain.head<3>(), strain.tail<3>());
    Vec6 on_strain = force_on_strain(moves, end.wrench);
    if (options.at_rest.size() > 0) on_strain -= options.at_rest.segment<6>(6 * k);
    const Vec6 error = compliance[index_of(k)] * on_strain - strain;
    largest_error =
        std::max({largest_error, error.tail<3>().norm(), error.head<3>().norm() / member.beam.length});
    if (!(largest_error < 1e100)) return largest_error;

    // strain step = error + compliance (moves^T (constant + stiffness u_end + [f x; m x] theta_start) + own
    // step).
    Mat6 motion = Mat6::Zero();
    motion.topLeftCorner<3, 3>() = moves.translation;
    motion.bottomRightCorner<3, 3>() = moves.rotation;
    const Mat6 carry = rigid_carry(reach), to_strain = compliance[index_of(k)] * motion.transpose();
    const OwnGrowth own = own_growth(member, branch, strain.head<3>(), strain.tail<3>(), force, moment);
    Mat6 growth = to_strain * end.stiffness * motion;
    growth.leftCols<3>() += compliance[index_of(k)].leftCols<3>() * own.translation;
    growth.rightCols<3>() += compliance[index_of(k)].rightCols<3>() * own.rotation;
    Mat6 at_start = end.stiffness * carry;
    at_start.topRightCorner<3, 3>() += cross_matrix(force);
    at_start.bottomRightCorner<3, 3>() += cross_matrix(moment);
    if (load.growth) at_start += load.growth->bottomLeftCorner<6, 6>();
    const Mat6 thick = (1 + syrup) * Mat6::Identity();
    SixBySeven right;
    right << error + to_strain * end.constant, to_strain * at_start;
    const SixBySeven solved = (thick - growth).partialPivLu().solve(right);
    Answer& answer = answers[index_of(k)];
    answer.step = solved.col(0);
    answer.follow = solved.rightCols<6>();

    const int parent = tree.parent[index_of(k)];
    if (parent < 0) continue;
    // The wrench at the start is that at the end carried over the reach, which itself moves.
    Mat6 handed = carry.transpose() * end.stiffness;
    handed.bottomLeftCorner<3, 3>() -= cross_matrix(force);
    if (load.growth) handed += load.growth->topRightCorner<6, 6>();
    Mat6 stiffness = handed * (carry + motion * answer.follow);
    stiffness.bottomLeftCorner<3, 3>() += cross_matrix(force);
    const Vec6 constant = carry.transpose() * end.constant + handed * (motion * answer.step);
    Vec6 wrench = carry.transpose() * end.wrench;
    wrench.head<3>() += load.start_force;
    wrench.tail<3>() += load.start_moment;
    if (load.growth) {
      stiffness += load.growth->topLeftCorner<6, 6>();
      stiffness.noalias() += carry.transpose() * load.growth->bottomLeftCorner<6, 6>();
    }

    Hung& carrier = hung[index_of(parent)];
    const Vec3 arm = branch.start - bent[index_of(parent)].end;
    if (arm.isZero(0)) {
      carrier.wrench += wrench;
      carrier.constant += constant;
      carrier.stiffness += stiffness;
      continue;
    }
    const Mat6 by_arm = rigid_carry(arm);
    carrier.wrench += by_arm.transpose() * wrench;
    carrier.constant += by_arm.transpose() * constant;
    carrier.stiffness += by_arm.transpose() * stiffness * by_arm;
    carrier.stiffness.bottomRightCorner<3, 3>() += cross_matrix(wrench.head<3>()) * cross_matrix(arm);
  }
  return largest_error;
}

Solver::Step Solver::follow(const Eigen::VectorXd& strains, const std::vector<BentBranch>& bent) const {
  Step step{Eigen::VectorXd(strains.size())};
  std::vector<Vec6> moved(tree.parent.size());
  for (int k = 0; k < tree.branch_count(); ++k) {
    const Member& member = tree.members[index_of(k)];
    const BentBranch& branch = bent[index_of(k)];
    const int parent = tree.parent[index_of(k)];
    Vec6 start = Vec6::Zero();
    if (parent >= 0) start = rigid_carry(branch.start - bent[index_of(parent)].end) * moved[index_of(parent)];
    const Vec6 own = answers[index_of(k)].step + answers[index_of(k)].follow * start;
    step.strains.segment<6>(6 * k) = own;
    const Vec6 strain = strains.segment<6>(6 * k);
    const StrainMotion moves = strain_motion(member, branch, strain.head<3>(), strain.tail<3>());
    moved[index_of(k)] = rigid_carry(branch.end - branch.start) * start;
    moved[index_of(k)].head<3>() += moves.translation * own.head<3>();
    moved[index_of(k)].tail<3>() += moves.rotation * own.tail<3>();
    step.turn = std::max(step.turn, moved[index_of(k)].tail<3>().norm());
  }
  return step;
}

// A force among the ends of a branch, by how much of it each takes along and across the chord.
void share(const Member& member, const BentBranch& branch, const Eigen::Vector2d& axial,
           const Eigen::Vector4d& deflection, const Vec3& force, EndLoads& loads) {
  const Vec3 direction = branch.chord_frame * member.direction;
  const Vec3 along = direction * direction.dot(force), across = force - along,
             moment = direction.cross(force);
  loads.start_force += axial[0] * along + deflection[0] * across;
  loads.start_moment += deflection[1] * moment;
  loads.end_force += axial[1] * along + deflection[2] * across;
  loads.end_moment += deflection[3] * moment;
}

}  // namespace

void add_force(const Member& member, const BentBranch& branch, double s, const Vec3& force,
               const Mat3& turning, EndLoads& loads) {
  const Shape shape = shape_at(member.beam, s);
  share(member, branch, shape.axial, shape.deflection, force, loads);
  if (turning.isZero(0)) return;
  if (!loads.growth) loads.growth = EndGrowth::Zero();
  const Vec3 direction = branch.chord_frame * member.direction;
  const Eigen::Matrix<double, 12, 3> on_ends = point_shape(shape, direction) * turning;
  // Lazy, because Eigen would take its product of large matrices for this one.
  loads.growth->noalias() += on_ends.lazyProduct(turn_shape(shape, direction).transpose());
}

DeadLoadsOnBranches::DeadLoadsOnBranches(const BeamTree& tree, const DeadLoads& loads)
    : tree_(tree), first_(tree.parent.size() + 1, 0) {
  check_dead_loads(tree, loads);
  std::vector<std::vector<Shared>> of_branch(tree.parent.size());
  // Forces in one direction are shared as one.
  const auto add = [&](std::size_t k, const Vec3& force, const Shape& shape) {
    if (force.isZero(0)) return;
    std::vector<Shared>& forces = of_branch[k];
    if (forces.empty() || !forces[0].force.cross(force).isZero(0)) {
      forces.push_back({force, shape.axial, shape.deflection});
      return;
    }
    const double size = force.dot(forces[0].force) / forces[0].force.squaredNorm();
    forces[0].axial += size * shape.axial;
    forces[0].deflection += size * shape.deflection;
  };
  for (std::size_t k = 0; k < tree.parent.size(); ++k) {
    for (const VolumePoint& point : volume_points(tree.members[k].beam))
      add(k, point.volume * loads.per_volume[k], shape_at(tree.members[k].beam, point.s));
  }
  for (const PointForce& point : loads.points) {
    const std::size_t k = index_of(point.branch);
    add(k, point.force, shape_at(tree.members[k].beam, point.position));
  }
  for (std::size_t k = 0; k < of_branch.size(); ++k) {
    forces_.insert(forces_.end(), of_branch[k].begin(), of_branch[k].end());
    first_[k + 1] = forces_.size();
  }
}

void DeadLoadsOnBranches::add_to(int k, const BentBranch& branch, EndLoads& loads) const {
  for (std::size_t i = first_[index_of(k)]; i < first_[index_of(k) + 1]; ++i) {
    const Shared& of = forces_[i];
    share(tree_.members[index_of(k)], branch, of.axial, of.deflection, of.force, loads);
  }
}

Wrenches sum_wrenches(const BeamTree& tree, const std::vector<BentBranch>& bent, const BranchLoads& loads) {
  check_equal("bent branches", static_cast<std::ptrdiff_t>(bent.size()), tree.branch_count());
  Wrenches sum{.at_end = Eigen::VectorXd::Zero(tree.size()), .at_start = Eigen::VectorXd(tree.size())};
  for (int k = tree.branch_count() - 1; k >= 0; --k) {
    const BentBranch& branch = bent[index_of(k)];
    const EndLoads load = loads(k, branch);
    sum.at_end.segment<3>(6 * k) += load.end_force;
    sum.at_end.segment<3>(6 * k + 3) += load.end_moment;
    const Vec3 end_force = sum.at_end.segment<3>(6 * k), force = end_force + load.start_force;
    const Vec3 moment =
        sum.at_end.segment<3>(6 * k + 3) + (branch.end - branch.start).cross(end_force) + load.start_moment;
    sum.at_start.segment<6>(6 * k) << force, moment;
    const int parent = tree.parent[index_of(k)];
    if (parent < 0) {
      sum.ground_force += force;
      sum.ground_moment += moment + branch.start.cross(force);
      continue;
    }
    sum.at_end.segment<3>(6 * parent) += force;
    sum.at_end.segment<3>(6 * parent + 3) +=
        moment + (branch.start - bent[index_of(parent)].end).cross(force);
  }
  return sum;
}

Eigen::VectorXd forces_on_strains(const BeamTree& tree, const Eigen::VectorXd& strains,
                                  const std::vector<BentBranch>& bent, const Eigen::VectorXd& at_end) {
  check_equal("rows of the strains", strains.size(), tree.size());
  check_equal("rows of the wrenches", at_end.size(), tree.size());
  Eigen::VectorXd forces(tree.size());
  for (int k = 0; k < tree.branch_count(); ++k) {
    const StrainMotion moves = strain_motion(tree.members[index_of(k)], bent[index_of(k)],
                                             strains.segment<3>(6 * k), strains.segment<3>(6 * k + 3));
    forces.segment<6>(6 * k) = force_on_strain(moves, at_end.segment<6>(6 * k));
  }
  return forces;
}

Equilibrium find_equilibrium(const BeamTree& tree, const BranchLoads& loads,
                             const EquilibriumOptions& options) {
  if (options.at_rest.size() > 0)
    check_equal("rows of the forces at rest", options.at_rest.size(), tree.size());
  if (options.start.size() > 0)
    check_equal("rows of the strains to start with", options.start.size(), tree.size());
  constexpr double longest_step = 0.5, thinnest = 0.01, first = 1, thickest = 1e12;  // [rad], 1
  Solver solver(tree, loads, options);
  const Eigen::VectorXd start =
      options.start.size() > 0 ? options.start : Eigen::VectorXd(Eigen::VectorXd::Zero(tree.size()));
  Equilibrium rest{start, bend(tree, start), {}, 0};
  double syrup = 0, too_thin = 0;
  for (;; ++rest.steps) {
    const double error = solver.gather(rest.strains, rest.bent, syrup);
    if (error < options.tolerance) break;
    if (rest.steps == options.most_steps || !(error < 1e100) || syrup > thickest) {
      throw Error("equilibrium: the plant does not come to rest: after " + std::to_string(rest.steps) +
                  " steps the angles of branches are still " + std::to_string(error) +
                  " rad off; choose less wind, stiffer wood or thicker twigs");
    }
    const auto [step, turn] = solver.follow(rest.strains, rest.bent);
    // A step that turns a node far may end in a shape where the tree could rest but never would: through
    // syrup it sinks the way it really would. That is as thin as lets it sink, and gone at the end.
    if (!(turn < longest_step)) {
      too_thin = syrup;
      syrup = std::max(4 * syrup, first);
      continue;
    }
    syrup = std::max(syrup * std::clamp(1.5 * turn / longest_step, 0.1, 2.0), 1.2 * too_thin);
    too_thin *= 0.5;
    if (syrup < thinnest) syrup = 0;
    rest.strains += step;
    rest.bent = bend(tree, rest.strains);
  }
  rest.wrenches = sum_wrenches(tree, rest.bent, loads);
  return rest;
}

}  // namespace tremula
