#include "tremula/modes/mode_quality.hpp"

#include "tremula/base/check.hpp"
#include "tremula/geometry/axes.hpp"

#include <algorithm>
#include <numbers>

#include <tbb/parallel_for.h>

namespace tremula {
namespace {

EnergyShares energy_shares(const Structure& structure, const std::vector<Compliance>& compliances,
                           const Eigen::Ref<const Eigen::VectorXd>& shape, double omega,
                           const std::vector<bool>& trunk) {
  EnergyShares energy{};
  for (std::size_t k = 0; k < structure.members.size(); ++k) {
    const Member& member = structure.members[k];
    const Vec3& direction = member.direction;
    const EndDisplacements ends = end_displacements(member, shape);
    const Vec3 translation = ends.end_translation - ends.start_translation -
                             ends.start_rotation.cross(member.beam.length * direction);
    const Vec3 rotation = ends.end_rotation - ends.start_rotation;
    const Compliance& c = compliances[k];
    const double along = translation.dot(direction), twist = rotation.dot(direction);
    const Vec3 across = translation - along * direction;
    const Vec3 slope_left = rotation.cross(direction) - c.deflection_slope / c.deflection * across;
    energy.axial += along * along / c.axial;
    energy.torsion += twist * twist / c.torsion;
    (trunk[k] ? energy.trunk : energy.branch) +=
        across.squaredNorm() / c.deflection + slope_left.squaredNorm() / c.slope_held;
  }
  if (structure.sheet) return {0, 1, 0, 0};
  double sum = energy.trunk + energy.branch + energy.torsion + energy.axial;
  if (!structure.panels.empty()) {  // they have what the members have not of q^T K q
    energy.branch += std::max(0.0, omega * omega - sum);
    sum = std::max(sum, omega * omega);
  }
  return {energy.trunk / sum, energy.branch / sum, energy.torsion / sum, energy.axial / sum};
}

ModeKind kind_of(const EnergyShares& energy, bool has_trunk) {
  if (energy.torsion > 0.5) return ModeKind::torsion;
  if (energy.axial > 0.5) return ModeKind::axial;
  if (!has_trunk) return ModeKind::bending;
  return energy.trunk > energy.branch ? ModeKind::trunk : ModeKind::branch;
}

}  // namespace

std::string_view name_of(ModeKind kind) {
  switch (kind) {
    case ModeKind::trunk:
      return "trunk";
    case ModeKind::branch:
      return "branch";
    case ModeKind::bending:
      return "bending";
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
  check_equal("members that are trunk or not", static_cast<std::ptrdiff_t>(trunk.size()),
              static_cast<std::ptrdiff_t>(structure.members.size()));
  const GroundInertia inertia = structure.find_ground_inertia();
  std::vector<Compliance> compliances;
  for (const Member& member : structure.members) compliances.push_back(compliance(member.beam));
  const bool has_trunk = std::find(trunk.begin(), trunk.end(), true) != trunk.end();
  ModeQuality quality;
  quality.total_mass = inertia.total_mass;
  quality.participation = modes.shapes.transpose() * inertia.forces;
  const auto count = static_cast<std::size_t>(modes.count());
  quality.energy.resize(count);
  quality.kind.resize(count);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t r) {
    quality.energy[r] =
        energy_shares(structure, compliances, modes.shapes.col(static_cast<Eigen::Index>(r)),
                      2 * std::numbers::pi * modes.frequency[static_cast<Eigen::Index>(r)], trunk);
    quality.kind[r] = kind_of(quality.energy[r], has_trunk);
  });
  return quality;
}

}  // namespace tremula
