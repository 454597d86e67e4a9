#include "tremula/modes/mode_quality.hpp"

#include "tremula/base/check.hpp"
#include "tremula/geometry/axes.hpp"
#include "tremula/structure/element_blocks.hpp"

#include <tbb/parallel_for.h>

namespace tremula {
namespace {

using SixByThree = Eigen::Matrix<double, 6, 3>;

// M_fa (1_x 1_y 1_z), and what it leaves on the clamped nodes goes into the total only.
Eigen::MatrixX3d rigid_translation_forces(const Structure& structure, double& total_mass) {
  Eigen::MatrixX3d forces = Eigen::MatrixX3d::Zero(structure.size(), 3);
  SixByThree translation;
  translation << Mat3::Identity(), Mat3::Zero();
  total_mass = 0;
  for (int k = 0; k < structure.branch_count(); ++k) {
    const auto index = static_cast<std::size_t>(k);
    const ElementBlocks mass = mass_blocks(structure.masses[index], structure.direction[index]);
    const SixByThree at_start = (mass.start + mass.cross) * translation;
    const SixByThree at_end = (mass.cross.transpose() + mass.end) * translation;
    total_mass += at_start(0, 0) + at_end(0, 0);
    forces.middleRows<6>(6 * k) += at_end;
    if (const int parent = structure.parent[index]; parent >= 0) {
      forces.middleRows<6>(6 * parent) += rigid_carry(structure.start_arm[index]).transpose() * at_start;
    }
  }
  return forces;
}

EnergyShares energy_shares(const Structure& structure, const Eigen::Ref<const Eigen::VectorXd>& shape,
                           const std::vector<bool>& trunk) {
  EnergyShares energy{};
  for (int k = 0; k < structure.branch_count(); ++k) {
    const auto index = static_cast<std::size_t>(k);
    Vec3 translation = shape.segment<3>(6 * k), rotation = shape.segment<3>(6 * k + 3);
    if (const int parent = structure.parent[index]; parent >= 0) {
      const Vec3 carrier = shape.segment<3>(6 * parent + 3);
      translation -= shape.segment<3>(6 * parent) + carrier.cross(structure.reach[index]);
      rotation -= carrier;
    }
    const Vec3& direction = structure.direction[index];
    const Compliance& c = structure.compliances[index];
    const double along = translation.dot(direction), twist = rotation.dot(direction);
    const Vec3 across = translation - along * direction;
    const Vec3 slope_left = rotation.cross(direction) - c.deflection_slope / c.deflection * across;
    energy.axial += along * along / c.axial;
    energy.torsion += twist * twist / c.torsion;
    (trunk[index] ? energy.trunk : energy.branch) +=
        across.squaredNorm() / c.deflection + slope_left.squaredNorm() / c.slope_held;
  }
  const double sum = energy.trunk + energy.branch + energy.torsion + energy.axial;
  return {energy.trunk / sum, energy.branch / sum, energy.torsion / sum, energy.axial / sum};
}

ModeKind kind_of(const EnergyShares& energy) {
  if (energy.torsion > 0.5) return ModeKind::torsion;
  if (energy.axial > 0.5) return ModeKind::axial;
  return energy.trunk > energy.branch ? ModeKind::trunk : ModeKind::branch;
}

}  // namespace

std::string_view name_of(ModeKind kind) {
  switch (kind) {
    case ModeKind::trunk:
      return "trunk";
    case ModeKind::branch:
      return "branch";
    case ModeKind::torsion:
      return "torsion";
    case ModeKind::axial:
      return "axial";
  }
  return "";
}

std::vector<bool> trunk_branches(const Skeleton& skeleton) {
  const std::vector<int> continuation = branch_continuations(skeleton);
  std::vector<bool> trunk(skeleton.branches.size());
  for (int k = 0; k < skeleton.branch_count(); ++k) {
    const int below = skeleton.parent(k);
    const auto carrier = static_cast<std::size_t>(below);
    trunk[static_cast<std::size_t>(k)] = below < 0 || (trunk[carrier] && continuation[carrier] == k);
  }
  return trunk;
}

ModeQuality assess_modes(const Structure& structure, const Modes& modes, const std::vector<bool>& trunk) {
  check_equal("rows of the mode shapes", modes.shapes.rows(), structure.size());
  check_equal("columns of the mode shapes", modes.shapes.cols(), modes.count());
  check_equal("branches that are trunk or not", static_cast<std::ptrdiff_t>(trunk.size()),
              structure.branch_count());
  ModeQuality quality;
  const Eigen::MatrixX3d forces = rigid_translation_forces(structure, quality.total_mass);
  quality.participation = modes.shapes.transpose() * forces;
  const auto count = static_cast<std::size_t>(modes.count());
  quality.energy.resize(count);
  quality.kind.resize(count);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t r) {
    quality.energy[r] = energy_shares(structure, modes.shapes.col(static_cast<Eigen::Index>(r)), trunk);
    quality.kind[r] = kind_of(quality.energy[r]);
  });
  return quality;
}

}  // namespace tremula
