#include "tremula/dynamics/branch_oscillators.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/error.hpp"
#include "tremula/geometry/surface.hpp"
#include "tremula/numerics/quadrature.hpp"
#include "tremula/structure/uniform_beam.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <tbb/parallel_for.h>
#include <Eigen/Eigenvalues>

namespace tremula {
namespace {

using Triplet = Eigen::Triplet<double>;

// The axes of a tree are chosen by lengths, radii and directions alone.
Skeleton skeleton_of(const BeamTree& tree) {
  Skeleton skeleton;
  int roots = 0;
  for (const int parent : tree.parent) roots += parent < 0;
  int root = 0;
  for (std::size_t k = 0; k < tree.parent.size(); ++k) {
    const Member& member = tree.members[k];
    Branch branch;
    branch.start_node = tree.parent[k] < 0 ? root++ : roots + tree.parent[k];
    branch.start = member.start;
    branch.end = member.point(1);
    branch.start_radius = member.beam.start_radius;
    branch.end_radius = member.beam.end_radius;
    if (tree.parent[k] < 0) skeleton.roots.push_back(member.start);
    skeleton.branches.push_back(branch);
  }
  return skeleton;
}

std::vector<OscillatorAxis> axes_of(const BeamTree& tree) {
  std::vector<OscillatorAxis> axes;
  std::vector<int> axis_of(tree.parent.size(), -1);
  std::vector<double> end_place(tree.parent.size(), 0);
  std::vector<std::vector<int>> chains = split_into_axes(skeleton_of(tree));
  std::ranges::sort(chains, {}, [](const std::vector<int>& chain) { return chain.front(); });
  for (std::vector<int>& members : chains) {
    OscillatorAxis axis;
    for (const int k : members) {
      axis.begin.push_back(axis.length);
      axis.length += tree.members[index_of(k)].beam.length;
      axis_of[index_of(k)] = static_cast<int>(axes.size());
    }
    for (double& place : axis.begin) place /= axis.length;
    for (std::size_t i = 0; i < members.size(); ++i)
      end_place[index_of(members[i])] = i + 1 < members.size() ? axis.begin[i + 1] : 1;
    if (const int carrier = tree.parent[index_of(members.front())]; carrier >= 0) {
      axis.parent = axis_of[index_of(carrier)];
      axis.attachment = end_place[index_of(carrier)];
    }
    const Member& first = tree.members[index_of(members.front())];
    const Vec3 chord = tree.members[index_of(members.back())].point(1) - first.start;
    axis.direction = chord.norm() > 1e-9 * axis.length ? chord.normalized() : first.direction;
    axis.members = std::move(members);
    axes.push_back(std::move(axis));
  }
  return axes;
}

// A mass on an axis besides its wood.
struct MassAt {
  double place, mass;  // [kg]
};

double wood_mass(const BeamTree& tree, const OscillatorAxis& axis) {
  double mass = 0;
  for (const int k : axis.members) {
    const Beam& beam = tree.members[index_of(k)].beam;
    mass += beam.material.density * volume_beyond(beam, 0).volume;
  }
  return mass;
}

// (axes) Leaves, and where asked what other axes hang there.
std::vector<std::vector<MassAt>> masses_on(const BeamTree& tree, const std::vector<OscillatorAxis>& axes,
                                           bool carried_mass) {
  std::vector<std::pair<int, std::size_t>> place_of(tree.parent.size());  // axis, and which of its members
  for (std::size_t a = 0; a < axes.size(); ++a) {
    for (std::size_t i = 0; i < axes[a].members.size(); ++i)
      place_of[index_of(axes[a].members[i])] = {static_cast<int>(a), i};
  }
  std::vector<std::vector<MassAt>> masses(axes.size());
  for (const BladeSite& blade : tree.blades) {
    const auto [a, i] = place_of[index_of(blade.member)];
    const OscillatorAxis& axis = axes[index_of(a)];
    const double length = tree.members[index_of(blade.member)].beam.length;
    masses[index_of(a)].push_back({axis.begin[i] + blade.place * length / axis.length, blade.mass});
  }
  if (!carried_mass) return masses;
  for (std::size_t a = axes.size(); a-- > 0;) {
    if (axes[a].parent < 0) continue;
    double total = wood_mass(tree, axes[a]);
    for (const MassAt& mass : masses[a]) total += mass.mass;
    masses[index_of(axes[a].parent)].push_back({axes[a].attachment, total});
  }
  return masses;
}

// Shapes and frequencies of an axis with a clamp at its foot, as sums of a few V_r.
void find_shapes(const BeamTree& tree, const std::vector<MassAt>& masses, int modes, OscillatorAxis& axis) {
  const int count = modes + 3;
  Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(count, count), mass = stiffness;
  Eigen::VectorXd momentum = Eigen::VectorXd::Zero(count), value(count), curvature(count);
  const auto look = [&](double place) {
    for (int r = 0; r < count; ++r) {
      const BeamShape shape = clamped_free_shape(r + 1, std::min(place, 1.0));
      value[r] = shape.value;
      curvature[r] = shape.curvature / (axis.length * axis.length);
    }
  };
  // As many points in all as the highest shape asks for.
  static const std::vector<QuadraturePoint> coarse = gauss_legendre(6), middle = gauss_legendre(16),
                                            fine = gauss_legendre(40);
  const std::size_t pieces = axis.members.size();
  const std::vector<QuadraturePoint>& quadrature = pieces < 4 ? fine : pieces < 12 ? middle : coarse;
  for (std::size_t i = 0; i < pieces; ++i) {
    const Beam& beam = tree.members[index_of(axis.members[i])].beam;
    for (const QuadraturePoint& q : quadrature) {
      look(axis.begin[i] + q.position * beam.length / axis.length);
      const double length = q.weight * beam.length, per_length = mass_per_length_at(beam, q.position);
      stiffness += length * bending_stiffness_at(beam, q.position) * curvature * curvature.transpose();
      mass += length * per_length * value * value.transpose();
      momentum += length * per_length * value;
    }
  }
  for (const MassAt& point : masses) {
    look(point.place);
    mass += point.mass * value * value.transpose();
    momentum += point.mass * value;
  }
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> ritz(stiffness, mass);
  axis.omega = ritz.eigenvalues().head(modes).cwiseSqrt();
  axis.shape = ritz.eigenvectors().leftCols(modes);
  for (int r = 0; r < modes; ++r) {
    if (axis.shape(r, r) < 0) axis.shape.col(r) *= -1;
  }
  axis.momentum = axis.shape.transpose() * momentum;
}

// Of every mode at a place: the shape and its slope by the length along the axis.
struct ModeValues {
  Eigen::VectorXd value, slope;
};
ModeValues values_at(const OscillatorAxis& axis, double place) {
  const Eigen::Index count = axis.shape.rows();
  Eigen::VectorXd value(count), slope(count);
  for (Eigen::Index r = 0; r < count; ++r) {
    const BeamShape shape = clamped_free_shape(static_cast<int>(r) + 1, std::clamp(place, 0.0, 1.0));
    value[r] = shape.value;
    slope[r] = shape.slope / axis.length;
  }
  return {axis.shape.transpose() * value, axis.shape.transpose() * slope};
}

using SitesOfMember = std::vector<std::vector<std::size_t>>;

// The directions in which the drag that damps the first mode does not couple.
std::array<Vec3, 2> principal_directions(const OscillatorAxis& axis, const Mat3& drag) {
  const Vec3 first = axis.direction.unitOrthogonal(), second = axis.direction.cross(first);
  Eigen::Matrix2d across;
  across << first.dot(drag * first), first.dot(drag * second), second.dot(drag * first),
      second.dot(drag * second);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(0.5 * (across + across.transpose()));
  const Eigen::Vector2d main = solver.eigenvectors().col(1);
  const Vec3 along = main[0] * first + main[1] * second;
  return {along, axis.direction.cross(along)};
}

class Builder {
 public:
  Builder(const BeamTree& tree, const Sites& sites, const Loads& loads, const Damping& damping)
      : tree_(tree), sites_(sites), loads_(loads), damping_(damping), sites_of_(tree.parent.size()) {
    for (std::size_t s = 0; s < sites.sites.size(); ++s)
      sites_of_[index_of(sites.sites[s].point)].push_back(s);
  }

