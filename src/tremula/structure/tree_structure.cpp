// A tree as a structure: everything by sweeps.
#include "tremula/base/error.hpp"
#include "tremula/structure/compliance_operator.hpp"
#include "tremula/structure/element_blocks.hpp"
#include "tremula/structure/independent_parts.hpp"
#include "tremula/structure/mode_count.hpp"
#include "tremula/structure/structure.hpp"

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

EigenProblem packed_problem(const Tree& tree) {
  EigenProblem problem = plain_problem(tree);
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
    const ElementBlocks mass = mass_blocks(tree.masses[index], tree.members[index].direction);
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

Structure structure_of(const Tree& tree, std::vector<Node> nodes) {
  Structure structure;
  structure.nodes = std::move(nodes);
  structure.members = tree->members;
  structure.mass = [tree](const Eigen::VectorXd& displacement) { return apply_mass(*tree, displacement); };
  structure.flexibility = [tree](const Eigen::VectorXd& force) { return solve_static(*tree, force); };
  structure.eigen = eigen_parts(tree);
  structure.find_sites = [tree] { return find_sites(tree->members, tree, tree->blades, tree->size()); };
  structure.find_ground_inertia = [tree] { return ground_inertia(*tree); };
  structure.row_count = tree->size();
  structure.tree = tree;
  return structure;
}

}  // namespace

Structure assemble(const Skeleton& skeleton, const StructureOptions& options) {
  return structure_of(std::make_shared<const BeamTree>(assemble_tree(skeleton, options)), nodes_of(skeleton));
}

Structure bent_structure(const Structure& structure, const std::vector<BentBranch>& bent) {
  if (!structure.tree) throw InputError("structure to bend", "a frame", "a tree");
  BeamTree standing = tree_at(*structure.tree, bent);
  for (BladeSite& blade : standing.blades) {
    const auto member = static_cast<std::size_t>(blade.member);
    blade.normal = point_on(structure.tree->members[member], bent[member], blade.place).frame * blade.normal;
  }
  std::vector<Node> nodes = structure.nodes;
  for (Node& node : nodes) {
    if (node.row >= 0) node.position = bent[static_cast<std::size_t>(node.row / 6)].end;
  }
  return structure_of(std::make_shared<const BeamTree>(std::move(standing)), std::move(nodes));
}

}  // namespace tremula
