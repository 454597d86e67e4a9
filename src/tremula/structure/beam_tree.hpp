// A plant as beams hung on each other, clamped at the roots or held there by springs.
//
// A clamped tree is statically determinate, so the stiffness matrix K is never built. With e the displacement
// of each branch's end relative to its rigidly carried start, u = B^-1 e is a sweep from the roots to the
// tips, wrenches add up by B^-T from the tips to the roots, and each branch answers with the compliance C of
// its tip:
//
//   K^-1 = B^-1 C B^-T,     M = sum over branches of their consistent masses.
//
// Displacement and force vectors have 6 rows per branch: those of the node at its end (x y z, rotation or
// moment x y z; world axes). Roots have none.
//
// Under load K grows by the geometric stiffness, and the same sweeps hold with other numbers in B and S.
#pragma once

#include "tremula/geometry/skeleton.hpp"
#include "tremula/structure/material.hpp"
#include "tremula/structure/member.hpp"
#include "tremula/structure/sites.hpp"

#include <limits>
#include <vector>

#include <Eigen/Core>

namespace tremula {

// How the ground holds a stem: an isotropic spring without mass at the start of every branch that stands on a
// root, one for each of them. Infinite: clamped.
struct RootSpring {
  double translation = std::numeric_limits<double>::infinity();  // [N/m]
  double rotation = std::numeric_limits<double>::infinity();     // [N m/rad]
};

struct StructureOptions {
  Material material = find_material("green-wood");
  Section section = Section::exact;
  bool rotatory_inertia = true;  // of the sections about their diameters; that about the axis always counts
  RootSpring root = {};
  // Of a fluid that moves with the plant [kg/m^3]: across a branch a cylinder of fluid as large as the branch
  // (added mass, coefficient 1), across a blade the cylinder about its width (Lamb 1932, section 71). Matters
  // in water; 0 in air.
  double added_mass_density = 0;
  // The shape a skeleton has is its shape under its own weight, along -z [m/s^2]: weight adds no sag, it
  // makes what stands softer and what hangs stiffer. `assemble` heeds it. 0: none.
  double gravity = 9.81;
};

// The potential of dead loads to second order, branch by branch: 1/2 e^T relative e + Theta^T carried e, with
// e the displacement of the end relative to its rigidly carried start and Theta the rotation of the node that
// carries it (prestress.hpp).
struct GeometricStiffness {
  Mat6 relative = Mat6::Zero();
  Eigen::Matrix<double, 3, 6> carried = Eigen::Matrix<double, 3, 6>::Zero();
};

// What B^-1 and S become for a branch under load. Dead loads do not feel a translation, so the end goes with
// the translation u of its carrier as before: u_end = (u, 0) + carry Theta + root s.
struct LoadedBranch {
  Eigen::Matrix<double, 6, 3> carry = Eigen::Matrix<double, 6, 3>::Zero();
  Mat6 root = Mat6::Zero();  // lower triangular
};

// Blocks of a symmetric matrix over the displacements of the start and the end of a branch, world axes.
struct ElementBlocks {
  Mat6 start = Mat6::Zero(), cross = Mat6::Zero(), end = Mat6::Zero();  // (start, start), (start, end), …
};

// One entry per branch in every array, parents before children. A branch on a spring is condensed into one
// with it (Beam::base): the spring's far side, the ground, is what carries the branch and stands still, so
// nothing that works with `compliances`, `masses` or Shape need know of the spring.
struct BeamTree {
  std::vector<int> parent;  // branch that carries the start, -1 a root
  std::vector<Member> members;
  std::vector<Vec3> reach;  // from the node that carries the start to the end of the branch [m]
  std::vector<Compliance> compliances;
  std::vector<ElementMass> masses;     // of wood and of the leaves the branch carries
  std::vector<BladeSite> blades = {};  // the leaves, in any order
  // (N) Mass of the fluid that blades move along their normals. Unlike `masses` it knows directions across
  // the branch. Empty where there is none.
  std::vector<ElementBlocks> blade_water = {};
  double fluid_density = 0;  // StructureOptions::added_mass_density
  // Of a tree under load (under_load); of another both are empty.
  std::vector<GeometricStiffness> geometric = {};
  std::vector<LoadedBranch> loaded = {};

  int branch_count() const { return static_cast<int>(parent.size()); }
  bool is_loaded() const { return !loaded.empty(); }
  Eigen::Index size() const { return 6 * static_cast<Eigen::Index>(parent.size()); }
};

// Throws InputError unless both stiffnesses are above 0 (1e-100 is the least) or infinite.
void check_root(const RootSpring& spring);

// The tree without its weight (under_load, weight in prestress.hpp). Throws InputError for a material or a
// root that is not one (check_material, check_root) or an added mass below 0, and for a skeleton that
// check_skeleton does not pass (leaves may be masses without a size).
// Functions below throw it for vectors of another size.
BeamTree assemble_tree(const Skeleton& skeleton, const StructureOptions& options);

// What blades move along their normals as these now are; assemble_tree does it, and whoever turns them.
void set_blade_water(BeamTree& tree);

// M u.  (6N) -> (6N)
Eigen::VectorXd apply_mass(const BeamTree& tree, const Eigen::VectorXd& displacement);

// e = B u: what each branch's end moves beyond its rigidly carried start, its strain while that is small.
// (6N) -> (6N)
Eigen::VectorXd strains_of(const BeamTree& tree, const Eigen::VectorXd& displacement);

// K u = B^T C^-1 B u, and what the geometric stiffness adds. For checks: it loses the digits that
// solve_static keeps.
Eigen::VectorXd apply_stiffness(const BeamTree& tree, const Eigen::VectorXd& displacement);

// K^-1 f = B^-1 C B^-T f: the static deflection, exact. (6N) [N, N m] -> (6N) [m, rad]
Eigen::VectorXd solve_static(const BeamTree& tree, const Eigen::VectorXd& force);

// The symmetric operator of the compliance form, S^T B^-T M B^-1 S with C = S S^T. Its eigenvalues are
// omega^-2; an eigenvector s gives the mode B^-1 S s (S section 3 in a form that keeps all digits of the low
// modes).
Eigen::VectorXd apply_compliance_form(const BeamTree& tree, const Eigen::VectorXd& s);
Eigen::VectorXd displacement_from_compliance_form(const BeamTree& tree, const Eigen::VectorXd& s);

}  // namespace tremula
