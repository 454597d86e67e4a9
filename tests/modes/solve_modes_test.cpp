#include "tremula/modes/solve_modes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Spectra/SymEigsSolver.h>
#include <tbb/global_control.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "complaint.hpp"
#include "long_double_reference.hpp"
#include "structure/assembled.hpp"
#include "support.hpp"
#include "trees.hpp"
#include "tremula/base/error.hpp"
#include "tremula/structure/mode_count.hpp"

namespace tremula {
namespace {

nlohmann::json reference() {
  return nlohmann::json::parse(std::ifstream(test::data_folder() / "modes/random_tree_62_frequencies.json"));
}

TEST(SolveModes, AgreesWithTheLongDoubleReferenceForEveryMaterialAndSection) {
  TREMULA_NEED_DATA("modes/random_tree_62_frequencies.json");
  const Skeleton skeleton = test::cylinders_from_text(test::data_folder() / "modes/random_tree_62.txt");
  ASSERT_EQ(skeleton.branch_count(), 62);
  const nlohmann::json sets = reference().at("sets");
  ASSERT_EQ(sets.size(), 6U);
  for (const auto& set : sets) {
    StructureOptions options;
    options.material = {"reference", set["youngs_modulus"], set["shear_modulus"], set["density"], ""};
    options.section = set["section_factor"] == 4.0 ? Section::paper : Section::exact;
    options.rotatory_inertia = set["rotatory_inertia"];
    const Structure structure = assemble(skeleton, test::weightless(options));
    for (const ModeMethod method : {ModeMethod::dense, ModeMethod::iterative}) {
      const Modes modes = solve_modes(structure, {.count = 40, .method = method});
      for (int r = 0; r < 40; ++r) {
        const double wanted = set["frequency_hz"][static_cast<std::size_t>(r)];
        EXPECT_NEAR(modes.frequency[r] / wanted, 1, 2e-12)
            << "mode " << r << " of set " << set["section_factor"];
      }
    }
  }
}

using std::numbers::pi;

const Material wood{"wood", 9e9, 7e8, 950, ""};

nlohmann::json validation(const std::string& id) {
  const auto json = nlohmann::json::parse(std::ifstream(test::data_folder() / "validation.json"));
  for (const auto& item : json["items"]) {
    if (item["id"] == id) return item;
  }
  throw std::runtime_error("validation.json has no item " + id);
}

// Frequencies of a stem that stands on z, sorted by what moves: across (each once, though they come in
// pairs), along, twist.
struct StemFrequencies {
  std::vector<double> bending, axial, torsion;
};

StemFrequencies stem_frequencies(const Skeleton& stem, const StructureOptions& options,
                                 int count = all_modes) {
  const Structure structure = assemble(stem, test::weightless(options));
  const Modes modes = solve_modes(structure, {.count = count});
  StemFrequencies result;
  for (int r = 0; r < modes.count(); ++r) {
    Vec3 translation = Vec3::Zero();
    double twist = 0;
    for (int k = 0; k < stem.branch_count(); ++k) {
      translation += modes.shapes.col(r).segment<3>(6 * k).cwiseAbs();
      twist += std::abs(modes.shapes(6 * k + 5, r));
    }
    const double across = translation.head<2>().sum();
    if (translation.z() > 1e3 * across) {
      result.axial.push_back(modes.frequency[r]);
    } else if (twist > 1e3 * across) {
      result.torsion.push_back(modes.frequency[r]);
    } else {
      result.bending.push_back(modes.frequency[r]);
    }
  }
  for (std::size_t r = 0; 2 * r + 1 < result.bending.size() && r < 5; ++r) {
    EXPECT_NEAR(result.bending[2 * r] / result.bending[2 * r + 1], 1, 1e-10) << "bending modes come in pairs";
  }
  std::vector<double> once;
  for (std::size_t r = 0; r < result.bending.size(); r += 2) once.push_back(result.bending[r]);
  result.bending = once;
  return result;
}

// lambda = omega L^2 sqrt(rho A / (E I)) with the section at the base.
double lambda(double frequency, double length, double base_radius) {
  return 2 * pi * frequency * length * length /
         std::sqrt(wood.youngs_modulus * base_radius * base_radius / 4 / wood.density);
}

TEST(SolveModes, OfAUniformCantileverAreTheRootsOfItsFrequencyEquation) {
  TREMULA_NEED_DATA("validation.json");
  const auto wanted = validation("beam.uniform.cantilever")["betaL_squared"];
  const double L = 2, r = 0.01;
  const StemFrequencies found =
      stem_frequencies(test::straight_stem(20, L, r, r), {.material = wood, .rotatory_inertia = false});
  const double tolerance[] = {1e-6, 1e-5, 5e-5, 3e-4,
                              8e-4};  // of a cubic element: (beta L/20)^4/720 and less
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_NEAR(lambda(found.bending[i], L, r) / wanted[i].get<double>(), 1, tolerance[i])
        << "mode " << i + 1;
  }
}

TEST(SolveModes, OfAStemWithAMassAtItsTipAreTheRootsOfItsFrequencyEquation) {
  TREMULA_NEED_DATA("validation.json");
  const auto item = validation("beam.tip_mass")["betaL"];
  const double L = 2, r = 0.01, stem_mass = wood.density * pi * r * r * L;
  for (const auto& [ratio, roots] : item.items()) {
    Skeleton stem = test::straight_stem(40, L, r, r);
    Leaf mass;
    mass.branch = 39;
    mass.position = 1;
    mass.mass = std::stod(ratio) * stem_mass;
    stem.leaves.push_back(mass);
    const StemFrequencies found = stem_frequencies(stem, {.material = wood, .rotatory_inertia = false});
    for (std::size_t i = 0; i < roots.size(); ++i) {
      const double root = roots[i];
      EXPECT_NEAR(lambda(found.bending[i], L, r) / (root * root), 1, 1e-5) << ratio << ", mode " << i + 1;
    }
  }
}

// The first roots of a frequency equation in beta L, by bisection.
std::vector<double> roots_of(const std::function<double(double)>& equation, std::size_t count) {
  std::vector<double> roots;
  const double step = 0.01;
  for (double low = 1e-3; roots.size() < count; low += step) {
    double below = low, above = low + step;
    if (equation(below) * equation(above) > 0) continue;
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (below + above);
      (equation(below) * equation(middle) > 0 ? below : above) = middle;
    }
    roots.push_back(0.5 * (below + above));
  }
  return roots;
}

