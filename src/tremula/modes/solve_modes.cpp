#include "tremula/modes/solve_modes.hpp"

#include "tremula/base/error.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include <Spectra/SymEigsSolver.h>
#include <Eigen/Eigenvalues>

namespace tremula {
namespace {

// The compliance form as Spectra wants its operators.
class ComplianceForm {
 public:
  using Scalar = double;
  explicit ComplianceForm(const Structure& structure) : structure_(structure) {}
  Eigen::Index rows() const { return structure_.size(); }
  Eigen::Index cols() const { return structure_.size(); }
  void perform_op(const double* in, double* out) const {
    Eigen::VectorXd::Map(out, rows()) = apply_compliance_form(structure_, Eigen::VectorXd::Map(in, rows()));
    ++count_;
  }
  int count() const { return count_; }

 private:
  const Structure& structure_;
  mutable int count_ = 0;
};

// omega^-2, largest first, and the unit vectors of the compliance form that belong to them.
struct Eigenpairs {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
  int operator_count;
};

Eigenpairs solve_dense(const Structure& structure, int count) {
  const Eigen::Index size = structure.size();
  Eigen::MatrixXd form(size, size);
  for (Eigen::Index i = 0; i < size; ++i) {
    form.col(i) = apply_compliance_form(structure, Eigen::VectorXd::Unit(size, i));
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(0.5 * (form + form.transpose()));
  if (solver.info() != Eigen::Success) throw Error("modes: the dense eigenvalue solver did not converge");
  return {solver.eigenvalues().reverse().head(count),
          solver.eigenvectors().rowwise().reverse().leftCols(count), static_cast<int>(size)};
}

Eigenpairs solve_iteratively(const Structure& structure, int count, double tolerance) {
  const Eigen::Index size = structure.size();
  ComplianceForm form(structure);
  const Eigen::Index basis = std::min<Eigen::Index>(size, std::max(2 * count + 20, 40));
  Spectra::SymEigsSolver<ComplianceForm> solver(form, count, basis);
  solver.init();
  solver.compute(Spectra::SortRule::LargestAlge, 1000, tolerance);
  if (solver.info() != Spectra::CompInfo::Successful) {
    throw Error(
        "modes: the iteration did not converge in 1000 restarts; ask for fewer modes or a larger tolerance");
  }
  return {solver.eigenvalues(), solver.eigenvectors(), form.count()};
}

bool dense_is_better(Eigen::Index size, int count) { return size <= 240 || 3 * count >= size; }

}  // namespace

Modes solve_modes(const Structure& structure, const ModeOptions& options) {
  const auto size = static_cast<int>(structure.size());
  const int count = options.count == all_modes ? size : options.count;
  if (count < 1 || count > size) {
    throw InputError("mode count", std::to_string(count),
                     "1 to " + std::to_string(size) + " (six for each of the " +
                         std::to_string(structure.branch_count()) + " branches)");
  }
  const bool dense = options.method == ModeMethod::dense ||
                     (options.method == ModeMethod::automatic && dense_is_better(structure.size(), count));
  const Eigenpairs pairs =
      dense ? solve_dense(structure, count) : solve_iteratively(structure, count, options.tolerance);

  Modes modes;
  modes.operator_count = pairs.operator_count;
  modes.frequency.resize(count);
  modes.residual.resize(count);
  modes.error_bound.resize(count);
  modes.shapes.resize(size, count);
  for (int r = 0; r < count; ++r) {
    const double value = pairs.values[r];
    if (!(value > 0)) throw Error("modes: a mode is too stiff to be resolved; ask for fewer modes");
    const double omega = 1 / std::sqrt(value);
    const Eigen::VectorXd s = pairs.vectors.col(r);
    modes.frequency[r] = omega / (2 * std::numbers::pi);
    modes.residual[r] = (apply_compliance_form(structure, s) - value * s).norm() / value;
    // |lambda error| <= residual for a symmetric operator; half of it for the square root.
    modes.error_bound[r] = 0.5 * modes.residual[r];
    Eigen::VectorXd shape = omega * displacement_from_compliance_form(structure, s);
    Eigen::Index largest = 0;
    shape.cwiseAbs().maxCoeff(&largest);
    modes.shapes.col(r) = shape[largest] < 0 ? Eigen::VectorXd(-shape) : shape;
  }
  return modes;
}

}  // namespace tremula
