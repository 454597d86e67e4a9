#include "tremula/structure/equilibrium.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/simd.hpp"
#include "tremula/numerics/rotation.hpp"
#include "tremula/structure/element_blocks.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include <tbb/parallel_for.h>

namespace tremula {
namespace {

using SixBySeven = Eigen::Matrix<double, 6, 7>;

void for_branches(int count, const auto& work) {
  constexpr int together = 32;
  tbb::parallel_for(0, (count + together - 1) / together, [&](int part) {
    for (int k = part * together; k < std::min(count, (part + 1) * together); ++k) work(k);
  });
}

// How the strain of a branch moves its end, start held: (d x_end, d theta_end) = moves * d strain.
struct StrainMotion {
  Mat3 translation, rotation;  // world axes from those at rest
};

// How the force on the strain of a branch grows with the strain, the wrench held. Blocks for translation and
// rotation.
struct OwnGrowth {
  Mat3 translation, rotation;
};

// A branch of some strain, in the axes of its start.
class StrainedBranch {
 public:
  StrainedBranch(const Member& member, const BentBranch& branch, const Vec6& strain)
      : direction_(member.direction),
        start_frame_(branch.start_frame),
        chord_turn_(direction_.cross(strain.head<3>()) / member.beam.length),
        end_turn_(strain.tail<3>()),
        per_length_(cross_matrix(direction_) / member.beam.length),
        chord_tangent_(rotation_tangent(chord_turn_)),
        turn_(chord_tangent_ * per_length_),
        along_(start_frame_.transpose() * (branch.chord_frame * direction_)),
        reach_(start_frame_.transpose() * (branch.end - branch.start)),
        reach_growth_(along_ * direction_.transpose() - cross_matrix(reach_) * turn_) {}

  StrainMotion motion() const {
    return {start_frame_ * reach_growth_, start_frame_ * rotation_tangent(end_turn_)};
  }

  OwnGrowth growth(const Vec6& wrench) const {
    const Vec3 force = start_frame_.transpose() * wrench.head<3>();
    const Vec3 moment = start_frame_.transpose() * wrench.tail<3>();
    const Mat3 pulled = cross_matrix(force) * reach_growth_;
    const Mat3 moment_growth = rotation_tangent_growth(chord_turn_, reach_.cross(force)) * per_length_ -
                               chord_tangent_.transpose() * pulled;
    const Eigen::RowVector3d stretched = along_.cross(force).transpose() * turn_;
    return {direction_ * stretched - per_length_ * moment_growth, rotation_tangent_growth(end_turn_, moment)};
  }