// Of a cubic element: (beta L/pieces)^4/720, and as much again for the piece that is condensed with the
// spring.
void expect_roots(const StemFrequencies& found, const std::vector<double>& roots, double length,
                  double radius, int pieces) {
  for (std::size_t i = 0; i < roots.size(); ++i) {
    EXPECT_NEAR(lambda(found.bending[i], length, radius) / (roots[i] * roots[i]), 1,
                1e-9 + 2 * std::pow(roots[i] / pieces, 4) / 720)
        << "mode " << i + 1;
  }
}

TEST(SolveModes, OfAStemOnARotationalSpringAreTheRootsOfItsFrequencyEquation) {
  const double L = 2, r = 0.01, EI = wood.youngs_modulus * pi * std::pow(r, 4) / 4;
  for (const double ratio : {0.01, 1.0, 30.0}) {  // of the spring to EI/L
    const StemFrequencies found =
        stem_frequencies(test::straight_stem(32, L, r, r),
                         {.material = wood, .rotatory_inertia = false, .root = {.rotation = ratio * EI / L}});
    const auto equation = [&](double b) {
      return ratio * (1 + std::cos(b) * std::cosh(b)) -
             b * (std::sin(b) * std::cosh(b) - std::cos(b) * std::sinh(b));
    };
    expect_roots(found, roots_of(equation, 3), L, r, 32);
  }
}

TEST(SolveModes, OfAStemOnATranslationalSpringAreTheRootsOfItsFrequencyEquation) {
  const double L = 2, r = 0.01, EI = wood.youngs_modulus * pi * std::pow(r, 4) / 4;
  for (const double ratio : {0.01, 1.0, 30.0}) {  // of the spring to EI/L^3
    const StemFrequencies found = stem_frequencies(
        test::straight_stem(32, L, r, r),
        {.material = wood, .rotatory_inertia = false, .root = {.translation = ratio * EI / (L * L * L)}});
    const auto equation = [&](double b) {
      return ratio * (1 + std::cos(b) * std::cosh(b)) -
             b * b * b * (std::cos(b) * std::sinh(b) + std::sin(b) * std::cosh(b));
    };
    expect_roots(found, roots_of(equation, 3), L, r, 32);
  }
}

TEST(SolveModes, OfATreeOnAVerySoftSpringAreThoseOfARigidPendulum) {
  const double k = 1e-3;
  const Skeleton skeleton = test::random_tree(30, 6);
  const Structure structure =
      assemble(skeleton, test::weightless({.material = wood, .root = {.rotation = k}}));
  Mat3 inertia = Mat3::Zero();  // about the root, by turning the whole tree rigidly; it has one stem
  Eigen::MatrixXd turns(structure.size(), 3);
  for (int axis = 0; axis < 3; ++axis) {
    for (int b = 0; b < skeleton.branch_count(); ++b) {
      const Vec3 end = skeleton.branches[static_cast<std::size_t>(b)].end;
      turns.col(axis).segment<3>(6 * b) = Vec3::Unit(axis).cross(end);
      turns.col(axis).segment<3>(6 * b + 3) = Vec3::Unit(axis);
    }
  }
  for (int axis = 0; axis < 3; ++axis)
    inertia.col(axis) = turns.transpose() * structure.mass(turns.col(axis));
  ASSERT_EQ(std::count_if(skeleton.branches.begin(), skeleton.branches.end(),
                          [](const Branch& branch) { return branch.start_node == 0; }),
            1);
  const Eigen::SelfAdjointEigenSolver<Mat3> rigid(inertia);
  for (const ModeMethod method : {ModeMethod::dense, ModeMethod::iterative}) {
    const Modes modes = solve_modes(structure, {.count = 5, .method = method});
    for (int r = 0; r < 3; ++r) {
      EXPECT_NEAR(modes.omega()[r] / std::sqrt(k / rigid.eigenvalues()[2 - r]), 1, 1e-6);
    }
    EXPECT_GT(modes.frequency[3], 100 * modes.frequency[2]);
    EXPECT_EQ(modes.count_by_inertia, 5);
  }
}

TEST(SolveModes, OnASpringShapesAreOrthonormalAndNoneIsMissing) {
  const Structure structure =
      assemble(test::awkward_tree(),
               test::weightless({.material = wood, .root = {.translation = 1e5, .rotation = 1e3}}));
  const Modes modes = solve_modes(structure, {.count = 20, .method = ModeMethod::iterative});
  EXPECT_EQ(modes.count_below, modes.count_by_inertia);
  for (int r = 0; r < 20; ++r) {
    const Eigen::VectorXd inertia = structure.mass(modes.shapes.col(r));
    for (int c = 0; c < 20; ++c) EXPECT_NEAR(modes.shapes.col(c).dot(inertia), r == c ? 1 : 0, 1e-11);
  }
  const Modes clamped =
      solve_modes(assemble(test::awkward_tree(), test::weightless({.material = wood})), {.count = 20});
  for (int r = 0; r < 20; ++r) EXPECT_LT(modes.frequency[r], clamped.frequency[r]);
}

