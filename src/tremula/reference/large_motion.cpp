#include "tremula/reference/large_motion.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/error.hpp"
#include "tremula/numerics/quadrature.hpp"
#include "tremula/numerics/rotation.hpp"
#include "tremula/structure/element_blocks.hpp"

#include <cmath>
#include <numbers>
#include <string>
#include <utility>

namespace tremula {
namespace {

using Vec12 = Eigen::Matrix<double, 12, 1>;
using Mat12 = Eigen::Matrix<double, 12, 12>;

void check_not_below_0(const char* what, double value) {
  if (!std::isfinite(value) || value < 0) throw InputError(what, std::to_string(value), "0 or more");
}

// Forces and moments on both ends of a branch, in the order of EndGrowth.
EndLoads end_loads(const Vec12& forces) {
  return {forces.head<3>(), forces.segment<3>(3), forces.segment<3>(6), forces.tail<3>()};
}

Mat12 mass_of(const ElementMass& element, const Vec3& direction) {
  const ElementBlocks blocks = mass_blocks(element, direction);
  Mat12 mass;
  mass << blocks.start, blocks.cross, blocks.cross.transpose(), blocks.end;
  return mass;
}

// A force and what it makes of another relative wind, and of a branch that turns.
struct Drag {
  Vec3 force = Vec3::Zero();
  Mat3 per_velocity = Mat3::Zero(), turning = Mat3::Zero();
};

// factor |u| u of the part u of the wind across the axis.
Drag drag_across(double factor, const Vec3& axis, const Vec3& wind) {
  const double along = wind.dot(axis);
  const Vec3 across = wind - along * axis;
  const double speed = across.norm();
  if (speed == 0) return {};
  const Vec3 n = across / speed;
  const Mat3 slope = factor * speed * (Mat3::Identity() + n * n.transpose());
  const Mat3 axis_turns = -cross_matrix(axis);
  return {factor * speed * across, slope * (Mat3::Identity() - axis * axis.transpose()),
          -slope * (along * axis_turns + axis * (wind.transpose() * axis_turns))};
}

// factor C(|v|) |v| v.
Drag drag_on_leaf(double factor, const std::function<double(double)>& coefficient, const Vec3& wind) {
  const double speed = wind.norm();
  if (speed == 0) return {};
  const double nearby = 1.001 * speed, drag = coefficient(speed) * speed;
  const double slope = (coefficient(nearby) * nearby - drag) / (nearby - speed);
  return {factor * drag * wind, factor * (drag * Mat3::Identity() + slope / speed * wind * wind.transpose())};
}

// Where the wind takes hold of a branch.
struct Place {
  double s;  // 0 start … 1 end
  Shape shape;
  bool is_leaf;
  double half_rho_area;  // times the drag coefficient, of wood
};

std::vector<std::vector<Place>> places_of(const BeamTree& tree, const WeightAndDrag& surroundings) {
  check_not_below_0("fluid density", surroundings.fluid_density);
  check_not_below_0("branch drag coefficient", surroundings.branch_drag_coefficient);
  static const std::vector<QuadraturePoint> quadrature = gauss_legendre(4);
  const double half_rho = 0.5 * surroundings.fluid_density;
  std::vector<std::vector<Place>> places(tree.parent.size());
  for (std::size_t k = 0; k < places.size(); ++k) {
    const Beam& beam = tree.members[k].beam;
    for (const QuadraturePoint& point : quadrature) {
      const double s = point.position;
      const double area =
          2 * (beam.start_radius + s * (beam.end_radius - beam.start_radius)) * beam.length * point.weight;
      places[k].push_back(
          {s, shape_at(beam, s), false, half_rho * surroundings.branch_drag_coefficient * area});
    }
  }
  for (const BladeSite& leaf : surroundings.leaves) {
    if (leaf.member < 0 || leaf.member >= tree.branch_count()) {
      throw InputError("branch of a leaf", std::to_string(leaf.member),
                       "0 to " + std::to_string(tree.branch_count() - 1));
    }
    const std::size_t k = index_of(leaf.member);
    places[k].push_back({leaf.place, shape_at(tree.members[k].beam, leaf.place), true, half_rho * leaf.area});
  }
  return places;
}

// What acts on the branches of a tree from outside.
class Outside {
 public:
  Outside(const BeamTree& tree, const WeightAndDrag& surroundings)
      : tree_(tree), surroundings_(surroundings), places_(places_of(tree, surroundings)) {
    for (std::size_t k = 0, site = 0; k < places_.size(); site += places_[k++].size())
      first_site_.push_back(site);
    gravity_ << surroundings.gravity, Vec3::Zero(), surroundings.gravity, Vec3::Zero();
  }