 private:
  const Vec3& direction_;
  const Mat3& start_frame_;
  Vec3 chord_turn_, end_turn_;
  Mat3 per_length_;            // of a translation: by what the chord turns
  Mat3 chord_tangent_, turn_;  // how the chord turns by its turn, and by the translation
  Vec3 along_, reach_;         // the chord
  Mat3 reach_growth_;
};

// The change of the wrench of all that hangs on a node with the motion of the node, constant + stiffness u.
struct Hung {
  Vec6 constant = Vec6::Zero();
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

// A motion carried rigidly along an arm.
Vec6 carried(const Vec6& motion, const Vec3& arm) {
  Vec6 result = motion;
  result.head<3>() += motion.tail<3>().cross(arm);
  return result;
}

// Products with diag(translation, rotation) from the right, and with its transpose.
Mat6 times_motion(const Mat6& matrix, const StrainMotion& moves) {
  Mat6 product;
  product.leftCols<3>().noalias() = matrix.leftCols<3>() * moves.translation;
  product.rightCols<3>().noalias() = matrix.rightCols<3>() * moves.rotation;
  return product;
}
Mat6 times_transposed_motion(const Mat6& matrix, const StrainMotion& moves) {
  Mat6 product;
  product.leftCols<3>().noalias() = matrix.leftCols<3>() * moves.translation.transpose();
  product.rightCols<3>().noalias() = matrix.rightCols<3>() * moves.rotation.transpose();
  return product;
}

// Six equations, their right sides behind them, the last three of which are nothing: whole vectors. Leaves
// the solution on the right.
constexpr int row_length = 16;
TREMULA_CLONES void eliminate(double* equations) {
  constexpr int wide = 4, parts = row_length / wide;
  for (int i = 0; i < 6; ++i) {
    double* own = equations + row_length * i;
    double* largest = own;
    for (double* row = own + row_length; row != equations + row_length * 6; row += row_length) {
      if (std::abs(row[i]) > std::abs(largest[i])) largest = row;
    }
    const double inverse = 1 / largest[i];
    Lanes<wide> pivot[parts], swapped;
    for (int k = 0; k < parts; ++k) {
      load(largest + wide * k, pivot[k]);
      load(own + wide * k, swapped);
      store(swapped, largest + wide * k);
      pivot[k] *= inverse;
      store(pivot[k], own + wide * k);
    }
    for (double* row = equations; row != equations + row_length * 6; row += row_length) {
      if (row == own) continue;
      const double factor = row[i];
      for (int k = 0; k < parts; ++k) {
        Lanes<wide> rest;
        load(row + wide * k, rest);
        rest -= factor * pivot[k];
        store(rest, row + wide * k);
      }
    }
  }
}

// a^-1 b with the largest pivots (Gauss and Jordan): Eigen takes the way of large matrices, in ten times the
// time.
SixBySeven solve_six(const Mat6& a, const SixBySeven& b) {
  Eigen::Matrix<double, 6, row_length, Eigen::RowMajor> equations;
  equations.leftCols<6>() = a;
  equations.middleCols<7>(6) = b;
  equations.rightCols<3>().setZero();
  eliminate(equations.data());
  return equations.middleCols<7>(6);
}

Wrenches sum_loads(const BeamTree& tree, const std::vector<BentBranch>& bent, const auto& load_on) {
  Wrenches sum{.at_end = Eigen::VectorXd::Zero(tree.size()), .at_start = Eigen::VectorXd(tree.size())};
  for (int k = tree.branch_count() - 1; k >= 0; --k) {
    const BentBranch& branch = bent[index_of(k)];
    const EndLoads& load = load_on(k);
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

// Everything that a step needs of one tree.
class Solver {
 public:
  Solver(const BeamTree& tree, const BranchLoads& loads, const EquilibriumOptions& options)
      : tree_(tree), loads_(loads), options_(options) {
    for (int k = 0; k < tree.branch_count(); ++k)
      compliance_.push_back(
          compliance_block(tree.compliances[index_of(k)], tree.members[index_of(k)].direction));
    loads_now_.resize(tree.parent.size());
    states_.resize(tree.parent.size());
    answers_.resize(tree.parent.size());
  }

  // Asks for the loads on a shape. The error of its strains [rad, deflection by length].
  double look_at(const Eigen::VectorXd& strains, const std::vector<BentBranch>& bent);
  const Wrenches& wrenches() const { return wrenches_; }

  // The step of the strains, and the farthest that it turns any node [rad]. syrup: how much more than it
  // gives way each branch resists to give way further, in one step.
  struct Step {
    Eigen::VectorXd strains;
    double turn = 0;
  };
  Step find_step(const std::vector<BentBranch>& bent, double syrup) {
    gather(bent, syrup);
    return follow(bent);
  }

 private:
  struct State {
    StrainMotion moves;
    OwnGrowth growth;
    Vec6 error;
  };

  State state_of(int k, const BentBranch& branch, const Vec6& strain) const;
  void gather(const std::vector<BentBranch>& bent, double syrup);  // from the tips to the roots
  Step follow(const std::vector<BentBranch>& bent) const;          // and back

  const BeamTree& tree_;
  const BranchLoads& loads_;
  const EquilibriumOptions& options_;
  std::vector<Mat6> compliance_{};

  std::vector<EndLoads> loads_now_{};
  Wrenches wrenches_{};
  std::vector<State> states_{};
  std::vector<Hung> hung_{};
  std::vector<Answer> answers_{};
};

double Solver::look_at(const Eigen::VectorXd& strains, const std::vector<BentBranch>& bent) {
  for_branches(tree_.branch_count(), [&](int k) { loads_now_[index_of(k)] = loads_(k, bent[index_of(k)]); });
  wrenches_ = sum_loads(tree_, bent, [&](int k) -> const EndLoads& { return loads_now_[index_of(k)]; });
  for_branches(tree_.branch_count(), [&](int k) {
    states_[index_of(k)] = state_of(k, bent[index_of(k)], strains.segment<6>(6 * k));
  });
  double largest = 0;
  for (std::size_t k = 0; k < states_.size(); ++k) {
    const Vec6& error = states_[k].error;
    largest =
        std::max({largest, error.tail<3>().norm(), error.head<3>().norm() / tree_.members[k].beam.length});
    if (!error.allFinite()) return std::numeric_limits<double>::infinity();
  }
  return largest;
}

Solver::State Solver::state_of(int k, const BentBranch& branch, const Vec6& strain) const {
  const StrainedBranch strained(tree_.members[index_of(k)], branch, strain);
  const Vec6 wrench = wrenches_.at_end.segment<6>(6 * k);
  State state{strained.motion(), strained.growth(wrench), {}};
  Vec6 on_strain = force_on_strain(state.moves, wrench);
  if (options_.at_rest.size() > 0) on_strain -= options_.at_rest.segment<6>(6 * k);
  state.error = compliance_[index_of(k)] * on_strain - strain;
  return state;
}

void Solver::gather(const std::vector<BentBranch>& bent, double syrup) {
  hung_.assign(tree_.parent.size(), Hung{});
  for (int k = tree_.branch_count() - 1; k >= 0; --k) {
    const BentBranch& branch = bent[index_of(k)];
    const EndLoads& load = loads_now_[index_of(k)];
    const auto& [moves, own, error] = states_[index_of(k)];
    const Mat6& compliance = compliance_[index_of(k)];
    Hung& end = hung_[index_of(k)];
    if (load.growth) end.stiffness += load.growth->bottomRightCorner<6, 6>();
    const Vec3 force = wrenches_.at_end.segment<3>(6 * k), moment = wrenches_.at_end.segment<3>(6 * k + 3);
    const Mat3 force_cross = cross_matrix(force), reach_cross = cross_matrix(branch.end - branch.start);

    // strain step = error + compliance (moves^T (constant + stiffness u_end + [f x; m x] theta_start) + own
    // step), u_end = carry u_start + moves step, carry = (1, -reach x; 0, 1).
    const Mat6 to_strain = times_transposed_motion(compliance, moves);
    Mat6 system = -to_strain.lazyProduct(times_motion(end.stiffness, moves));
    system.leftCols<3>() -= compliance.leftCols<3>() * own.translation;
    system.rightCols<3>() -= compliance.rightCols<3>() * own.rotation;
    system.diagonal().array() += 1 + syrup;
    Mat6 at_start = end.stiffness;
    at_start.rightCols<3>() -= end.stiffness.leftCols<3>() * reach_cross;
    at_start.topRightCorner<3, 3>() += force_cross;
    at_start.bottomRightCorner<3, 3>() += cross_matrix(moment);
    if (load.growth) at_start += load.growth->bottomLeftCorner<6, 6>();
    SixBySeven right;
    right.col(0) = error + to_strain * end.constant;
    right.rightCols<6>() = to_strain.lazyProduct(at_start);
    const SixBySeven solved = solve_six(system, right);
    Answer& answer = answers_[index_of(k)];
    answer.step = solved.col(0);
    answer.follow = solved.rightCols<6>();

    const int parent = tree_.parent[index_of(k)];
    if (parent < 0) continue;
    // The wrench at the start is that at the end carried over the reach, which itself moves.
    Mat6 handed = end.stiffness;
    handed.bottomRows<3>() += reach_cross * end.stiffness.topRows<3>();
    handed.bottomLeftCorner<3, 3>() -= force_cross;
    if (load.growth) handed += load.growth->topRightCorner<6, 6>();
    Vec6 step_at_end;
    Mat6 with_start = Mat6::Identity();
    with_start.topRightCorner<3, 3>() = -reach_cross;
    step_at_end << moves.translation * answer.step.head<3>(), moves.rotation * answer.step.tail<3>();
    with_start.topRows<3>() += moves.translation * answer.follow.topRows<3>();
    with_start.bottomRows<3>() += moves.rotation * answer.follow.bottomRows<3>();
    Mat6 stiffness = handed.lazyProduct(with_start);
    stiffness.bottomLeftCorner<3, 3>() += force_cross;
    Vec6 constant = end.constant + handed * step_at_end;
    constant.tail<3>() += reach_cross * end.constant.head<3>();
    if (load.growth) {
      const auto end_by_start = load.growth->bottomLeftCorner<6, 6>();
      stiffness += load.growth->topLeftCorner<6, 6>() + end_by_start;
      stiffness.bottomRows<3>() += reach_cross * end_by_start.topRows<3>();
    }

    Hung& carrier = hung_[index_of(parent)];
    const Vec3 arm = branch.start - bent[index_of(parent)].end;
    if (arm.isZero(0)) {
      carrier.constant += constant;
      carrier.stiffness += stiffness;
      continue;
    }
    const Mat6 by_arm = rigid_carry(arm);
    carrier.constant += by_arm.transpose() * constant;
    carrier.stiffness += by_arm.transpose() * stiffness * by_arm;
    const Vec3 start_force = wrenches_.at_start.segment<3>(6 * k);
    carrier.stiffness.bottomRightCorner<3, 3>() += cross_matrix(start_force) * cross_matrix(arm);
  }
}

Solver::Step Solver::follow(const std::vector<BentBranch>& bent) const {
  Step step{Eigen::VectorXd(tree_.size())};
  std::vector<Vec6> moved(tree_.parent.size());
  for (int k = 0; k < tree_.branch_count(); ++k) {
    const BentBranch& branch = bent[index_of(k)];
    const StrainMotion& moves = states_[index_of(k)].moves;
    const int parent = tree_.parent[index_of(k)];
    Vec6 start = Vec6::Zero();
    if (parent >= 0) start = carried(moved[index_of(parent)], branch.start - bent[index_of(parent)].end);
    const Vec6 own = answers_[index_of(k)].step + answers_[index_of(k)].follow * start;
    step.strains.segment<6>(6 * k) = own;
    Vec6& end = moved[index_of(k)];
    end = carried(start, branch.end - branch.start);
    end.head<3>() += moves.translation * own.head<3>();
    end.tail<3>() += moves.rotation * own.tail<3>();
    step.turn = std::max(step.turn, end.tail<3>().norm());
  }
  return step;
}

// A force among the ends of a branch, by how much of it each takes along and across the chord.
void share(const Vec3& direction, const Eigen::Vector2d& axial, const Eigen::Vector4d& deflection,
           const Vec3& force, EndLoads& loads) {
  const Vec3 along = direction * direction.dot(force), across = force - along,
             moment = direction.cross(force);
  loads.start_force += axial[0] * along + deflection[0] * across;
  loads.start_moment += deflection[1] * moment;
  loads.end_force += axial[1] * along + deflection[2] * across;
  loads.end_moment += deflection[3] * moment;
}

// Adds left right^T, of 12 x 3 each, column by column.
TREMULA_CLONES void add_product(const double* left, const double* right, double* growth) {
  constexpr int rows = 12, wide = 4, parts = rows / wide;
  Lanes<wide> of_left[3][parts];
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < parts; ++i) load(left + rows * j + wide * i, of_left[j][i]);
  }
  for (int column = 0; column < rows; ++column) {
    const double x = right[column], y = right[rows + column], z = right[2 * rows + column];
    for (int i = 0; i < parts; ++i) {
      Lanes<wide> sum;
      load(growth + rows * column + wide * i, sum);
      sum += of_left[0][i] * x + of_left[1][i] * y + of_left[2][i] * z;
      store(sum, growth + rows * column + wide * i);
    }
  }
}

// Adds point_shape turning turn_shape^T. The blocks of point_shape take turning along the chord and across
// it, or cross it with the chord.
void add_growth(const Shape& shape, const Vec3& direction, const Mat3& turning, EndGrowth& growth) {
  const Mat3 along = direction * (direction.transpose() * turning), across = turning - along;
  const Mat3 crossed = cross_matrix(direction) * turning;
  PointShape on_ends;
  on_ends.middleRows<3>(0) = shape.axial[0] * along + shape.deflection[0] * across;
  on_ends.middleRows<3>(3) = shape.deflection[1] * crossed;
  on_ends.middleRows<3>(6) = shape.axial[1] * along + shape.deflection[2] * across;
  on_ends.middleRows<3>(9) = shape.deflection[3] * crossed;
  add_product(on_ends.data(), turn_shape(shape, direction).data(), growth.data());
}

}  // namespace

void add_force(const Shape& shape, const Vec3& direction, const Vec3& force, const Mat3& turning,
               EndLoads& loads) {
  share(direction, shape.axial, shape.deflection, force, loads);
  if (turning.isZero(0)) return;
  if (!loads.growth) loads.growth = EndGrowth::Zero();
  add_growth(shape, direction, turning, *loads.growth);
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
  const Vec3 direction = branch.chord_frame * tree_.members[index_of(k)].direction;
  for (std::size_t i = first_[index_of(k)]; i < first_[index_of(k) + 1]; ++i) {
    const Shared& of = forces_[i];
    share(direction, of.axial, of.deflection, of.force, loads);
  }
}

Wrenches sum_wrenches(const BeamTree& tree, const std::vector<BentBranch>& bent, const BranchLoads& loads) {
  check_equal("bent branches", static_cast<std::ptrdiff_t>(bent.size()), tree.branch_count());
  return sum_loads(tree, bent, [&](int k) { return loads(k, bent[index_of(k)]); });
}

Eigen::VectorXd forces_on_strains(const BeamTree& tree, const Eigen::VectorXd& strains,
                                  const std::vector<BentBranch>& bent, const Eigen::VectorXd& at_end) {
  check_equal("rows of the strains", strains.size(), tree.size());
  check_equal("rows of the wrenches", at_end.size(), tree.size());
  Eigen::VectorXd forces(tree.size());
  for (int k = 0; k < tree.branch_count(); ++k) {
    const StrainMotion moves =
        StrainedBranch(tree.members[index_of(k)], bent[index_of(k)], strains.segment<6>(6 * k)).motion();
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
  double syrup = 0, too_thin = 0, error = 0;
  bool known = false, settled = true;  // the loads on this shape; and those that depend on all of it
  for (;; ++rest.steps) {
    if (!known) {
      if (options.on_shape) settled = options.on_shape(rest.bent);
      error = solver.look_at(rest.strains, rest.bent);
      known = true;
    }
    if (settled && error < options.tolerance) break;
    if (rest.steps == options.most_steps || !(error < 1e100) || syrup > thickest) {
      throw Error("equilibrium: the plant does not come to rest: after " + std::to_string(rest.steps) +
                  " steps the angles of branches are still " + std::to_string(error) +
                  " rad off; choose less wind, stiffer wood or thicker twigs");
    }
    const auto [step, turn] = solver.find_step(rest.bent, syrup);
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
    known = false;
  }
  rest.wrenches = solver.wrenches();
  return rest;
}

}  // namespace tremula