// A tube of uniform wall: sqrt((1 - k^4)/(1 - k^2)) = sqrt(1 + k^2) times the solid stem of its radius.
TEST(SolveModes, OfATubeAreThoseOfTheStemTimesTheRootOfOnePlusTheSquareOfItsBore) {
  const Skeleton solid = test::straight_stem(12, 4, 0.02, 0.02);
  const StructureOptions options = test::weightless({.rotatory_inertia = false});
  const Modes of_stem = solve_modes(assemble(solid, options), {.count = 6});
  for (const double wall : {0.9, 0.25, 0.1}) {
    Skeleton hollow = solid;
    for (Branch& branch : hollow.branches) branch.wall = wall;
    const Modes of_tube = solve_modes(assemble(hollow, options), {.count = 6});
    const double bore = 1 - wall;
    for (int r = 0; r < 6; ++r)
      EXPECT_NEAR(of_tube.frequency[r] / of_stem.frequency[r], std::sqrt(1 + bore * bore), 1e-9) << wall;
  }
}

// The frequency equation of a truncated cone, zero at its frequencies. Measured from the apex, x^-1 J_2(2 k
// sqrt x) and its three kin Y, I, K solve the beam equation, with k^2 = lambda/(1 - ratio)^2 where the base
// lies at x = 1.
double truncated_cone_equation(double lambda_of_base, double ratio) {
  const double k = std::sqrt(lambda_of_base) / (1 - ratio), base = 2 * k, tip = 2 * k * std::sqrt(ratio);
  const auto j = [](int n, double z) { return std::cyl_bessel_j(n, z); };
  const auto y = [](int n, double z) { return std::cyl_neumann(n, z); };
  const auto i = [](int n, double z) { return std::cyl_bessel_i(n, z); };
  const auto kk = [](int n, double z) { return std::cyl_bessel_k(n, z); };
  Eigen::Matrix4d conditions;
  conditions << j(2, base), y(2, base), i(2, base), kk(2, base),  // no deflection at the base
      -j(3, base), -y(3, base), i(3, base), -kk(3, base),         // no slope
      j(4, tip), y(4, tip), i(4, tip), kk(4, tip),                // no moment at the tip
      j(3, tip), y(3, tip), i(3, tip), -kk(3, tip);               // no shear
  for (int c = 0; c < 4; ++c) conditions.col(c).normalize();
  return conditions.determinant();
}

TEST(SolveModes, OfATruncatedConeAreTheRootsOfItsFrequencyEquation) {
  const double L = 2, r = 0.01;
  for (const double ratio : {0.8, 0.5, 0.25, 0.1}) {
    const Structure structure = assemble(test::straight_stem(320, L, r, ratio * r),
                                         test::weightless({.material = wood, .rotatory_inertia = false}));
    const Modes modes = solve_modes(structure, {.count = 6, .method = ModeMethod::iterative});
    for (const int mode : {0, 2, 4}) {
      const double found = lambda(modes.frequency[mode], L, r);
      const double below = truncated_cone_equation(found * (1 - 1e-7), ratio);
      const double above = truncated_cone_equation(found * (1 + 1e-7), ratio);
      EXPECT_LT(below * above, 0) << ratio << ", mode " << mode / 2 + 1 << ": " << found;
    }
  }
}

TEST(SolveModes, OfATruncatedConeAreThoseOfTheReferenceToItsDigits) {
  TREMULA_NEED_DATA("validation.json");
  const auto item = validation("beam.cone.truncated")["lambda_by_tip_over_base"];
  const double L = 2, r = 0.01;
  for (const auto& [ratio, wanted] : item.items()) {
    const StemFrequencies found = stem_frequencies(test::straight_stem(80, L, r, std::stod(ratio) * r),
                                                   {.material = wood, .rotatory_inertia = false}, 8);
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      // The frequency equation above says that the reference's first value at 0.8 is 7.9e-6 too low.
      EXPECT_NEAR(lambda(found.bending[i], L, r) / wanted[i].get<double>(), 1, 1e-5)
          << ratio << ", mode " << i + 1;
    }
  }
}

TEST(SolveModes, OfAConeThatEndsInAPointAreKirchhoffs) {
  TREMULA_NEED_DATA("validation.json");
  const auto wanted = validation("beam.cone.full")["lambda"];
  const double L = 2, r = 0.01;
  const StemFrequencies found = stem_frequencies(test::straight_stem(320, L, r, 1e-8 * r),
                                                 {.material = wood, .rotatory_inertia = false}, 8);
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    EXPECT_NEAR(lambda(found.bending[i], L, r) / wanted[i].get<double>(), 1, 2e-6) << "mode " << i + 1;
  }
}

TEST(SolveModes, FourTaperedBranchesAreNearerToTheConeThanTenSteps) {
  TREMULA_NEED_DATA("validation.json");
  const double wanted = validation("beam.cone.truncated")["lambda_by_tip_over_base"]["0.25"][0];
  const double L = 2, r = 0.01;
  Skeleton steps = test::straight_stem(10, L, r, 0.25 * r);
  for (Branch& branch : steps.branches) {
    branch.start_radius = branch.end_radius = 0.5 * (branch.start_radius + branch.end_radius);
  }
  const StructureOptions options{.material = wood, .rotatory_inertia = false};
  const double four =
      lambda(stem_frequencies(test::straight_stem(4, L, r, 0.25 * r), options).bending[0], L, r);
  const double ten = lambda(stem_frequencies(steps, options).bending[0], L, r);
  EXPECT_LT(std::abs(four - wanted), std::abs(ten - wanted));
}

