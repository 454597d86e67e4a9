// Modes of plants under their own weight.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>

#include "long_double_reference.hpp"
#include "support.hpp"
#include "trees.hpp"
#include "tremula/modes/solve_modes.hpp"
#include "tremula/structure/mode_count.hpp"
#include "tremula/structure/prestress.hpp"

namespace tremula {
namespace {

using std::numbers::pi;

nlohmann::json rods(const char* key) {
  return nlohmann::json::parse(std::ifstream(test::data_folder() / "rods.json"))["values"][key];
}

// omega^2 of the first four bending modes of a rod of L = EI = rho A = 1 and weight q per length.
Eigen::Array4d omega_squares(double q, int pieces, const Vec3& direction) {
  const double r = 1e-4, area = pi * r * r, second_moment = area * r * r / 4;
  const StructureOptions options{.material = {"rod", 1 / second_moment, 1 / second_moment, 1 / area, ""},
                                 .rotatory_inertia = false,
                                 .gravity = q};
  const Structure rod = assemble(test::straight_stem(pieces, 1, r, r, direction), options);
  const Modes modes = solve_modes(rod, {.count = 8});  // they come in pairs
  return modes.omega()(Eigen::seqN(0, 4, 2)).array().square();
}

void expect_rods(const char* key, const Vec3& direction) {
  const nlohmann::json rows = rods(key);
  ASSERT_FALSE(rows.empty());
  for (const auto& [load, values] : rows.items()) {
    SCOPED_TRACE(std::string(key) + " " + load);
    const double q = std::stod(load);
    Eigen::Array4d wanted;
    for (Eigen::Index i = 0; i < 4; ++i) wanted[i] = values[static_cast<std::size_t>(i)];
    const auto error = [&](int pieces) -> Eigen::Array4d {
      return omega_squares(q, pieces, direction) / wanted - 1;
    };
    const Eigen::Array4d coarse = error(16), fine = error(32);
    EXPECT_LT(fine.abs().maxCoeff(), 1e-4) << fine.transpose();
    const Eigen::Array4d order = (coarse / fine).log2();
    EXPECT_GT(order.minCoeff(), 3.5) << order.transpose();
  }
}

TEST(SolveModes, OfHeavyStandingRodsAgreeWithTheRowsAndConvergeWithTheFourthOrder) {
  TREMULA_NEED_DATA("rods.json");
  expect_rods("heavy.standing.omega2", Vec3::UnitZ());
}

TEST(SolveModes, OfHeavyHangingRodsAgreeWithTheRowsAndConvergeWithTheFourthOrder) {
  TREMULA_NEED_DATA("rods.json");
  expect_rods("heavy.hanging.omega2", -Vec3::UnitZ());
}

TEST(SolveModes, OfAHangingRodNearThoseOfAChainAsTheRowsDo) {
  TREMULA_NEED_DATA("rods.json");
  const nlohmann::json rows = rods("heavy.hanging.omega_over_sqrt(q/rhoA L)");
  ASSERT_FALSE(rows.empty());
  for (const auto& [load, values] : rows.items()) {
    const double q = std::stod(load);
    const Eigen::Array4d omega = (omega_squares(q, 64, -Vec3::UnitZ()) / q).sqrt();
    for (Eigen::Index i = 0; i < 4; ++i)
      EXPECT_NEAR(omega[i] / values[static_cast<std::size_t>(i)].get<double>(), 1, 1e-4) << load;
  }
}

// A rod that hardly resists bending is a chain, omega = j_{0,n}/2 sqrt(g/L), but for the layer sqrt(EI/qL) at
// its clamp, by which it is too short.
TEST(SolveModes, OfAHangingRodAreThoseOfAChainThatItsClampShortens) {
  constexpr double zero = 2.404825557695773;  // of J_0
  double off = 0.1;
  for (const double q : {1e3, 1e4, 1e5}) {
    const double omega = std::sqrt(omega_squares(q, 200, -Vec3::UnitZ())[0] / q);
    const double layers = (omega / (zero / 2) - 1) * std::sqrt(q);
    EXPECT_NEAR(layers, 0.5, off) << q;
    off /= 2;
  }
}

// Enough weight that it counts: half of what they can carry.
StructureOptions half_laden(const Skeleton& skeleton) {
  StructureOptions options{.material = find_material("green-wood")};
  const BeamTree tree = assemble_tree(skeleton, options);
  options.gravity *= 0.5 * load_margin(tree, geometric_stiffness(tree, weight(skeleton, options))).factor;
  return options;
}

TEST(SolveModes, OfRandomTreesUnderTheirWeightHaveTwelveDigitsOfALongDoubleReference) {
  for (const int branches : {17, 62, 212, 692}) {
    const Skeleton skeleton = test::random_tree(branches, 40);
    const StructureOptions options = half_laden(skeleton);
    for (const ModeMethod method : {ModeMethod::iterative, ModeMethod::dense}) {
      if (method == ModeMethod::dense && branches > 62) continue;
      const Modes modes = solve_modes(assemble(skeleton, options), {.count = 20, .method = method});
      const BeamTree tree = under_load(assemble_tree(skeleton, options), weight(skeleton, options));
      const test::LongVector exact = test::long_frequencies(tree, modes.shapes);
      const auto error = (modes.frequency.cast<long double>().cwiseQuotient(exact).array() - 1).abs();
      EXPECT_LT(static_cast<double>(error.maxCoeff()), 1e-12) << branches << " branches";
      EXPECT_EQ(modes.count_below, modes.count_by_inertia);
      const Modes without = solve_modes(assemble(skeleton, test::weightless(options)), {.count = 20});
      EXPECT_GT((without.frequency - modes.frequency).cwiseAbs().maxCoeff(), 1e-2 * without.frequency[0]);
    }
  }
}

TEST(SolveModes, UnderWeightAreAsManyAsAreCountedInEveryGap) {
  Skeleton skeleton = test::awkward_tree();
  skeleton.leaves.front().mass = 0.5;
  const StructureOptions options = half_laden(skeleton);
  const BeamTree tree = under_load(assemble_tree(skeleton, options), weight(skeleton, options));
  const Modes modes = solve_modes(assemble(skeleton, options), {.count = all_modes});
  EXPECT_EQ(count_modes_below(tree, 0), 0);
  for (int r = 0; r + 1 < modes.count(); ++r) {
    const double below = modes.omega()[r], above = modes.omega()[r + 1];
    if (above / below - 1 < 1e-9) continue;
    EXPECT_EQ(count_modes_below(tree, std::sqrt(below * above)), r + 1) << r;
  }
}

TEST(SolveModes, UnderWeightVanishWhereThePlantBuckles) {
  const Skeleton skeleton = test::random_tree(30, 7);
  StructureOptions options = half_laden(skeleton);
  options.gravity *= 2 * (1 - 1e-6);
  const Modes modes = solve_modes(assemble(skeleton, options), {.count = 2});
  const Modes without = solve_modes(assemble(skeleton, test::weightless(options)), {.count = 2});
  EXPECT_LT(modes.frequency[0], 3e-3 * without.frequency[0]);
  EXPECT_GT(modes.frequency[1], 0.1 * without.frequency[1]);
}

TEST(SolveModes, WithoutGravityAreThoseOfTheTreeWithoutLoadToTheBit) {
  const Skeleton skeleton = test::random_tree(62, 40);
  const Structure structure = assemble(skeleton, test::weightless());
  const BeamTree tree = assemble_tree(skeleton, {});
  const Eigen::VectorXd force = Eigen::VectorXd::Ones(tree.size());
  EXPECT_EQ(structure.flexibility(force), solve_static(tree, force));
  const EigenProblem problem = structure.eigen.problem(0, true);
  Eigen::VectorXd out(problem.size);
  problem.apply(force, out);
  EXPECT_EQ(out, apply_compliance_form(tree, force));
}

TEST(SolveModes, UnderWeightLeaveAShapeWithoutOtherLoadsWhereItIs) {
  const Skeleton skeleton = test::awkward_tree();
  const Structure structure = assemble(skeleton, {});
  EXPECT_EQ(structure.flexibility(Eigen::VectorXd::Zero(structure.size())).norm(), 0);
}

}  // namespace
}  // namespace tremula
