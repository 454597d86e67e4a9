#include "tremula/modes/solve_problem.hpp"

#include <algorithm>
#include <string>

#include <gtest/gtest.h>

#include "tremula/base/error.hpp"

namespace tremula {
namespace {

// An operator that is symmetric to a few digits only: the first search is sure of no mode at all.
EigenProblem blurred_problem() {
  constexpr Eigen::Index size = 42;
  const Eigen::MatrixXd blur = Eigen::MatrixXd::Random(size, size);
  Eigen::MatrixXd form = 1e-3 * blur;
  for (Eigen::Index i = 0; i < size; ++i) form(i, i) += 1 / static_cast<double>((i + 1) * (i + 1));
  return {.size = size,
          .degrees_of_freedom = size,
          .apply =
              [form](Eigen::Ref<const Eigen::VectorXd> in, Eigen::Ref<Eigen::VectorXd> out) {
                out = form * in;
                return in.dot(out);
              },
          .displacement = [](Eigen::Ref<const Eigen::VectorXd> s) { return Eigen::VectorXd(s); },
          .count_below = [](double omega) { return std::min(42, static_cast<int>(omega * 1.001)); }};
}

TEST(SolveProblem, EndsInModesOrInAnErrorWhereTheFirstSearchFindsNone) {
  try {
    EXPECT_TRUE(solve_problem(blurred_problem(), 3, false, {.count = 3}).shapes.allFinite());
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
  }
}

TEST(SolveProblem, RefusesToCallFoundWhatIsNotCounted) {
  EigenProblem problem = blurred_problem();
  problem.apply = [](Eigen::Ref<const Eigen::VectorXd> in, Eigen::Ref<Eigen::VectorXd> out) {
    for (Eigen::Index i = 0; i < in.size(); ++i) out[i] = in[i] / static_cast<double>((i + 1) * (i + 1));
    return in.dot(out);
  };
  problem.count_below = [](double) { return 2; };
  EXPECT_THROW(solve_problem(problem, 3, false, {.count = 3}), InputError);
  EXPECT_THROW(solve_problem(problem, 3, true, {.count = 3}), InputError);
}

}  // namespace
}  // namespace tremula