  // Translations and rotations of both ends that speed up as all that falls does.
  const Vec12& gravity() const { return gravity_; }

  // Adds the drag on branch k whose ends have a velocity; damping: what takes -J v from the ends, (12 x 12).
  void add_drag(int k, const BentBranch& branch, double time, const Vec12& velocity, EndLoads& loads,
                Mat12& damping) const {
    if (surroundings_.fluid_density == 0) return;
    const Member& member = tree_.members[index_of(k)];
    const Vec3 direction = branch.chord_frame * member.direction;
    std::size_t site = first_site_[index_of(k)];
    Vec12 forces = Vec12::Zero();
    EndGrowth growth = EndGrowth::Zero();
    for (const Place& place : places_[index_of(k)]) {
      const PointShape shape = point_shape(place.shape, direction);
      const BentPoint point = point_on(member, branch, place.s);
      Vec3 wind = -shape.transpose() * velocity;
      if (surroundings_.wind) wind += surroundings_.wind(site, time, point.position);
      const Drag drag = drag_at(place, point.frame * member.direction, wind);
      forces += shape * drag.force;
      // Lazy, because Eigen would take its product of large matrices for this one.
      const Eigen::Matrix<double, 3, 12> per_end = drag.per_velocity * shape.transpose();
      damping.noalias() += shape.lazyProduct(per_end);
      const Eigen::Matrix<double, 12, 3> on_ends = shape * drag.turning;
      growth.noalias() += on_ends.lazyProduct(turn_shape(place.shape, direction).transpose());
      ++site;
    }
    loads.growth = growth;
    loads.start_force += forces.head<3>();
    loads.start_moment += forces.segment<3>(3);
    loads.end_force += forces.segment<3>(6);
    loads.end_moment += forces.tail<3>();
  }

 private:
  Drag drag_at(const Place& place, const Vec3& axis, const Vec3& wind) const {
    if (!place.is_leaf) return drag_across(place.half_rho_area, axis, wind);
    if (!surroundings_.leaf_drag_coefficient) return {};
    return drag_on_leaf(place.half_rho_area, surroundings_.leaf_drag_coefficient, wind);
  }

  const BeamTree& tree_;
  WeightAndDrag surroundings_;
  std::vector<std::vector<Place>> places_;
  std::vector<std::size_t> first_site_{};
  Vec12 gravity_;
};

// One step of whatever moves by increments: with a the unknown, n the instant before,
//   increment = step velocity_n + increment_from_a[0] a_n + increment_from_a[1] a
//   velocity = velocity_n + velocity_from_a[0] a_n + velocity_from_a[1] a
//   acceleration = -from_acceleration acceleration_n + acceleration_from_a[0] a_n + acceleration_from_a[1] a.
struct Scheme {
  double step;
  double increment_from_a[2], velocity_from_a[2], acceleration_from_a[2], from_acceleration;

