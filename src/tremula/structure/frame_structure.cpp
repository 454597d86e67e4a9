// A frame as a structure: K = P^T L L^T P by sparse Cholesky.
#include "tremula/structure/element_blocks.hpp"
#include "tremula/structure/plate_sites.hpp"
#include "tremula/structure/sparse_pivots.hpp"
#include "tremula/structure/structure.hpp"

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/SparseCholesky>

#include "tremula/base/check.hpp"
#include "tremula/base/error.hpp"

namespace tremula {
namespace {

using Matrix = Eigen::SparseMatrix<double>;

using SixByThree = Eigen::Matrix<double, 6, 3>;
using Cholesky = Eigen::SimplicialLLT<Matrix>;
using Matrices = std::shared_ptr<const FrameMatrices>;

// q = P^T L^-T s.
EigenProblem frame_problem(const Matrices& matrices, const std::shared_ptr<const Cholesky>& cholesky) {
  const auto indefinite = std::make_shared<Eigen::SimplicialLDLT<Matrix>>();
  indefinite->analyzePattern(matrices->stiffness + matrices->mass);
  const auto displacement = [cholesky](Eigen::Ref<const Eigen::VectorXd> s) -> Eigen::VectorXd {
    return cholesky->permutationPinv() * Eigen::VectorXd(cholesky->matrixU().solve(s));
  };
  return {.size = matrices->size(),
          .degrees_of_freedom = matrices->size(),
          .apply =
              [cholesky, displacement, matrices](Eigen::Ref<const Eigen::VectorXd> in,
                                                 Eigen::Ref<Eigen::VectorXd> out) {
                const Eigen::VectorXd inertia = matrices->mass * displacement(in);
                out = cholesky->matrixL().solve(Eigen::VectorXd(cholesky->permutationP() * inertia));
                return in.dot(out);
              },
          .displacement = displacement,
          .count_below =
              [indefinite, matrices](double omega) {
                return count_below(*indefinite, matrices->stiffness, matrices->mass, omega);
              }};
}

// As that of a tree; the point masses of the frame count too.
GroundInertia ground_inertia(const FrameMatrices& matrices, const Frame& frame, const FrameOptions& options) {
  GroundInertia result{Eigen::MatrixX3d::Zero(matrices.size(), 3)};
  SixByThree translation;
  translation << Mat3::Identity(), Mat3::Zero();
  const auto add = [&](Eigen::Index row, const SixByThree& forces) {
    result.total_mass += forces(0, 0);
    if (row >= 0) result.forces.middleRows<6>(row) += forces;
  };
  for (const Member& member : matrices.members) {
    const ElementBlocks mass =
        mass_blocks(consistent_mass(member.beam, options.rotatory_inertia), member.direction);
    add(member.start_row, (mass.start + mass.cross) * translation);
    add(member.end_row, (mass.cross.transpose() + mass.end) * translation);
  }
  for (const FramePointMass& point : frame.masses)
    add(matrices.row[static_cast<std::size_t>(point.node)], point.mass * translation);
  for (const PlacedPanel& panel : matrices.panels) {
    const Sheet& sheet = panel.sheet;
    result.total_mass += sheet.density * sheet.thickness * sheet.width * sheet.height;
    add_ground_inertia(panel, result.forces);
  }
  return result;
}

// Those of the frame, and those of the panels that have rows of their own.
std::vector<Node> nodes_of(const Frame& frame, const FrameMatrices& matrices) {
  std::vector<Node> nodes;
  for (std::size_t i = 0; i < frame.nodes.size(); ++i) nodes.push_back({frame.nodes[i], matrices.row[i], -1});
  for (const PlacedPanel& panel : matrices.panels) {
    for (std::size_t i = 0; i < panel.nodes.size(); ++i) {
      if (panel.nodes[i].fixed_to < 0)
        nodes.push_back({panel.sheet.position(panel.sheet.place(static_cast<int>(i))), panel.nodes[i].row});
    }
  }
  return nodes;
}

}  // namespace

Structure assemble(const Frame& frame, const FrameOptions& options) {
  const Matrices matrices = std::make_shared<const FrameMatrices>(assemble_frame(frame, options));
  const auto cholesky = std::make_shared<const Cholesky>(matrices->stiffness);
  if (cholesky->info() != Eigen::Success)
    throw InputError("frame", "beams so slender that rounding takes all of their stiffness",
                     std::string("thicker or shorter ones, the radius a millionth of the length or more") +
                         (frame.panels.empty() ? "" : "; and panels likewise"));

  Structure structure;
  structure.nodes = nodes_of(frame, *matrices);
  structure.members = matrices->members;
  structure.panels = matrices->panels;
  structure.mass = [matrices](const Eigen::VectorXd& displacement) -> Eigen::VectorXd {
    check_equal("rows of the displacement", displacement.size(), matrices->size());
    return matrices->mass * displacement;
  };
  structure.flexibility = [matrices, cholesky](const Eigen::VectorXd& force) -> Eigen::VectorXd {
    check_equal("rows of the force", force.size(), matrices->size());
    return cholesky->solve(force);
  };
  structure.eigen = {
      .rows = {all_rows(matrices->size())},
      .problem = [matrices, cholesky](std::size_t, bool) { return frame_problem(matrices, cholesky); },
      .count_below =
          [matrices, cholesky](double omega) {
            return std::vector<int>{frame_problem(matrices, cholesky).count_below(omega)};
          },
      .rows_explained = "six for each free node"};
  structure.find_sites = [matrices] {
    Sites sites = find_sites(matrices->members, matrices, {}, matrices->size());
    return matrices->panels.empty() ? sites
                                    : join(std::move(sites), find_sites(matrices->panels, matrices->size()));
  };
  structure.find_ground_inertia = [matrices, frame, options] {
    return ground_inertia(*matrices, frame, options);
  };
  structure.find_load_margin = [] { return LoadMargin{}; };
  structure.row_count = matrices->size();
  return structure;
}

}  // namespace tremula