  BranchOscillators build(const BranchOscillatorOptions& options) {
    result_.modes = options.modes;
    result_.axes = axes_of(tree_);
    const auto masses = masses_on(tree_, result_.axes, options.carried_mass);
    tbb::parallel_for(std::size_t{0}, result_.axes.size(),
                      [&](std::size_t a) { find_shapes(tree_, masses[a], options.modes, result_.axes[a]); });
    for (int a = 0; a < static_cast<int>(result_.axes.size()); ++a) add_axis(a);
    const auto count =
        static_cast<Eigen::Index>(2 * options.modes) * static_cast<Eigen::Index>(result_.axes.size());
    OscillatorNetwork& network = result_.network;
    network.mass = Eigen::VectorXd::Ones(count);
    network.coupling.resize(count, count);
    network.coupling.setFromTriplets(coupling_.begin(), coupling_.end());
    network.damping.resize(count, count);
    network.damping.setFromTriplets(rates_.begin(), rates_.end());
    result_.participation.resize(count, 3 * sites_.point_count());
    result_.participation.setFromTriplets(gusts_.begin(), gusts_.end());
    return std::move(result_);
  }

 private:
  // The load on a coordinate of an axis that a force at a place is, for all of the axis and, of what goes on
  // along it, of those that carry it. take(row, weight): weight . force.
  template <class Take>
  void hand_down(int axis, double place, const Mat3& force, const Take& take) const {
    Mat3 handed = force;
    for (int a = axis; a >= 0; a = result_.axes[index_of(a)].parent) {
      const OscillatorAxis& on = result_.axes[index_of(a)];
      const Eigen::VectorXd value = values_at(on, place).value;
      for (int mode = 0; mode < result_.modes; ++mode) {
        for (int i = 0; i < 2; ++i)
          take(result_.index(a, mode, i), (value[mode] * handed.transpose() * on.across[index_of(i)]).eval());
      }
      handed = on.direction * (on.direction.transpose() * handed);
      place = on.attachment;
    }
  }

