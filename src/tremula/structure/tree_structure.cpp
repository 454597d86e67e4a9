// A tree as a structure: everything by sweeps.
#include "tremula/base/error.hpp"
#include "tremula/structure/compliance_operator.hpp"
#include "tremula/structure/element_blocks.hpp"
#include "tremula/structure/independent_parts.hpp"
#include "tremula/structure/mode_count.hpp"
#include "tremula/structure/prestress.hpp"
#include "tremula/structure/structure.hpp"

#include <cmath>
#include <cstdio>
#include <memory>
#include <numeric>
#include <string>
#include <utility>

namespace tremula {
namespace {

using SixByThree = Eigen::Matrix<double, 6, 3>;
using Tree = std::shared_ptr<const BeamTree>;

// The compliance form in the tree's own order: 6N numbers and no lanes that stay empty.
EigenProblem plain_problem(const Tree& tree) {
  return {
      .size = tree->size(),
      .degrees_of_freedom = tree->size(),
      .apply =
          [tree](Eigen::Ref<const Eigen::VectorXd> in, Eigen::Ref<Eigen::VectorXd> out) {
            out = apply_compliance_form(*tree, in);
            return in.dot(out);
          },
      .displacement =
          [tree](Eigen::Ref<const Eigen::VectorXd> s) { return displacement_from_compliance_form(*tree, s); },
      .count_below = [tree](double omega) { return count_modes_below(*tree, omega); }};
}

// The packed operator has masses that know no direction across a branch: blades in water want the plain one.
EigenProblem packed_problem(const Tree& tree) {
  EigenProblem problem = plain_problem(tree);
  if (!tree->blade_water.empty()) return problem;
  const auto compliance_operator = std::make_shared<ComplianceOperator>(*tree);
  problem.size = compliance_operator->size();
  problem.apply = [compliance_operator](Eigen::Ref<const Eigen::VectorXd> in,
                                        Eigen::Ref<Eigen::VectorXd> out) {
    return compliance_operator->apply(in, out);
  };
  problem.displacement = [compliance_operator, tree](Eigen::Ref<const Eigen::VectorXd> s) {
    return displacement_from_compliance_form(*tree, compliance_operator->unpacked(s));
  };
  return problem;
}

EigenParts eigen_parts(const Tree& tree) {
  const auto parts = std::make_shared<const std::vector<std::vector<int>>>(independent_parts(*tree));
  EigenParts result;
  for (const std::vector<int>& part : *parts) {
    std::vector<int>& rows = result.rows.emplace_back();
    rows.reserve(6 * part.size());
    for (const int branch : part) {
      for (int i = 0; i < 6; ++i) rows.push_back(6 * branch + i);
    }
  }
  result.problem = [tree, parts](std::size_t part, bool plain) {
    const Tree own =
        parts->size() == 1 ? tree : std::make_shared<const BeamTree>(part_of(*tree, (*parts)[part]));
    return plain ? plain_problem(own) : packed_problem(own);
  };
  result.count_below = [tree, parts](double omega) {
    const std::vector<int> pivots = negative_pivots(*tree, omega);
    std::vector<int> below;
    for (const std::vector<int>& part : *parts) {
      below.push_back(0);
      for (const int branch : part) below.back() += pivots[static_cast<std::size_t>(branch)];
    }
    return below;
  };
  result.rows_explained = "six for each of the " + std::to_string(tree->branch_count()) + " branches";
  return result;
}

// M_fa (1_x 1_y 1_z), and what it leaves on the clamped nodes goes into the total only.
GroundInertia ground_inertia(const BeamTree& tree) {
  GroundInertia result{Eigen::MatrixX3d::Zero(tree.size(), 3)};
  SixByThree translation;
  translation << Mat3::Identity(), Mat3::Zero();
  for (int k = 0; k < tree.branch_count(); ++k) {
    const auto index = static_cast<std::size_t>(k);
    const ElementBlocks mass = mass_blocks(tree, index);
    const SixByThree at_start = (mass.start + mass.cross) * translation;
    const SixByThree at_end = (mass.cross.transpose() + mass.end) * translation;
    result.total_mass += at_start(0, 0) + at_end(0, 0);
    result.forces.middleRows<6>(6 * k) += at_end;
    if (const int parent = tree.parent[index]; parent >= 0) {
      result.forces.middleRows<6>(6 * parent) +=
          rigid_carry(tree.members[index].start_arm).transpose() * at_start;
    }
  }
  return result;
}

// Roots first, then the ends of the branches.
std::vector<Node> nodes_of(const Skeleton& skeleton) {
  std::vector<Node> nodes;
  for (int node = 0; node < skeleton.node_count(); ++node) {
    const int branch = node - skeleton.root_count();
    nodes.push_back({skeleton.node_position(node), branch < 0 ? -1 : Eigen::Index{6} * branch, -1});
  }
  for (int k = skeleton.branch_count() - 1; k >= 0; --k) {
    if (skeleton.parent(k) < 0)
      nodes[static_cast<std::size_t>(skeleton.branches[static_cast<std::size_t>(k)].start_node)].foot_of = k;
  }
  return nodes;
}

[[noreturn]] void refuse_weight(const LoadMargin& margin, const StructureOptions& options) {
  if (margin.branch < 0) throw InputError("plant", "a weight that numbers do not hold", "gravity 0");
  char found[120], wanted[200];
  std::snprintf(found, sizeof found, "buckles under the weight of the plant (load margin %.3g)",
                margin.factor);
  if (std::isfinite(options.root.rotation) || std::isfinite(options.root.translation)) {
    std::snprintf(wanted, sizeof wanted, "wood and roots %.3g times as stiff, or gravity 0",
                  1 / margin.factor);
  } else {
    std::snprintf(wanted, sizeof wanted,
                  "a Young's modulus of %.3g Pa or more (shear modulus in proportion), or gravity 0",
                  options.material.youngs_modulus / margin.factor);
  }
  throw InputError("branch " + std::to_string(margin.branch), found, wanted);
}

Sites sites_of(const Tree& tree) { return find_sites(tree->members, tree, tree->blades, tree->size()); }

// A tree as it stands bent, free of loads, with its leaves.
BeamTree bent_tree(const Structure& structure, const std::vector<BentBranch>& bent) {
  if (!structure.tree) throw InputError("structure to bend", "a frame", "a tree");
  BeamTree standing = tree_at(*structure.tree, bent);
  for (BladeSite& blade : standing.blades) {
    const std::size_t k = index_of(blade.member);
    blade.normal = point_on(structure.tree->members[k], bent[k], blade.place).frame * blade.normal;
  }
  set_blade_water(standing);
  return standing;
}

Structure structure_of(const Tree& tree, std::vector<Node> nodes, DeadLoads weight) {
  Structure structure;
  structure.nodes = std::move(nodes);
  structure.members = tree->members;
  structure.mass = [tree](const Eigen::VectorXd& displacement) { return apply_mass(*tree, displacement); };
  structure.flexibility = [tree](const Eigen::VectorXd& force) { return solve_static(*tree, force); };
  structure.eigen = eigen_parts(tree);
  structure.find_sites = [tree] { return sites_of(tree); };
  structure.find_ground_inertia = [tree] { return ground_inertia(*tree); };
  structure.find_load_margin = [tree] {
    return tree->is_loaded() ? load_margin(*tree, tree->geometric) : LoadMargin{};
  };
  structure.row_count = tree->size();
  structure.tree = tree;
  structure.weight = std::move(weight);
  return structure;
}

}  // namespace

Structure assemble(const Skeleton& skeleton, const StructureOptions& options) {
  BeamTree tree = assemble_tree(skeleton, options);
  DeadLoads weight_of_all;
  if (options.gravity != 0) {
    weight_of_all = weight(skeleton, options);
    const bool stands = take_load(geometric_stiffness(tree, weight_of_all), tree);
    if (!stands) refuse_weight(load_margin(tree, tree.geometric), options);
  }
  return structure_of(std::make_shared<const BeamTree>(std::move(tree)), nodes_of(skeleton),
                      std::move(weight_of_all));
}

Sites bent_sites(const Structure& structure, const std::vector<BentBranch>& bent) {
  return sites_of(std::make_shared<const BeamTree>(bent_tree(structure, bent)));
}

Structure bent_structure(const Structure& structure, const std::vector<BentBranch>& bent,
                         std::span<const PointForce> forces) {
  BeamTree standing = bent_tree(structure, bent);
  DeadLoads loads = structure.weight;
  loads.per_volume.resize(standing.parent.size(), Vec3::Zero());
  loads.points.insert(loads.points.end(), forces.begin(), forces.end());
  // Bent by more than a right angle, a twig is no straight beam between its ends; it may look as if it
  // buckled.
  constexpr double twigs = 0.1;
  if (!take_load(geometric_stiffness(standing, loads), standing, twigs)) {
    throw Error("lean: the plant as it stands in the wind buckles; choose less wind or stiffer wood");
  }
  std::vector<Node> nodes = structure.nodes;
  for (Node& node : nodes) {
    if (node.row >= 0) node.position = bent[index_of(node.row / 6)].end;
  }
  return structure_of(std::make_shared<const BeamTree>(std::move(standing)), std::move(nodes),
                      structure.weight);
}

}  // namespace tremula