  // How velocity and acceleration grow with the increment.
  double velocity_slope() const { return velocity_from_a[1] / increment_from_a[1]; }
  double acceleration_slope() const { return acceleration_from_a[1] / increment_from_a[1]; }
};

Scheme generalised_alpha(double h, double radius) {
  const double alpha_m = (2 * radius - 1) / (radius + 1), alpha_f = radius / (radius + 1);
  const double gamma = 0.5 - alpha_m + alpha_f, beta = 0.25 * std::pow(1 - alpha_m + alpha_f, 2);
  return {.step = h,
          .increment_from_a = {h * h * (0.5 - beta), h * h * beta},
          .velocity_from_a = {h * (1 - gamma), h * gamma},
          .acceleration_from_a = {alpha_m / (1 - alpha_f), (1 - alpha_m) / (1 - alpha_f)},
          .from_acceleration = alpha_f / (1 - alpha_f)};
}

// Of the first order, and nothing that is too fast for it is left after one step.
Scheme backward_euler(double h) {
  return {.step = h,
          .increment_from_a = {0, h * h},
          .velocity_from_a = {0, h},
          .acceleration_from_a = {0, 1},
          .from_acceleration = 0};
}

// What a scheme keeps of something that moves. algorithmic: a.
template <class Vector>
struct Rates {
  Vector velocity, acceleration, algorithmic;
};

template <class Vector>
Rates<Vector> advanced(const Scheme& scheme, const Rates<Vector>& n, const Vector& increment) {
  const Vector a = (increment - scheme.step * n.velocity - scheme.increment_from_a[0] * n.algorithmic) /
                   scheme.increment_from_a[1];
  return {n.velocity + scheme.velocity_from_a[0] * n.algorithmic + scheme.velocity_from_a[1] * a,
          scheme.acceleration_from_a[0] * n.algorithmic + scheme.acceleration_from_a[1] * a -
              scheme.from_acceleration * n.acceleration,
          a};
}

// An end of a branch at the instant before, and how it moves in world axes.
struct MovingEnd {
  Vec3 position = Vec3::Zero();
  Mat3 frame = Mat3::Identity();
  Rates<Vec6> rates{Vec6::Zero(), Vec6::Zero(), Vec6::Zero()};

  Vec6 increment(const Vec3& now, const Mat3& frame_now) const {
    Vec6 moved;
    moved << now - position, rotation_vector(frame_now * frame.transpose());
    return moved;
  }
};

struct MovingBranch {
  MovingEnd start, end;
};

// How the rotation of a step grows when the end turns: the inverse of rotation_tangent to second order.
Mat3 increment_per_turn(const Vec6& increment) {
  return Mat3::Identity() - 0.5 * cross_matrix(increment.tail<3>());
}

void check_settings(const BeamTree& tree, const LargeMotionSettings& settings) {
  if (!std::isfinite(settings.step) || settings.step <= 0)
    throw InputError("time step", std::to_string(settings.step), "a number above 0");
  check_at_least("number of time steps", settings.step_count, 1);
  if (!(settings.high_frequency_radius >= 0 && settings.high_frequency_radius <= 1)) {
    throw InputError("high-frequency radius", std::to_string(settings.high_frequency_radius), "0 to 1");
  }
  check_not_below_0("mass-proportional damping", settings.damping.mass);
  check_not_below_0("stiffness-proportional damping", settings.damping.stiffness);
  const auto check = [&](const std::string& what, const Eigen::VectorXd& vector) {
    if (vector.size() == 0) return;
    check_equal(("rows of " + what).c_str(), vector.size(), tree.size());
    if (!vector.allFinite()) throw InputError(what, "an entry that is no number", "numbers");
  };
  check("the forces at rest", settings.at_rest);
  check("the strains to start with", settings.strains);
  check("the velocity to start with", settings.velocity);
}

Eigen::VectorXd given_or_zero(const Eigen::VectorXd& vector, Eigen::Index size) {
  return vector.size() > 0 ? vector : Eigen::VectorXd(Eigen::VectorXd::Zero(size));
}

class LargeMotion {
 public:
  LargeMotion(const BeamTree& tree, const WeightAndDrag& surroundings, const LargeMotionSettings& settings)
      : tree_(tree),
        settings_(settings),
        outside_(tree, surroundings),
        at_rest_(given_or_zero(settings.at_rest, tree.size())),
        damped_(tree) {
    for (int k = 0; k < tree.branch_count(); ++k) {
      stiffness_.push_back(
          stiffness_blocks(tree.compliances[index_of(k)], tree.members[index_of(k)].direction, Vec3::Zero())
              .end);
    }
    state_.strains = given_or_zero(settings.strains, tree.size());
    state_.velocity = given_or_zero(settings.velocity, tree.size());
    state_.bent = bend(tree, state_.strains);
    place_ends();
    find_accelerations();
    use(generalised_alpha(settings.step, settings.high_frequency_radius));
  }

  const LargeMotionState& state() const { return state_; }