TEST(SolveModes, AlongAndAboutAStemAreThoseOfARod) {
  const double L = 2, r = 0.01;
  const StemFrequencies found = stem_frequencies(test::straight_stem(60, L, r, r), {.material = wood});
  for (int n = 1; n <= 3; ++n) {
    // Linear elements are too stiff by (pi (2n-1)/(2 * 60))^2 / 24.
    const double tolerance = 1.1 * std::pow(pi * (2 * n - 1) / 120, 2) / 24;
    const auto i = static_cast<std::size_t>(n - 1);
    const double axial = (2 * n - 1) / (4 * L) * std::sqrt(wood.youngs_modulus / wood.density);
    const double torsion = (2 * n - 1) / (4 * L) * std::sqrt(wood.shear_modulus / wood.density);
    EXPECT_NEAR(found.axial[i] / axial, 1, tolerance);
    EXPECT_NEAR(found.torsion[i] / torsion, 1, tolerance);
  }
}

TEST(SolveModes, ShapesAreOrthonormalOverMassAndDiagonaliseStiffness) {
  const Skeleton skeleton = test::random_tree(150, 2);
  const Structure structure = assemble(skeleton, test::weightless({.material = wood}));
  const BeamTree tree = assemble_tree(skeleton, {.material = wood});
  const Modes modes = solve_modes(structure, {.count = 30, .method = ModeMethod::iterative});
  for (int r = 0; r < 30; ++r) {
    const Eigen::VectorXd inertia = structure.mass(modes.shapes.col(r));
    const Eigen::VectorXd elastic = apply_stiffness(tree, modes.shapes.col(r));
    const double omega2 = std::pow(modes.omega()[r], 2);
    for (int c = 0; c < 30; ++c) {
      EXPECT_NEAR(modes.shapes.col(c).dot(inertia), r == c ? 1 : 0, 1e-11) << r << ", " << c;
      EXPECT_NEAR(modes.shapes.col(c).dot(elastic) / omega2, r == c ? 1 : 0, 1e-8) << r << ", " << c;
    }
  }
}

TEST(SolveModes, AgreeWithTheAssembledEigenproblem) {
  const Skeleton skeleton = test::random_tree(25, 8);
  const Structure structure = assemble(skeleton, test::weightless({.material = wood}));
  const test::Assembled dense = test::assemble_dense(skeleton, assemble_tree(skeleton, {.material = wood}));
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> reference(dense.stiffness, dense.mass);
  const Modes modes = solve_modes(structure, {.count = all_modes});
  for (int r = 0; r < modes.count(); ++r) {
    // The assembled problem loses the digits of its low modes; that is why it is not what the program solves.
    const double omega = std::sqrt(reference.eigenvalues()[r]);
    EXPECT_NEAR(modes.omega()[r] / omega, 1, r < 10 ? 1e-7 : 1e-8) << "mode " << r;
  }
}

TEST(SolveModes, DenseAndIterativeAgreeToAllDigits) {
  const Structure structure =
      assemble(test::random_tree(90, 3), test::weightless({.material = find_material("paper")}));
  const Modes dense = solve_modes(structure, {.count = 20, .method = ModeMethod::dense});
  const Modes iterative =
      solve_modes(structure, {.count = 20, .method = ModeMethod::iterative, .tolerance = 1e-12});
  for (int r = 0; r < 20; ++r) {
    EXPECT_NEAR(dense.frequency[r] / iterative.frequency[r], 1, 1e-12);
    EXPECT_NEAR(std::abs(dense.shapes.col(r).normalized().dot(iterative.shapes.col(r).normalized())), 1,
                1e-6);
    EXPECT_LT(dense.error_bound[r], 1e-11);
    EXPECT_LT(iterative.error_bound[r], 1e-11);
  }
}

TEST(SolveModes, HaveResidualsBelowTheToleranceAskedFor) {
  for (const int branches : {60, 300}) {
    const Structure structure = assemble(test::random_tree(branches, 5), test::weightless());
    for (const double tolerance : {1e-6, 1e-8, 1e-10, 1e-12}) {
      const Modes modes =
          solve_modes(structure, {.count = 25, .method = ModeMethod::iterative, .tolerance = tolerance});
      EXPECT_LT(modes.residual.maxCoeff(), 2 * tolerance) << branches << " branches, " << tolerance;
    }
  }
}

TEST(SolveModes, AreTheSameWhenMemoryIsShort) {
  const Structure structure = assemble(test::random_tree(200, 5), test::weightless());
  const Modes free = solve_modes(structure, {.count = 20, .tolerance = 1e-12});
  // Room for some 45 vectors of 1200 numbers, and a little for lanes that stay empty.
  const std::size_t limit = 48 * 1200 * sizeof(double);
  const Modes bounded = solve_modes(structure, {.count = 20, .tolerance = 1e-12, .memory_limit = limit});
  EXPECT_GE(bounded.operator_count, free.operator_count);
  for (int r = 0; r < 20; ++r) EXPECT_NEAR(bounded.frequency[r] / free.frequency[r], 1, 1e-12) << r;
  EXPECT_THROW(solve_modes(structure, {.count = 20, .memory_limit = 100000}), InputError);
}