  void add_axis(int a) {
    OscillatorAxis& axis = result_.axes[index_of(a)];
    Mat3 first_mode = Mat3::Zero();
    for (std::size_t i = 0; i < axis.members.size(); ++i) {
      for_sites(axis, i, [&](std::size_t s, const ModeValues& values) {
        first_mode += values.value[0] * values.value[0] * loads_.sites[s].per_velocity;
      });
    }
    axis.across = principal_directions(axis, first_mode);
    const auto member_count = static_cast<Eigen::Index>(axis.members.size());
    axis.end_value.resize(member_count, result_.modes);
    axis.end_slope.resize(member_count, result_.modes);
    for (Eigen::Index i = 0; i < member_count; ++i) {
      const ModeValues at_end = values_at(axis, i + 1 < member_count ? axis.begin[index_of(i + 1)] : 1);
      axis.end_value.row(i) = at_end.value.transpose();
      axis.end_slope.row(i) = at_end.slope.transpose();
    }
    const Eigen::VectorXd own = structural_damping(damping_, axis.omega);
    for (int mode = 0; mode < result_.modes; ++mode) {
      for (int i = 0; i < 2; ++i) {
        const Eigen::Index row = result_.index(a, mode, i);
        coupling_.emplace_back(row, row, axis.omega[mode] * axis.omega[mode]);
        rates_.emplace_back(row, row, own[mode]);
        if (axis.parent < 0) continue;
        // Its shear force pulls the parent its way.
        Mat3 shear = Mat3::Zero();
        shear.col(0) = axis.omega[mode] * axis.omega[mode] * axis.momentum[mode] * axis.across[index_of(i)];
        hand_down(axis.parent, axis.attachment, shear, [&](Eigen::Index onto, const Vec3& weight) {
          if (weight[0] != 0) coupling_.emplace_back(onto, row, -weight[0]);
        });
      }
    }
    for (std::size_t i = 0; i < axis.members.size(); ++i) {
      Mat3 along = Mat3::Zero();  // of the wind at the member, on all of its sites
      for_sites(axis, i, [&](std::size_t s, const ModeValues& values) {
        const SiteLoad& load = loads_.sites[s];
        const Eigen::Index column = 3 * sites_.sites[s].point;
        const Mat3 gust = load.gust_share * load.per_velocity;
        for (int mode = 0; mode < result_.modes; ++mode) {
          for (int k = 0; k < 2; ++k) {
            const Vec3& across = axis.across[index_of(k)];
            const Eigen::Index row = result_.index(a, mode, k);
            add_gust(row, column, values.value[mode] * gust.transpose() * across);
            if (damping_.aerodynamic && loads_.damp) {
              rates_.emplace_back(
                  row, row, values.value[mode] * values.value[mode] * across.dot(load.per_velocity * across));
            }
          }
        }
        along += axis.direction * (axis.direction.transpose() * gust);
      });
      if (axis.parent < 0) continue;
      hand_down(axis.parent, axis.attachment, along, [&](Eigen::Index onto, const Vec3& weight) {
        add_gust(onto, Eigen::Index{3} * axis.members[i], weight);
      });
    }
  }