  void advance(double time) {
    Equilibrium next = equilibrium_at(time);
    for (int k = 0; k < tree_.branch_count(); ++k) {
      const BentBranch& branch = next.bent[index_of(k)];
      MovingBranch& moving = moving_[index_of(k)];
      move(moving.start, branch.start, branch.start_frame);
      move(moving.end, branch.end, branch.end_frame);
      state_.velocity.segment<6>(6 * k) = moving.end.rates.velocity;
    }
    strain_rates_ = advanced<Eigen::VectorXd>(scheme_, strain_rates_, next.strains - state_.strains);
    take(std::move(next));
  }

 private:
  // Where the ends stand at first, and how fast they move.
  void place_ends() {
    for (int k = 0; k < tree_.branch_count(); ++k) {
      const BentBranch& branch = state_.bent[index_of(k)];
      MovingBranch moving;
      moving.start.position = branch.start;
      moving.start.frame = branch.start_frame;
      moving.end.position = branch.end;
      moving.end.frame = branch.end_frame;
      moving.end.rates.velocity = state_.velocity.segment<6>(6 * k);
      if (const int parent = tree_.parent[index_of(k)]; parent >= 0) {
        moving.start.rates.velocity = rigid_carry(branch.start - state_.bent[index_of(parent)].end) *
                                      state_.velocity.segment<6>(6 * parent);
      }
      moving_.push_back(moving);
    }
    const Eigen::VectorXd none = Eigen::VectorXd::Zero(tree_.size());
    strain_rates_ = {strains_about(tree_, state_.strains, state_.bent, state_.velocity), none, none};
  }

  // From a step of a fraction of the real one, which leaves out what is too fast for it: M^-1 f would have
  // the stiffest branches throw about what little their strains are off.
  void find_accelerations() {
    use(backward_euler(settings_.step / 16));
    const Equilibrium moved = equilibrium_at(0);
    for (int k = 0; k < tree_.branch_count(); ++k) {
      const BentBranch& branch = moved.bent[index_of(k)];
      MovingBranch& moving = moving_[index_of(k)];
      speed_up(moving.start.rates, moving.start.increment(branch.start, branch.start_frame));
      speed_up(moving.end.rates, moving.end.increment(branch.end, branch.end_frame));
    }
    speed_up(strain_rates_, Eigen::VectorXd(moved.strains - state_.strains));
    state_.wrenches = moved.wrenches;
  }

  template <class Vector>
  void speed_up(Rates<Vector>& rates, const Vector& increment) const {
    rates.algorithmic = rates.acceleration = advanced(scheme_, rates, increment).acceleration;
  }

  // Stress in proportion to the rate of the strains, which is part of the strains and part of what is known:
  // the former makes every branch stiffer, the latter is a force (equilibrium_at).
  void use(const Scheme& scheme) {
    scheme_ = scheme;
    const double softer = 1 / (1 + settings_.damping.stiffness * scheme.velocity_slope());
    for (std::size_t k = 0; k < damped_.compliances.size(); ++k) {
      const Compliance& c = tree_.compliances[k];
      damped_.compliances[k] = {softer * c.axial,      softer * c.torsion,
                                softer * c.deflection, softer * c.deflection_slope,
                                softer * c.slope,      softer * c.slope_held};
    }
  }

  Equilibrium equilibrium_at(double time) const {
    EquilibriumOptions options{.at_rest = at_rest_, .tolerance = settings_.tolerance};
    if (settings_.damping.stiffness > 0) {
      const Eigen::VectorXd rate_unstrained =
          advanced<Eigen::VectorXd>(scheme_, strain_rates_, -state_.strains).velocity;
      for (int k = 0; k < tree_.branch_count(); ++k) {
        options.at_rest.segment<6>(6 * k) +=
            settings_.damping.stiffness * stiffness_[index_of(k)] * rate_unstrained.segment<6>(6 * k);
      }
    }
    const double h = scheme_.step;
    options.start = state_.strains + h * strain_rates_.velocity + 0.5 * h * h * strain_rates_.algorithmic;
    try {
      return find_equilibrium(
          damped_, [&](int k, const BentBranch& branch) { return loads(k, branch, time); }, options);
    } catch (const InputError&) {
      throw;
    } catch (const Error& error) {
      throw Error("time integration: at t = " + std::to_string(time) + " s: " + error.what());
    }
  }