TEST(SolveModes, DoNotDependOnWhereATreeIsCut) {
  // A uniform branch cut in two is the same beam but for the finer inertia: its frequencies can only fall,
  // slightly.
  Skeleton cut;
  const Skeleton skeleton = test::random_tree(30, 6);
  cut.roots = skeleton.roots;
  for (int k = 0; k < skeleton.branch_count(); ++k) {
    const Branch& b = skeleton.branches[static_cast<std::size_t>(k)];
    const int start = b.start_node == 0 ? 0 : 2 * b.start_node;
    const Vec3 middle = 0.5 * (b.start + b.end);
    const double radius = 0.5 * (b.start_radius + b.end_radius);
    cut.branches.push_back(test::make_branch(start, b.start, middle, b.start_radius, radius));
    cut.branches.push_back(test::make_branch(2 * k + 1, middle, b.end, radius, b.end_radius));
  }
  const Modes whole = solve_modes(assemble(skeleton, test::weightless({.material = wood})), {.count = 10});
  const Modes halves = solve_modes(assemble(cut, test::weightless({.material = wood})), {.count = 10});
  for (int r = 0; r < 10; ++r) {
    EXPECT_LE(halves.frequency[r], whole.frequency[r] * (1 + 1e-12));
    EXPECT_GT(halves.frequency[r], whole.frequency[r] * (1 - 1e-2));
  }
}

// Every branch as so many pieces of the same taper.
Skeleton cut_into(const Skeleton& skeleton, int pieces) {
  Skeleton cut;
  cut.roots = skeleton.roots;
  const int roots = skeleton.root_count();
  for (int k = 0; k < skeleton.branch_count(); ++k) {
    const Branch& b = skeleton.branches[static_cast<std::size_t>(k)];
    int start = b.start_node < roots ? b.start_node : roots + (b.start_node - roots + 1) * pieces - 1;
    const auto at = [&](int i) { return static_cast<double>(i) / pieces; };
    for (int i = 0; i < pieces; ++i) {
      const auto point = [&](double t) { return Vec3(b.start + t * (b.end - b.start)); };
      const auto radius = [&](double t) { return b.start_radius + t * (b.end_radius - b.start_radius); };
      cut.branches.push_back(
          test::make_branch(start, point(at(i)), point(at(i + 1)), radius(at(i)), radius(at(i + 1))));
      start = cut.end_node(k * pieces + i);
    }
  }
  return cut;
}

double largest_error(const BeamTree& tree, const Modes& modes) {
  const test::LongVector exact = test::long_frequencies(tree, modes.shapes);
  return static_cast<double>(
      (modes.frequency.cast<long double>().cwiseQuotient(exact).array() - 1).abs().maxCoeff());
}

TEST(SolveModes, OfRandomTreesHaveTwelveDigitsOfALongDoubleReference) {
  for (const int branches : {17, 62, 212, 692, 2257}) {
    for (const char* material : {"paper", "green-wood"}) {
      const Skeleton skeleton = test::random_tree(branches, 40);
      const StructureOptions options{.material = find_material(material)};
      const Modes modes =
          solve_modes(assemble(skeleton, test::weightless(options)), {.count = std::min(40, 2 * branches)});
      EXPECT_LT(largest_error(assemble_tree(skeleton, options), modes), 1e-13)
          << branches << " branches of " << material;
    }
  }
}

TEST(SolveModes, KeepTheirDigitsWhereEveryBranchIsCutIntoSixtyFour) {
  for (const int branches : {17, 62}) {
    const Skeleton skeleton = cut_into(test::random_tree(branches, 40), 64);
    const StructureOptions options{.material = find_material("paper")};
    const Modes modes = solve_modes(assemble(skeleton, test::weightless(options)), {.count = 40});
    EXPECT_LT(largest_error(assemble_tree(skeleton, options), modes), 1e-11) << branches << " branches";
  }
}

TEST(SolveModes, OfWoodThatTwistsEasilyBeginWithTorsion) {
  Material rubbery = find_material("paper");
  rubbery.shear_modulus = 1e5;
  const Skeleton skeleton = test::random_tree(62, 4);
  const Structure structure = assemble(skeleton, test::weightless({.material = rubbery}));
  const BeamTree tree = assemble_tree(skeleton, {.material = rubbery});
  const Modes modes = solve_modes(structure, {.count = 40, .method = ModeMethod::iterative});
  EXPECT_EQ(modes.count_by_inertia, modes.count_below);
  EXPECT_LT(largest_error(tree, modes), 1e-12);
  // The elastic energy of the lowest mode is in twist about the branches.
  double twist = 0, all = 0;
  for (const Member& member : structure.members) {
    const EndDisplacements ends = end_displacements(member, modes.shapes.col(0));
    const double angle = (ends.end_rotation - ends.start_rotation).dot(member.direction);
    twist += angle * angle / compliance(member.beam).torsion;
  }
  all = modes.shapes.col(0).dot(apply_stiffness(tree, modes.shapes.col(0)));
  EXPECT_GT(twist / all, 0.9);
  EXPECT_NEAR(all / std::pow(modes.omega()[0], 2), 1, 1e-6);
}

TEST(SolveModes, TurnWithTheTree) {
  Skeleton skeleton = test::random_tree(20, 4);
  const Structure upright = assemble(skeleton, test::weightless({.material = wood}));
  const Eigen::AngleAxisd turn(1.1, Vec3(1, 2, -0.5).normalized());
  for (Branch& branch : skeleton.branches) {
    branch.start = turn * branch.start;
    branch.end = turn * branch.end;
  }
  const Modes before = solve_modes(upright, {.count = 12});
  const Modes after = solve_modes(assemble(skeleton, test::weightless({.material = wood})), {.count = 12});
  for (int r = 0; r < 12; ++r) EXPECT_NEAR(before.frequency[r] / after.frequency[r], 1, 1e-12);
}

TEST(SolveModes, TheLargestEntryOfAShapeIsPositive) {
  const Modes modes =
      solve_modes(assemble(test::random_tree(20, 4), test::weightless({.material = wood})), {.count = 12});
  for (int r = 0; r < 12; ++r) {
    EXPECT_EQ(modes.shapes.col(r).cwiseAbs().maxCoeff(), modes.shapes.col(r).maxCoeff());
  }
}

