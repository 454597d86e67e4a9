#include "tremula/modes/solve_modes.hpp"

#include "tremula/base/error.hpp"
#include "tremula/modes/inertia.hpp"
#include "tremula/modes/solve_problem.hpp"
#include "tremula/structure/compliance_operator.hpp"

#include <cmath>
#include <memory>
#include <numbers>
#include <string>

namespace tremula {
namespace {

// The compliance form in the structure's own order: 6N numbers and no lanes that stay empty.
EigenProblem plain_problem(const Structure& structure) {
  return {.size = structure.size(),
          .degrees_of_freedom = structure.size(),
          .apply =
              [&structure](Eigen::Ref<const Eigen::VectorXd> in, Eigen::Ref<Eigen::VectorXd> out) {
                out = apply_compliance_form(structure, in);
                return in.dot(out);
              },
          .displacement =
              [&structure](Eigen::Ref<const Eigen::VectorXd> s) {
                return displacement_from_compliance_form(structure, s);
              },
          .count_below = [&structure](double omega) { return count_modes_below(structure, omega); }};
}

}  // namespace

EigenProblem eigen_problem(const Structure& structure) {
  EigenProblem problem = plain_problem(structure);
  const auto compliance_operator = std::make_shared<ComplianceOperator>(structure);
  problem.size = compliance_operator->size();
  problem.apply = [compliance_operator](Eigen::Ref<const Eigen::VectorXd> in,
                                        Eigen::Ref<Eigen::VectorXd> out) {
    return compliance_operator->apply(in, out);
  };
  problem.displacement = [compliance_operator, &structure](Eigen::Ref<const Eigen::VectorXd> s) {
    return displacement_from_compliance_form(structure, compliance_operator->unpacked(s));
  };
  return problem;
}

Modes solve_modes(const Structure& structure, const ModeOptions& options) {
  const int count =
      mode_count(options, structure.size(),
                 "six for each of the " + std::to_string(structure.branch_count()) + " branches");
  const bool dense = dense_is_better(options, structure.size(), count);
  return solve_problem(dense ? plain_problem(structure) : eigen_problem(structure), count, dense, options);
}

Modes solve_modes_up_to(const Structure& structure, double frequency, const ModeOptions& options) {
  if (!std::isfinite(frequency) || frequency <= 0) {
    throw InputError("highest frequency", std::to_string(frequency), "a frequency above 0 Hz");
  }
  ModeOptions counted = options;
  counted.count = count_modes_below(structure, 2 * std::numbers::pi * frequency);
  if (counted.count == 0) {
    throw InputError("highest frequency", std::to_string(frequency) + " Hz, below which there is no mode",
                     "a higher one");
  }
  return solve_modes(structure, counted);
}

}  // namespace tremula
