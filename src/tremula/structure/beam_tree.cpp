#include "tremula/structure/beam_tree.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/error.hpp"
#include "tremula/geometry/skeleton_checks.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

namespace tremula {
namespace {

// The square root of a branch's compliance: C = S S^T, S lower triangular in (deflection, slope).
struct ComplianceRoot {
  double axial, torsion, deflection, slope_deflection, slope;

  explicit ComplianceRoot(const Compliance& c)
      : axial(std::sqrt(c.axial)),
        torsion(std::sqrt(c.torsion)),
        deflection(std::sqrt(c.deflection)),
        slope_deflection(c.deflection_slope / deflection),
        slope(std::sqrt(c.slope_held)) {}
};

// u = B^-1 e in place: from the roots to the tips, each branch is carried by its parent.
void carry_to_tips(const BeamTree& tree, Eigen::VectorXd& u) {
  for (int k = 0; k < tree.branch_count(); ++k) {
    const int parent = tree.parent[index_of(k)];
    if (parent < 0) continue;
    const Vec3 rotation = u.segment<3>(6 * parent + 3);
    if (tree.is_loaded()) {
      u.segment<3>(6 * k) += u.segment<3>(6 * parent);
      u.segment<6>(6 * k) += tree.loaded[index_of(k)].carry * rotation;
      continue;
    }
    u.segment<3>(6 * k) += u.segment<3>(6 * parent) + rotation.cross(tree.reach[index_of(k)]);
    u.segment<3>(6 * k + 3) += rotation;
  }
}

// B^-T f in place: from the tips to the roots, each branch hands its wrench to its parent.
void gather_to_roots(const BeamTree& tree, Eigen::VectorXd& f) {
  for (int k = tree.branch_count() - 1; k >= 0; --k) {
    const int parent = tree.parent[index_of(k)];
    if (parent < 0) continue;
    const Vec3 force = f.segment<3>(6 * k);
    f.segment<3>(6 * parent) += force;
    if (tree.is_loaded()) {
      f.segment<3>(6 * parent + 3) += tree.loaded[index_of(k)].carry.transpose() * f.segment<6>(6 * k);
      continue;
    }
    f.segment<3>(6 * parent + 3) += f.segment<3>(6 * k + 3) + tree.reach[index_of(k)].cross(force);
  }
}

template <class PerBranch>
void for_each_branch_in_place(const BeamTree& tree, Eigen::VectorXd& vector, PerBranch&& map) {
  for (int k = 0; k < tree.branch_count(); ++k) {
    const Vec3& direction = tree.members[index_of(k)].direction;
    const Split out =
        map(index_of(k), Split(vector.segment<3>(6 * k), vector.segment<3>(6 * k + 3), direction));
    vector.segment<3>(6 * k) = out.translation(direction);
    vector.segment<3>(6 * k + 3) = out.rotation(direction);
  }
}

// S s and S^T f, branch by branch in place.
void apply_root(const BeamTree& tree, Eigen::VectorXd& vector) {
  if (tree.is_loaded()) {
    for (int k = 0; k < tree.branch_count(); ++k) {
      const Vec6 in = vector.segment<6>(6 * k);
      vector.segment<6>(6 * k) = tree.loaded[index_of(k)].root * in;
    }
    return;
  }
  for_each_branch_in_place(tree, vector, [&](std::size_t k, const Split& in) {
    const ComplianceRoot root(tree.compliances[k]);
    return Split(root.axial * in.along, root.torsion * in.twist, root.deflection * in.across,
                 root.slope_deflection * in.across + root.slope * in.bend);
  });
}
void apply_root_transposed(const BeamTree& tree, Eigen::VectorXd& vector) {
  if (tree.is_loaded()) {
    for (int k = 0; k < tree.branch_count(); ++k) {
      const Vec6 wrench = vector.segment<6>(6 * k);
      vector.segment<6>(6 * k) = tree.loaded[index_of(k)].root.transpose() * wrench;
    }
    return;
  }
  for_each_branch_in_place(tree, vector, [&](std::size_t k, const Split& wrench) {
    const ComplianceRoot root(tree.compliances[k]);
    return Split(root.axial * wrench.along, root.torsion * wrench.twist,
                 root.deflection * wrench.across + root.slope_deflection * wrench.bend,
                 root.slope * wrench.bend);
  });
}

// A size or stiffness that no plant has makes numbers whose squares a double does not hold.
void check_range(const BeamTree& tree, int k) {
  const Compliance& c = tree.compliances[index_of(k)];
  const ElementMass& mass = tree.masses[index_of(k)];
  const auto check = [k](const char* what, double value) {
    if (value >= 1e-120 && value <= 1e120) return;
    char found[80];
    std::snprintf(found, sizeof found, "a %s of %g", what, value);
    throw InputError("branch " + std::to_string(k), found,
                     "lengths, radii, stiffness and density that a plant can have");
  };
  for (const double compliance : {c.axial, c.torsion, c.deflection, c.slope, c.slope_held})
    check("compliance", compliance);
  for (const double inertia :
       {mass.axial.trace(), mass.torsion.trace(), mass.bending(2, 2), mass.bending(3, 3)})
    check("mass", inertia);
}

// The volume of the cylinders about the widths of a blade, whose mean is area / length; about its length
// where that is less. A square moves 0.58 of that and one of 1:5 moves 0.9 (DNV-RP-C205, table A-2).
double fluid_beside(const Leaf& leaf) {
  if (!(leaf.length > 0)) return 0;  // a mass without a size
  if (leaf.is_ribbon) {
    const double a = leaf.width, b = leaf.end_width;
    return std::numbers::pi / 12 * leaf.length * (a * a + a * b + b * b);
  }
  return std::numbers::pi / 4 * leaf.area * std::min(leaf.length, leaf.area / leaf.length);
}

}  // namespace

void set_blade_water(BeamTree& tree) {
  tree.blade_water.clear();
  if (tree.fluid_density == 0 || tree.blades.empty()) return;
  tree.blade_water.resize(tree.parent.size());
  for (const BladeSite& blade : tree.blades) {
    const std::size_t k = index_of(blade.member);
    const Eigen::Matrix<double, 12, 1> along =
        point_shape(tree.members[k], blade.place) * blade.normal;  // what of the ends' motion goes there
    const double mass = tree.fluid_density * blade.carried;
    ElementBlocks& water = tree.blade_water[k];
    water.start += mass * along.head<6>() * along.head<6>().transpose();
    water.cross += mass * along.head<6>() * along.tail<6>().transpose();
    water.end += mass * along.tail<6>() * along.tail<6>().transpose();
  }
}

void check_root(const RootSpring& spring) {
  const auto check = [](const char* what, double stiffness, const char* unit) {
    if (!(stiffness >= 1e-100)) {
      throw InputError(what, std::to_string(stiffness) + unit, "a number above 0, or infinity");
    }
  };
  check("translational stiffness of the root", spring.translation, " N/m");
  check("rotational stiffness of the root", spring.rotation, " N m/rad");
}

BeamTree assemble_tree(const Skeleton& skeleton, const StructureOptions& options) {
  check_skeleton(skeleton, "skeleton", {.leaves_without_size = true});
  check_material(options.material);
  check_root(options.root);
  if (!(options.added_mass_density >= 0 && options.added_mass_density <= 1e30)) {
    throw InputError("added mass density", std::to_string(options.added_mass_density), "0 kg/m^3 or more");
  }
  if (!(options.gravity >= 0 && options.gravity <= 1e30)) {
    throw InputError("gravity", std::to_string(options.gravity), "0 m/s^2 or more");
  }
  BeamTree tree;
  for (int k = 0; k < skeleton.branch_count(); ++k) {
    const Branch& branch = skeleton.branches[index_of(k)];
    const Vec3& carrier = skeleton.node_position(branch.start_node);
    tree.parent.push_back(skeleton.parent(k));
    tree.reach.push_back(branch.end - carrier);
    const int parent = tree.parent.back();
    Member member{.start_row = parent < 0 ? -1 : Eigen::Index{6} * parent,
                  .end_row = Eigen::Index{6} * k,
                  .start = branch.start,
                  .direction = (branch.end - branch.start).normalized(),
                  .start_arm = branch.start - carrier,
                  .beam = make_beam(branch, options.material, options.section)};
    if (parent < 0) member.beam.base = {1 / options.root.translation, 1 / options.root.rotation};
    tree.compliances.push_back(compliance(member.beam));
    tree.masses.push_back(consistent_mass(member.beam, options.rotatory_inertia));
    add_fluid_mass(member.beam, options.added_mass_density, tree.masses.back());
    tree.members.push_back(std::move(member));
  }
  for (const Leaf& leaf : skeleton.leaves) {
    const std::size_t k = index_of(leaf.branch);
    add_point_mass(tree.members[k].beam, leaf.position, leaf.mass, tree.masses[k]);
    tree.blades.push_back(
        {leaf.branch, leaf.position, leaf.normal, leaf.area, leaf.mass, fluid_beside(leaf), leaf.is_ribbon});
  }
  tree.fluid_density = options.added_mass_density;
  set_blade_water(tree);
  for (int k = 0; k < tree.branch_count(); ++k) check_range(tree, k);
  return tree;
}

Eigen::VectorXd apply_mass(const BeamTree& tree, const Eigen::VectorXd& displacement) {
  check_equal("rows of the displacement", displacement.size(), tree.size());
  Eigen::VectorXd force = Eigen::VectorXd::Zero(displacement.size());
  for (int k = 0; k < tree.branch_count(); ++k) {
    const Vec3& direction = tree.members[index_of(k)].direction;
    const ElementMass& mass = tree.masses[index_of(k)];
    const EndDisplacements ends = end_displacements(tree.members[index_of(k)], displacement);
    const Split start(ends.start_translation, ends.start_rotation, direction);
    const Split end(ends.end_translation, ends.end_rotation, direction);
    const auto row = [&](int start_row, int a) {  // of the start (0) or the end (1)
      const int b = start_row;
      return Split(mass.axial(a, 0) * start.along + mass.axial(a, 1) * end.along,
                   mass.torsion(a, 0) * start.twist + mass.torsion(a, 1) * end.twist,
                   mass.bending(b, 0) * start.across + mass.bending(b, 1) * start.bend +
                       mass.bending(b, 2) * end.across + mass.bending(b, 3) * end.bend,
                   mass.bending(b + 1, 0) * start.across + mass.bending(b + 1, 1) * start.bend +
                       mass.bending(b + 1, 2) * end.across + mass.bending(b + 1, 3) * end.bend);
    };
    const Split at_end = row(2, 1);
    force.segment<3>(6 * k) += at_end.translation(direction);
    force.segment<3>(6 * k + 3) += at_end.rotation(direction);
    Vec6 moved_water = Vec6::Zero();
    if (!tree.blade_water.empty()) {
      const ElementBlocks& water = tree.blade_water[index_of(k)];
      Vec6 at_start, at_end_too;
      at_start << ends.start_translation, ends.start_rotation;
      at_end_too << ends.end_translation, ends.end_rotation;
      moved_water = water.start * at_start + water.cross * at_end_too;
      force.segment<6>(6 * k) += water.cross.transpose() * at_start + water.end * at_end_too;
    }
    const int parent = tree.parent[index_of(k)];
    if (parent >= 0) {
      const Split at_start = row(0, 0);
      const Vec3 start_force = at_start.translation(direction) + moved_water.head<3>();
      force.segment<3>(6 * parent) += start_force;
      force.segment<3>(6 * parent + 3) += at_start.rotation(direction) + moved_water.tail<3>() +
                                          tree.members[index_of(k)].start_arm.cross(start_force);
    }
  }
  return force;
}

Eigen::VectorXd strains_of(const BeamTree& tree, const Eigen::VectorXd& displacement) {
  check_equal("rows of the displacement", displacement.size(), tree.size());
  Eigen::VectorXd relative = displacement;
  for (int k = 0; k < tree.branch_count(); ++k) {
    const int parent = tree.parent[index_of(k)];
    if (parent < 0) continue;
    const Vec3 rotation = displacement.segment<3>(6 * parent + 3);
    relative.segment<3>(6 * k) -=
        displacement.segment<3>(6 * parent) + rotation.cross(tree.reach[index_of(k)]);
    relative.segment<3>(6 * k + 3) -= rotation;
  }
  return relative;
}

Eigen::VectorXd apply_stiffness(const BeamTree& tree, const Eigen::VectorXd& displacement) {
  check_equal("rows of the displacement", displacement.size(), tree.size());
  const Eigen::VectorXd relative = strains_of(tree, displacement);
  Eigen::VectorXd wrench = relative;
  for_each_branch_in_place(tree, wrench, [&](std::size_t k, const Split& e) {
    const Compliance& c = tree.compliances[k];
    const double determinant = c.deflection * c.slope_held;
    return Split(e.along / c.axial, e.twist / c.torsion,
                 (c.slope * e.across - c.deflection_slope * e.bend) / determinant,
                 (c.deflection * e.bend - c.deflection_slope * e.across) / determinant);
  });
  if (tree.is_loaded()) {
    for (int k = 0; k < tree.branch_count(); ++k) {
      const GeometricStiffness& geometric = tree.geometric[index_of(k)];
      const int parent = tree.parent[index_of(k)];
      wrench.segment<6>(6 * k) += geometric.relative * relative.segment<6>(6 * k);
      if (parent >= 0) {
        wrench.segment<6>(6 * k) += geometric.carried.transpose() * displacement.segment<3>(6 * parent + 3);
      }
    }
  }
  Eigen::VectorXd force = wrench;
  for (int k = 0; k < tree.branch_count(); ++k) {  // B^T
    const int parent = tree.parent[index_of(k)];
    if (parent < 0) continue;
    if (tree.is_loaded()) {
      force.segment<3>(6 * parent + 3) += tree.geometric[index_of(k)].carried * relative.segment<6>(6 * k);
    }
    const Vec3 end_force = wrench.segment<3>(6 * k);
    force.segment<3>(6 * parent) -= end_force;
    force.segment<3>(6 * parent + 3) -=
        wrench.segment<3>(6 * k + 3) + tree.reach[index_of(k)].cross(end_force);
  }
  return force;
}

Eigen::VectorXd solve_static(const BeamTree& tree, const Eigen::VectorXd& force) {
  check_equal("rows of the force", force.size(), tree.size());
  Eigen::VectorXd vector = force;
  gather_to_roots(tree, vector);
  if (tree.is_loaded()) {
    apply_root_transposed(tree, vector);
    apply_root(tree, vector);
    carry_to_tips(tree, vector);
    return vector;
  }
  for_each_branch_in_place(tree, vector, [&](std::size_t k, const Split& wrench) {
    const Compliance& c = tree.compliances[k];
    return Split(c.axial * wrench.along, c.torsion * wrench.twist,
                 c.deflection * wrench.across + c.deflection_slope * wrench.bend,
                 c.deflection_slope * wrench.across + c.slope * wrench.bend);
  });
  carry_to_tips(tree, vector);
  return vector;
}

Eigen::VectorXd displacement_from_compliance_form(const BeamTree& tree, const Eigen::VectorXd& s) {
  check_equal("rows of the vector", s.size(), tree.size());
  Eigen::VectorXd vector = s;
  apply_root(tree, vector);
  carry_to_tips(tree, vector);
  return vector;
}

Eigen::VectorXd apply_compliance_form(const BeamTree& tree, const Eigen::VectorXd& s) {
  Eigen::VectorXd vector = apply_mass(tree, displacement_from_compliance_form(tree, s));
  gather_to_roots(tree, vector);
  apply_root_transposed(tree, vector);
  return vector;
}

}  // namespace tremula