TEST(SolveModes, RefusesCountsThatTheStructureDoesNotHave) {
  const Structure structure =
      assemble(test::straight_stem(2, 1, 0.01, 0.01), test::weightless({.material = wood}));
  for (const int count : {0, -2, 13}) {
    EXPECT_THAT(test::complaint_of([&] { solve_modes(structure, {.count = count}); }),
                testing::HasSubstr("mode count: " + std::to_string(count) + ", wanted 1 to 12"));
  }
  EXPECT_EQ(solve_modes(structure, {.count = 12}).count(), 12);
  EXPECT_EQ(solve_modes(structure, {.count = all_modes}).count(), 12);
}

// The second method: Spectra's Lanczos on the same operator.
struct SpectraOperator {
  using Scalar = double;
  const BeamTree& tree;
  Eigen::Index rows() const { return tree.size(); }
  Eigen::Index cols() const { return tree.size(); }
  void perform_op(const double* in, double* out) const {
    Eigen::VectorXd::Map(out, rows()) = apply_compliance_form(tree, Eigen::VectorXd::Map(in, rows()));
  }
};

Eigen::VectorXd spectra_omega(const BeamTree& tree, int count, int basis) {
  SpectraOperator form{tree};
  Spectra::SymEigsSolver<SpectraOperator> solver(form, count, basis);
  solver.init();
  EXPECT_EQ(solver.compute(Spectra::SortRule::LargestAlge, 1000, 1e-13), count);
  return solver.eigenvalues().cwiseSqrt().cwiseInverse();
}

TEST(SolveModes, AgreeWithSpectraOnTheSameOperator) {
  for (const char* material : {"green-wood", "paper"}) {
    const Skeleton skeleton = test::random_tree(300, 12);
    const StructureOptions options{.material = find_material(material)};
    const Eigen::VectorXd wanted = spectra_omega(assemble_tree(skeleton, options), 25, 80);
    const Modes modes = solve_modes(assemble(skeleton, test::weightless(options)),
                                    {.count = 25, .method = ModeMethod::iterative});
    for (int r = 0; r < 25; ++r)
      EXPECT_NEAR(modes.omega()[r] / wanted[r], 1, 1e-12) << material << ", mode " << r;
  }
}

// Every branch carries three like it, turned by a third: clusters of modes that differ by parts in a million.
Skeleton threefold_tree(int levels) {
  Skeleton skeleton;
  skeleton.roots.push_back(Vec3::Zero());
  struct Tip {
    int node;
    Vec3 direction;
    double length, radius;
  };
  skeleton.branches.push_back(test::make_branch(0, Vec3::Zero(), 2 * Vec3::UnitZ(), 0.06, 0.06));
  std::vector<Tip> tips{{1, Vec3::UnitZ(), 2, 0.06}};
  for (int level = 1; level < levels; ++level) {
    std::vector<Tip> next;
    for (const Tip& tip : tips) {
      const Vec3 side = std::abs(tip.direction.z()) > 0.999
                            ? Vec3::UnitX()
                            : Vec3(Vec3::UnitZ().cross(tip.direction).normalized());
      for (int third = 0; third < 3; ++third) {
        const Vec3 axis = Eigen::AngleAxisd(2 * pi * third / 3, tip.direction) * side;
        const Vec3 direction = Eigen::AngleAxisd(0.6, axis) * tip.direction;
        const double length = 0.75 * tip.length, radius = 0.58 * tip.radius;
        const Vec3 start = skeleton.node_position(tip.node);
        skeleton.branches.push_back(
            test::make_branch(tip.node, start, start + length * direction, radius, radius));
        next.push_back({skeleton.branch_count(), direction, length, radius});
      }
    }
    tips = std::move(next);
  }
  return skeleton;
}

TEST(SolveModes, MissNoneOfAPerfectlyThreefoldTreeAtAnyTolerance) {
  const Skeleton skeleton = threefold_tree(6);
  ASSERT_EQ(skeleton.branch_count(), 364);
  const Structure structure = assemble(skeleton, test::weightless({.material = wood}));
  const BeamTree tree = assemble_tree(skeleton, {.material = wood});
  const Eigen::VectorXd all = spectra_omega(tree, 60, 300);
  int last = 40;  // of a whole number of clusters: the one before the widest gap
  for (int r = 40; r + 1 < 60; ++r) {
    if (all[r + 1] / all[r] > all[last + 1] / all[last]) last = r;
  }
  ASSERT_EQ(count_modes_below(tree, std::sqrt(all[last] * all[last + 1])), last + 1)
      << "the reference itself has lost modes";
  for (const double tolerance : {1e-6, 1e-9, 1e-12}) {
    for (const int count : {20, 40}) {
      const Modes modes =
          solve_modes(structure, {.count = count, .method = ModeMethod::iterative, .tolerance = tolerance});
      for (int r = 0; r < count; ++r) {
        EXPECT_NEAR(modes.omega()[r] / all[r], 1, std::max(1e-11, tolerance))
            << "mode " << r << " at " << tolerance;
      }
      EXPECT_EQ(modes.count_by_inertia, modes.count_below) << tolerance;
    }
  }
}

TEST(SolveModes, OfTwoIdenticalTreesOnOneRootAllComeTwice) {
  Skeleton skeleton = test::random_tree(120, 9);
  const Modes one = solve_modes(assemble(skeleton, test::weightless({.material = wood})), {.count = 15});
  const int count = skeleton.branch_count();
  for (int k = 0; k < count; ++k) {
    Branch copy = skeleton.branches[static_cast<std::size_t>(k)];
    if (copy.start_node > 0) copy.start_node += count;
    skeleton.branches.push_back(copy);
  }
  const Modes two = solve_modes(assemble(skeleton, test::weightless({.material = wood})),
                                {.count = 30, .method = ModeMethod::iterative});
  for (int r = 0; r < 30; ++r) EXPECT_NEAR(two.frequency[r] / one.frequency[r / 2], 1, 1e-12) << "mode " << r;
  EXPECT_EQ(two.count_below, 30);
  EXPECT_EQ(two.count_by_inertia, 30);
}