  // Inertia, weight, and drag of still and of moving air.
  EndLoads loads(int k, const BentBranch& branch, double time) const {
    const MovingBranch& before = moving_[index_of(k)];
    const Vec6 start_increment = before.start.increment(branch.start, branch.start_frame);
    const Vec6 end_increment = before.end.increment(branch.end, branch.end_frame);
    const Rates<Vec6> start = advanced(scheme_, before.start.rates, start_increment);
    const Rates<Vec6> end = advanced(scheme_, before.end.rates, end_increment);
    Vec12 velocity, acceleration;
    velocity << start.velocity, end.velocity;
    acceleration << start.acceleration, end.acceleration;

    const Mat12 mass =
        mass_of(tree_.masses[index_of(k)], branch.chord_frame * tree_.members[index_of(k)].direction);
    const double drag = settings_.damping.mass;
    EndLoads result = end_loads(mass * (outside_.gravity() - acceleration - drag * velocity));
    Mat12 damping = drag * mass;
    outside_.add_drag(k, branch, time, velocity, result, damping);
    EndGrowth growth = -scheme_.acceleration_slope() * mass - scheme_.velocity_slope() * damping;
    growth.middleCols<3>(3) *= increment_per_turn(start_increment);
    growth.rightCols<3>() *= increment_per_turn(end_increment);
    result.growth = growth + result.growth.value_or(EndGrowth::Zero());
    return result;
  }

  void move(MovingEnd& end, const Vec3& position, const Mat3& frame) const {
    end.rates = advanced(scheme_, end.rates, end.increment(position, frame));
    end.position = position;
    end.frame = frame;
  }

  void take(Equilibrium&& next) {
    state_.strains = std::move(next.strains);
    state_.bent = std::move(next.bent);
    state_.wrenches = std::move(next.wrenches);
    state_.iterations = next.steps;
  }

  const BeamTree& tree_;
  const LargeMotionSettings& settings_;
  Outside outside_;
  Eigen::VectorXd at_rest_;
  BeamTree damped_;
  std::vector<Mat6> stiffness_{};
  Scheme scheme_{};
  std::vector<MovingBranch> moving_{};
  Rates<Eigen::VectorXd> strain_rates_{};
  LargeMotionState state_{};
};

}  // namespace

BranchLoads loads_at_rest(const BeamTree& tree, const WeightAndDrag& surroundings, double time) {
  return [&tree, outside = Outside(tree, surroundings), time](int k, const BentBranch& branch) {
    const Mat12 mass =
        mass_of(tree.masses[index_of(k)], branch.chord_frame * tree.members[index_of(k)].direction);
    EndLoads loads = end_loads(mass * outside.gravity());
    Mat12 damping = Mat12::Zero();
    outside.add_drag(k, branch, time, Vec12::Zero(), loads, damping);
    return loads;
  };
}

RayleighDamping rayleigh_damping(double ratio, double frequency, double other_frequency) {
  check_not_below_0("damping ratio", ratio);
  for (const double f : {frequency, other_frequency}) {
    if (!std::isfinite(f) || f <= 0)
      throw InputError("frequency of a damping ratio", std::to_string(f), "a number above 0");
  }
  if (frequency == other_frequency) {
    throw InputError("frequencies of a damping ratio", "twice " + std::to_string(frequency), "two of them");
  }
  const double omega = 2 * std::numbers::pi * frequency, other = 2 * std::numbers::pi * other_frequency;
  return {2 * ratio * omega * other / (omega + other), 2 * ratio / (omega + other)};
}

LargeMotionState integrate_large_motion(const BeamTree& tree, const WeightAndDrag& surroundings,
                                        const LargeMotionSettings& settings,
                                        const LargeMotionObserver& observer) {
  check_settings(tree, settings);
  LargeMotion motion(tree, surroundings, settings);
  if (observer) observer(0, motion.state());
  for (int i = 1; i <= settings.step_count; ++i) {
    motion.advance(i * settings.step);
    if (observer) observer(i, motion.state());
  }
  return motion.state();
}

}  // namespace tremula