  template <class Look>
  void for_sites(const OscillatorAxis& axis, std::size_t i, const Look& look) const {
    const double length = tree_.members[index_of(axis.members[i])].beam.length;
    for (const std::size_t s : sites_of_[index_of(axis.members[i])])
      look(s, values_at(axis, axis.begin[i] + sites_.sites[s].place * length / axis.length));
  }

  void add_gust(Eigen::Index row, Eigen::Index column, const Vec3& weight) {
    for (int c = 0; c < 3; ++c) {
      if (weight[c] != 0) gusts_.emplace_back(row, column + c, weight[c]);
    }
  }

  const BeamTree& tree_;
  const Sites& sites_;
  const Loads& loads_;
  const Damping& damping_;
  SitesOfMember sites_of_;
  BranchOscillators result_;
  std::vector<Triplet> coupling_, rates_, gusts_;
};

}  // namespace

BranchOscillators branch_oscillators(const Structure& structure, const Sites& sites, const Loads& loads,
                                     const Damping& damping, const BranchOscillatorOptions& options) {
  if (!structure.tree) throw InputError("oscillators", "a frame", "a tree");
  if (options.modes < 1 || options.modes > 8)
    throw InputError("modes of every branch", std::to_string(options.modes), "1 to 8");
  check_equal("points of the sites", sites.point_count(), structure.tree->branch_count());
  check_loads(sites, loads);
  return Builder(*structure.tree, sites, loads, damping).build(options);
}

Eigen::VectorXd displacement_of(const BranchOscillators& oscillators, const Structure& structure,
                                const Eigen::VectorXd& coordinates) {
  if (!structure.tree) throw InputError("oscillators", "a frame", "a tree");
  check_equal("coordinates of the oscillators", coordinates.size(), oscillators.network.size());
  const BeamTree& tree = *structure.tree;
  Eigen::VectorXd displacement = Eigen::VectorXd::Zero(structure.size());
  for (std::size_t a = 0; a < oscillators.axes.size(); ++a) {
    const OscillatorAxis& axis = oscillators.axes[a];
    const int foot = axis.members.front(), carrier = tree.parent[index_of(foot)];
    Vec6 carried = Vec6::Zero();
    if (carrier >= 0) carried = displacement.segment<6>(6 * carrier);
    const Member& first = tree.members[index_of(foot)];
    const Vec3 pivot = first.start - first.start_arm;
    for (std::size_t i = 0; i < axis.members.size(); ++i) {
      const int k = axis.members[i];
      const Vec3 end = tree.members[index_of(k)].point(1);
      const auto row = static_cast<Eigen::Index>(i);
      Vec3 moved = Vec3::Zero(), slope = Vec3::Zero();
      for (int mode = 0; mode < oscillators.modes; ++mode) {
        for (int d = 0; d < 2; ++d) {
          const double q = coordinates[oscillators.index(static_cast<int>(a), mode, d)];
          moved += q * axis.end_value(row, mode) * axis.across[index_of(d)];
          slope += q * axis.end_slope(row, mode) * axis.across[index_of(d)];
        }
      }
      displacement.segment<3>(6 * k) = carried.head<3>() + carried.tail<3>().cross(end - pivot) + moved;
      displacement.segment<3>(6 * k + 3) = carried.tail<3>() + axis.direction.cross(slope);
    }
  }
  return displacement;
}

}  // namespace tremula