// A trunk and many equal twigs around its top: all but a few modes are twigs against each other, in one
// cluster.
Skeleton star(int twigs) {
  Skeleton skeleton = test::straight_stem(1, 2, 0.05, 0.05);
  for (int k = 0; k < twigs; ++k) {
    const double angle = 2 * pi * k / twigs;
    const Vec3 top(0, 0, 2);
    skeleton.branches.push_back(
        test::make_branch(1, top, top + Vec3(std::cos(angle), std::sin(angle), 0.3), 0.01, 0.01));
  }
  return skeleton;
}

TEST(SolveModes, OfAHundredEqualTwigsEndWithinTheirClusterAndSaySo) {
  const Structure structure = assemble(star(100), test::weightless({.material = wood}));
  const Modes all = solve_modes(structure, {.count = 400});  // dense
  const Modes few = solve_modes(structure, {.count = 12, .method = ModeMethod::iterative});
  for (int r = 0; r < 12; ++r) EXPECT_NEAR(few.frequency[r] / all.frequency[r], 1, 1e-10) << r;
  const auto equal = [&](double frequency) { return std::abs(frequency / few.frequency[11] - 1) < 1e-9; };
  const auto members = std::ranges::count_if(all.frequency, equal);
  ASSERT_GT(members, 150);
  EXPECT_EQ(few.equal_to_last, members);
  EXPECT_EQ(few.equal_left_out, members - std::ranges::count_if(few.frequency, equal));
  EXPECT_EQ(few.count_below, few.count_by_inertia);
}

