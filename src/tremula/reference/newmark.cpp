#include "tremula/reference/newmark.hpp"

#include "tremula/base/error.hpp"

#include <cmath>
#include <string>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseLU>

namespace tremula {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

void check_matrix(const char* name, const Sparse& matrix, Eigen::Index size) {
  if (matrix.rows() != size || matrix.cols() != size) {
    throw InputError(name, std::to_string(matrix.rows()) + " x " + std::to_string(matrix.cols()),
                     std::to_string(size) + " x " + std::to_string(size));
  }
  if (!std::isfinite(matrix.sum())) throw InputError(name, "an entry that is no number", "numbers");
}

void check_vector(const std::string& name, const Eigen::VectorXd& vector, Eigen::Index size) {
  if (vector.size() != size) {
    throw InputError(name, std::to_string(vector.size()) + " rows", std::to_string(size));
  }
  if (!vector.allFinite()) throw InputError(name, "an entry that is no number", "numbers");
}

// The method for one step, factorised once.
class Newmark {
 public:
  Newmark(const SparseMatrices& matrices, const Sparse& damping, const ForceAtTime& force, double step)
      : matrices_(matrices), damping_(damping), force_(force), step_(step) {
    if (!std::isfinite(step) || step <= 0) {
      throw InputError("time step", std::to_string(step), "a number above 0");
    }
    const Eigen::Index size = matrices.mass.rows();
    if (size == 0) throw InputError("mass matrix", "0 rows", "1 or more");
    check_matrix("mass matrix", matrices.mass, size);
    check_matrix("stiffness matrix", matrices.stiffness, size);
    check_matrix("damping matrix", damping, size);
    // Of the full pattern of all three, so that SparseLU gets it compressed.
    Sparse effective = matrices.stiffness + 2 / step * damping;
    effective += 4 / (step * step) * matrices.mass;
    effective.makeCompressed();
    effective_.compute(effective);
    if (effective_.info() != Eigen::Success) {
      throw Error("time integration: the matrix K + 2/h C + 4/h^2 M is singular");
    }
  }

  Eigen::Index size() const { return matrices_.mass.rows(); }

  TimeState start(const TimeState& initial) const {
    check_vector("initial displacement", initial.displacement, size());
    check_vector("initial velocity", initial.velocity, size());
    const Eigen::SimplicialLLT<Sparse> mass(matrices_.mass);
    if (mass.info() != Eigen::Success) {
      throw Error("time integration: the mass matrix is not positive definite");
    }
    TimeState state = initial;
    state.acceleration =
        mass.solve(force_at(0) - damping_ * initial.velocity - matrices_.stiffness * initial.displacement);
    return state;
  }

  // Where the force of t = 0 holds it.
  TimeState start_at_rest() const {
    const Eigen::SimplicialLLT<Sparse> stiffness(matrices_.stiffness);
    if (stiffness.info() != Eigen::Success) {
      throw Error("time integration: the stiffness matrix is not positive definite");
    }
    return start({stiffness.solve(force_at(0)), Eigen::VectorXd::Zero(size()), {}});
  }

  // From one instant to the next, at `time`. The unknown is the change of the displacement, so that nothing
  // of order 1/h^2 times the displacement cancels.
  void advance(TimeState& state, double time) const {
    const Eigen::VectorXd inertia = 4 / step_ * state.velocity + state.acceleration;
    Eigen::VectorXd right = force_at(time);
    right -= matrices_.stiffness * state.displacement;
    right += matrices_.mass * inertia;
    right += damping_ * state.velocity;
    const Eigen::VectorXd change = effective_.solve(right);
    state.displacement += change;
    state.velocity = 2 / step_ * change - state.velocity;
    state.acceleration = 4 / (step_ * step_) * change - inertia;
    if (!state.acceleration.allFinite()) {
      throw Error("time integration: the motion grows beyond all numbers by t = " + std::to_string(time) +
                  " s");
    }
  }

 private:
  Eigen::VectorXd force_at(double time) const {
    Eigen::VectorXd force = force_(time);
    check_vector("force at t = " + std::to_string(time) + " s", force, size());
    return force;
  }

  const SparseMatrices& matrices_;
  const Sparse& damping_;
  const ForceAtTime& force_;
  double step_;
  Eigen::SparseLU<Sparse> effective_;
};

}  // namespace

TimeState integrate_newmark(const SparseMatrices& matrices, const Sparse& damping, const ForceAtTime& force,
                            const TimeState& initial, const TimeIntegration& settings,
                            const TimeObserver& observer) {
  if (settings.step_count < 1) {
    throw InputError("number of time steps", std::to_string(settings.step_count), "1 or more");
  }
  const Newmark newmark(matrices, damping, force, settings.step);
  TimeState state = newmark.start(initial);
  if (observer) observer(0, state);
  for (int i = 1; i <= settings.step_count; ++i) {
    newmark.advance(state, i * settings.step);
    if (observer) observer(i, state);
  }
  return state;
}

PeriodicResponse periodic_response(const SparseMatrices& matrices, const Sparse& damping,
                                   const ForceAtTime& force, const TimeAxis& axis,
                                   const PeriodicIntegration& settings) {
  const auto check_count = [](const char* name, int value, int least) {
    if (value < least) throw InputError(name, std::to_string(value), std::to_string(least) + " or more");
  };
  check_count("number of samples", axis.sample_count, 1);
  check_count("time steps per sample", settings.steps_per_sample, 1);
  check_count("largest number of loops", settings.largest_loop_count, 1);
  if (!std::isfinite(settings.tolerance) || settings.tolerance <= 0) {
    throw InputError("tolerance of the periodic response", std::to_string(settings.tolerance),
                     "a number above 0");
  }
  const double step = axis.period / axis.sample_count / settings.steps_per_sample;
  const Newmark newmark(matrices, damping, force, step);
  TimeState state = newmark.start_at_rest();
  Eigen::MatrixXd before = Eigen::MatrixXd::Zero(newmark.size(), axis.sample_count);
  PeriodicResponse response{before, 0, 1};
  double change_before = 0;
  while (response.loop_count < settings.largest_loop_count) {
    // Every loop starts at t = 0 again: the force is the same to the last bit.
    for (int p = 0; p < axis.sample_count; ++p) {
      response.displacement.col(p) = state.displacement;
      for (int i = 1; i <= settings.steps_per_sample; ++i) {
        newmark.advance(state, (p * settings.steps_per_sample + i) * step);
      }
    }
    ++response.loop_count;
    const double change = (response.displacement - before).norm();
    const double size = response.displacement.norm();
    // The first loop may be at rest at all samples (there may be but one), and yet not repeat.
    if (response.loop_count > 1 && (change == 0 || change < change_before)) {
      response.missing = change == 0 ? 0 : change / (change_before / change - 1) / size;
      if (response.missing <= settings.tolerance) return response;
    }
    change_before = change;
    before.swap(response.displacement);
  }
  throw Error("time integration: the motion does not repeat to " + std::to_string(settings.tolerance) +
              " after " + std::to_string(settings.largest_loop_count) + " loops of " +
              std::to_string(axis.period) + " s");
}

}  // namespace tremula