TEST(SolveModes, OfAHundredEqualTwigsAreAllFoundWhereAllAreWanted) {
  const Structure structure = assemble(star(100), test::weightless({.material = wood}));
  const Modes dense = solve_modes(structure, {.count = 201, .method = ModeMethod::dense});
  const Modes modes = solve_modes(structure, {.count = 201, .method = ModeMethod::iterative});
  for (int r = 0; r < 201; ++r) EXPECT_NEAR(modes.frequency[r] / dense.frequency[r], 1, 1e-11) << r;
  EXPECT_LT(modes.residual.maxCoeff(), 2e-10);
  EXPECT_EQ(modes.count_below, modes.count_by_inertia);
  // What Q^T M Q = I means is the same for members of a cluster.
  Eigen::MatrixXd mass(201, 201);
  for (Eigen::Index r = 0; r < 201; ++r)
    mass.col(r) = modes.shapes.transpose() * structure.mass(modes.shapes.col(r));
  EXPECT_LT((mass - Eigen::MatrixXd::Identity(201, 201)).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(SolveModes, OfAThousandEqualTwigsTakeNoLongerThanTheirNumberAsks) {
  const Modes modes = solve_modes(assemble(star(1000), test::weightless({.material = wood})), {.count = 12});
  EXPECT_EQ(modes.count(), 12);
  EXPECT_GT(modes.equal_left_out, 1900);
  EXPECT_EQ(modes.count_below, modes.count_by_inertia);
  EXPECT_LT(modes.operator_count, 500);
}

Skeleton side_by_side(const std::vector<Skeleton>& stems) {
  Skeleton all;
  for (std::size_t s = 0; s < stems.size(); ++s) all.roots.emplace_back(3.0 * static_cast<double>(s), 0, 0);
  for (std::size_t s = 0; s < stems.size(); ++s) {
    const int branches_before = all.branch_count();
    for (Branch branch : stems[s].branches) {
      const Vec3 offset = all.roots[s];
      branch.start_node = branch.start_node == 0 ? static_cast<int>(s)
                                                 : all.root_count() + branches_before + branch.start_node - 1;
      branch.start += offset;
      branch.end += offset;
      all.branches.push_back(branch);
    }
  }
  return all;
}

TEST(SolveModes, OfStemsSideBySideAreThoseOfTheStems) {
  const std::vector<Skeleton> stems = {test::random_tree(60, 3), test::straight_stem(8, 2, 0.02, 0.01),
                                       test::random_tree(150, 4)};
  const int count = 40;
  std::vector<double> wanted;
  for (const Skeleton& stem : stems) {
    const Modes own = solve_modes(assemble(stem, test::weightless({.material = wood})),
                                  {.count = count, .tolerance = 1e-12});
    wanted.insert(wanted.end(), own.frequency.begin(), own.frequency.end());
  }
  std::ranges::sort(wanted);
  const Structure together = assemble(side_by_side(stems), test::weightless({.material = wood}));
  const Modes modes = solve_modes(together, {.count = count, .tolerance = 1e-12});
  for (std::size_t r = 0; r < count; ++r)
    EXPECT_NEAR(modes.frequency[static_cast<Eigen::Index>(r)] / wanted[r], 1, 1e-11) << r;
  EXPECT_EQ(modes.count_below, count);
  EXPECT_EQ(modes.count_by_inertia, count);
  // Every shape is a mode of the whole: K q = omega^2 M q.
  for (int r = 0; r < count; ++r) {
    const Eigen::VectorXd q = modes.shapes.col(r);
    const Eigen::VectorXd inertia = std::pow(modes.omega()[r], 2) * together.mass(q);
    EXPECT_LT((together.flexibility(inertia) - q).norm(), 1e-9 * q.norm()) << r;
    EXPECT_NEAR(q.dot(together.mass(q)), 1, 1e-10) << r;
  }
}

TEST(SolveModes, OfTwentyCopiesOfAStemComeTwentyTimes) {
  const Skeleton culm = test::random_tree(30, 8);
  const Modes one = solve_modes(assemble(culm, test::weightless({.material = wood})), {.count = 6});
  const Structure clump =
      assemble(side_by_side(std::vector<Skeleton>(20, culm)), test::weightless({.material = wood}));
  const Modes all = solve_modes(clump, {.count = 80});
  for (int r = 0; r < 80; ++r) EXPECT_NEAR(all.frequency[r] / one.frequency[r / 20], 1, 1e-11) << r;
  const Modes few = solve_modes(clump, {.count = 12});
  EXPECT_EQ(few.equal_to_last, 20);
  EXPECT_EQ(few.equal_left_out, 8);
  EXPECT_EQ(few.count_below, few.count_by_inertia);
}

TEST(SolveModes, AskForTheirMemoryBeforeTheyTakeIt) {
  const Structure structure = assemble(test::random_tree(100, 5), test::weightless());
  // Two matrices of 600 x 600 numbers.
  const std::size_t two = 2 * 600 * 600 * sizeof(double);
  EXPECT_EQ(solve_modes(structure, {.count = all_modes, .memory_limit = two}).count(), 600);
  EXPECT_THAT(
      test::complaint_of([&] { solve_modes(structure, {.count = all_modes, .memory_limit = two - 1}); }),
      testing::HasSubstr("memory limit: 5 MB for 600 modes of 600 degrees of freedom, "
                         "wanted at least 6 MB, or fewer modes"));
}

TEST(SolveModes, OfALongStraightStemBendingComesInPairs) {
  const Structure structure =
      assemble(test::straight_stem(200, 6, 0.05, 0.01), test::weightless({.material = wood}));
  const Modes modes = solve_modes(structure, {.count = 20, .method = ModeMethod::iterative});
  for (int r = 0; r < 14; r += 2)
    EXPECT_NEAR(modes.frequency[r] / modes.frequency[r + 1], 1, 1e-12) << "mode " << r;
  EXPECT_EQ(modes.count_by_inertia, modes.count_below);
}

TEST(SolveModes, CountAsManyBelowTheLastAsTheInertiaSays) {
  const Structure structure =
      assemble(test::random_tree(400, 21), test::weightless({.material = find_material("paper")}));
  for (const int count : {1, 7, 40}) {
    const Modes modes = solve_modes(structure, {.count = count, .method = ModeMethod::iterative});
    EXPECT_EQ(modes.count_below, count);
    EXPECT_EQ(modes.count_by_inertia, count);
  }
}

TEST(SolveModesUpTo, FindsEveryModeBelowTheFrequencyAndNoneAbove) {
  const Structure structure = assemble(test::random_tree(200, 30), test::weightless({.material = wood}));
  const Modes first = solve_modes(structure, {.count = 30});
  const double between = 0.5 * (first.frequency[22] + first.frequency[23]);
  EXPECT_EQ(solve_modes_up_to(structure, between).count(), 23);
  EXPECT_THROW(solve_modes_up_to(structure, 0.5 * first.frequency[0]), InputError);
  for (const double bad : {0.0, -1.0, static_cast<double>(NAN)}) {
    EXPECT_THROW(solve_modes_up_to(structure, bad), InputError);
  }
}

// A branch shorter than its thickness by fourteen digits: the first search is sure of no mode at all.
TEST(SolveModes, AreFoundWhereTheFirstSearchFindsNone) {
  const Vec3 low(0.1845685426811129, -0.014061967113262977, 0.2858477874237172),
      fork(-0.013476994366665551, -0.05147457398176715, 0.5597168201396987),
      next(fork.x(), fork.y(), 0.55971682013969825);
  Skeleton skeleton;
  skeleton.roots.push_back(Vec3::Zero());
  skeleton.branches = {
      test::make_branch(0, Vec3::Zero(), low, 0.08, 0.06274179584206933),
      test::make_branch(1, low, fork, 0.04114443078340902, 0.039469340288660115),
      test::make_branch(2, fork, next, 0.039469340288660115, 0.02681470298814272),
      test::make_branch(3, next, Vec3(0.17851247922394634, 0.036946493828147214, 0.813936945),
                        0.02681470298814272, 0.02112609345347417),
      test::make_branch(1, low, Vec3(-0.046751463401833226, -0.4645340725147066, 0.560844070553186),
                        0.04265098794476653, 0.04003317740450578),
      test::make_branch(2, fork, Vec3(0.309796392087315, -0.34188887345114377, 0.8817376497875962),
                        0.02502857364854326, 0.024495671033746325),
      test::make_branch(1, low, Vec3(0.1488793947942466, 0.09545368980924844, 0.6216077817682613),
                        0.048734604712937564, 0.04435078579461516)};
  const Structure structure = assemble(skeleton, test::weightless());
  const Modes modes = solve_modes(structure, {.count = 3});
  EXPECT_EQ(modes.count_below, modes.count_by_inertia);
  EXPECT_TRUE(modes.shapes.allFinite());
  const Modes dense = solve_modes(structure, {.count = 3, .method = ModeMethod::dense});
  EXPECT_LT((modes.frequency - dense.frequency).norm(), 1e-9 * dense.frequency.norm());
}

TEST(SolveModes, AreTheSameBytesOnAnyNumberOfThreads) {
  const Structure structure = assemble(test::random_tree(11000, 1), test::weightless({.material = wood}));
  Eigen::MatrixXd shapes[2];
  for (const std::size_t threads : {std::size_t{1}, std::size_t{2}}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    shapes[threads - 1] = solve_modes(structure, {.count = 4}).shapes;
  }
  EXPECT_TRUE(shapes[0] == shapes[1]);
}

}  // namespace
}  // namespace tremula
