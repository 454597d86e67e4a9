#include "tremula/structure/prestress.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/error.hpp"
#include "tremula/numerics/quadrature.hpp"
#include "tremula/structure/element_blocks.hpp"

#include <algorithm>
#include <numbers>
#include <numeric>
#include <span>
#include <string>
#include <utility>

#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>

namespace tremula {
namespace {

using ThreeBySix = Eigen::Matrix<double, 3, 6>;
using SixByThree = Eigen::Matrix<double, 6, 3>;

// What a unit force on the branch meets, as scalars of the beam's shape functions for a displacement of end 1
// alone: p_1, p_2 the slope by (v_1, phi_1), alpha the twist, beta the stretch.
struct LoadIntegrals {
  double slope_11 = 0, slope_12 = 0, slope_22 = 0;            // int p_a p_b [1/m, 1, m]
  Eigen::Vector2d twist_bending = Eigen::Vector2d::Zero();    // int (x_f - x) alpha p_a' [1, m]
  Eigen::Vector2d stretch_bending = Eigen::Vector2d::Zero();  // int beta' p_a [1/m, 1]
  double along = 0;                                           // beta where the force is
  Eigen::Vector2d across = Eigen::Vector2d::Zero();           // the deflection there [1, m]

  // dx of the beam, with `force` [-] beyond it at a distance of `moment`/`force` [m].
  void add(const Shape& shape, const Strain& strain, double dx, double force, double moment) {
    const Eigen::Vector2d slope = shape.slope.tail<2>();
    slope_11 += dx * force * slope[0] * slope[0];
    slope_12 += dx * force * slope[0] * slope[1];
    slope_22 += dx * force * slope[1] * slope[1];
    twist_bending += dx * moment * shape.torsion[1] * strain.curvature;
    stretch_bending += dx * force * strain.axial * slope;
  }
  // The spring at the base turns by one rotation and not by a path of them: half of what the jump from 0 is.
  void add_base(const Shape& foot, double moment) {
    twist_bending += 0.5 * moment * foot.torsion[1] * foot.slope.tail<2>();
  }
  void move(const Shape& shape, double force) {
    along += force * shape.axial[1];
    across += force * shape.deflection.tail<2>();
  }
};

// A point of the beam's quadrature, and how long a piece of it it stands for.
struct BeamPoint {
  double s, length;  // [-, m]
  Shape shape;
  Strain strain;
};

// What turns with the branch in other ways than its end: int (alpha' p_a - alpha p_a'), int (p_1 p_2' - p_2
// p_1').
struct PathIntegrals {
  Eigen::Vector2d twist_slope = Eigen::Vector2d::Zero();
  double slopes = 0;

  void add(const BeamPoint& at) {
    const Eigen::Vector2d slope = at.shape.slope.tail<2>();
    twist_slope += at.length * (at.strain.torsion * slope - at.shape.torsion[1] * at.strain.curvature);
    slopes += at.length * (slope[0] * at.strain.curvature[1] - slope[1] * at.strain.curvature[0]);
  }
};

double radius_at(const Beam& beam, double s) {
  return beam.start_radius + s * (beam.end_radius - beam.start_radius);
}

// Exact for equal radii, and to rounding up to a ratio of 3: the integrands are rational functions whose
// poles are the farther away, the less the piece tapers.
const std::vector<QuadraturePoint>& quadrature_for(double start_radius, double end_radius) {
  static const std::vector<QuadraturePoint> uniform = gauss_legendre(4), slight = gauss_legendre(6),
                                            small = gauss_legendre(8), gentle = gauss_legendre(12),
                                            strong = gauss_legendre(64);
  const double ratio = std::max(start_radius / end_radius, end_radius / start_radius);
  return ratio == 1 ? uniform : ratio < 1.2 ? slight : ratio < 1.5 ? small : ratio < 3 ? gentle : strong;
}

// All integrals along a branch, from its start as far as it has been walked.
class Walk {
 public:
  Walk(const Beam& beam, const Compliance& compliance) : beam_(beam), compliance_(compliance) {}

  void go_to(double s) {
    for (const QuadraturePoint& point : quadrature_for(radius_at(beam_, at_), radius_at(beam_, s))) {
      const double place = at_ + point.position * (s - at_), length = point.weight * (s - at_) * beam_.length;
      pass({place, length, shape_at(beam_, place), strain_at(beam_, compliance_, place)});
    }
    at_ = s;
  }

  // Of a unit force where the walk has come to.
  LoadIntegrals of_force_here() const {
    const double x = at_ * beam_.length;
    LoadIntegrals integrals = unit_;
    integrals.twist_bending = x * unit_.twist_bending - twist_lever_;
    integrals.add_base(foot_, x);
    integrals.move(shape_at(beam_, at_), 1);
    return integrals;
  }

  // At the end, of a unit force on every unit of volume; and what no force changes.
  LoadIntegrals of_volume() const {
    LoadIntegrals integrals = volume_;
    integrals.add_base(foot_, volume_beyond(beam_, 0).moment);
    return integrals;
  }
  const PathIntegrals& path() const { return path_; }

 private:
  void pass(const BeamPoint& at) {
    unit_.add(at.shape, at.strain, at.length, 1, 1);
    twist_lever_ += at.length * at.s * beam_.length * at.shape.torsion[1] * at.strain.curvature;
    const VolumeBeyond beyond = volume_beyond(beam_, at.s);
    volume_.add(at.shape, at.strain, at.length, beyond.volume, beyond.moment);
    const double radius = radius_at(beam_, at.s);
    volume_.move(at.shape, at.length * std::numbers::pi * radius * radius * beam_.tube.area);
    path_.add(at);
  }

  const Beam& beam_;
  const Compliance& compliance_;
  const Shape foot_ = shape_at(beam_, 0);
  double at_ = 0;
  LoadIntegrals unit_, volume_;                            // twist_bending of unit_: int alpha p_a'
  Eigen::Vector2d twist_lever_ = Eigen::Vector2d::Zero();  // int x alpha p_a' [m]
  PathIntegrals path_;
};

// Takes the second-order work of a force on the branch, or of those beyond its end at the end, from the
// potential. With e = (v, phi) along d and across it: twist phi . d, slope phi x d.
void add_force(const LoadIntegrals& integrals, const Vec3& force, const Vec3& d, GeometricStiffness& result) {
  const Mat3 along = d * d.transpose(), across = Mat3::Identity() - along, cross = cross_matrix(d);
  const double tension = force.dot(d);
  const Vec3 lateral = across * force, turned = cross * force;
  const Mat3 force_cross = cross_matrix(force);
  const Mat3 bent = d * lateral.transpose();
  Mat3 vv = -tension * integrals.slope_11 * across + integrals.stretch_bending[0] * (bent + bent.transpose());
  Mat3 vr = tension * integrals.slope_12 * cross + integrals.stretch_bending[1] * d * turned.transpose() -
            integrals.twist_bending[0] * turned * d.transpose();
  Mat3 rr = -tension * integrals.slope_22 * across + integrals.twist_bending[1] * (bent + bent.transpose());
  Mat6 work;
  work << vv, vr, vr.transpose(), rr;
  result.relative -= work;
  result.carried.leftCols<3>() += force_cross * (integrals.along * along + integrals.across[0] * across);
  result.carried.rightCols<3>() -= force_cross * (integrals.across[1] * cross);
}

// The same of the moments about the end, W = sum of (x - x_end) f^T over the forces beyond it.
void add_moments(const PathIntegrals& path, const Mat3& moments, const Vec3& d, GeometricStiffness& result) {
  const Mat3 a = moments - moments.trace() * Mat3::Identity();
  const Vec3 moment(moments(1, 2) - moments(2, 1), moments(2, 0) - moments(0, 2),
                    moments(0, 1) - moments(1, 0));
  const Vec3 lateral = moment - moment.dot(d) * d, turned = d.cross(moment);
  const Mat3 bent = d * turned.transpose();
  Mat6 work = Mat6::Zero();
  work.topRightCorner<3, 3>() = 0.5 * path.twist_slope[0] * lateral * d.transpose() -
                                0.5 * path.slopes * moment.dot(d) * (Mat3::Identity() - d * d.transpose());
  work.bottomLeftCorner<3, 3>() = work.topRightCorner<3, 3>().transpose();
  work.bottomRightCorner<3, 3>() =
      0.5 * (a + a.transpose()) + 0.5 * path.twist_slope[1] * (bent + bent.transpose());
  result.relative -= work;
  result.carried.rightCols<3>() -= a;
}

}  // namespace

void check_dead_loads(const BeamTree& tree, const DeadLoads& loads) {
  check_equal("branches with a load by volume", static_cast<std::ptrdiff_t>(loads.per_volume.size()),
              tree.branch_count());
  for (const PointForce& point : loads.points) {
    if (point.branch < 0 || point.branch >= tree.branch_count()) {
      throw InputError("branch of a force", std::to_string(point.branch),
                       "0 to " + std::to_string(tree.branch_count() - 1));
    }
    if (!(point.position >= 0 && point.position <= 1)) {
      throw InputError("position of a force", std::to_string(point.position), "0 to 1");
    }
  }
}

DeadLoads weight(const Skeleton& skeleton, const StructureOptions& options) {
  const Vec3 down(0, 0, -options.gravity);
  const double fluid = options.added_mass_density;
  DeadLoads loads;
  for (const Branch& branch : skeleton.branches)
    loads.per_volume.push_back((options.material.density - fluid / tube_share(branch.wall).area) * down);
  for (const Leaf& leaf : skeleton.leaves) {
    loads.points.push_back(
        {leaf.branch, leaf.position, leaf.mass * std::max(0.0, 1 - fluid / blade_density) * down});
  }
  return loads;
}

namespace {

// The forces on each branch, from its start to its end.
class ForcesOnBranches {
 public:
  ForcesOnBranches(std::size_t branches, const std::vector<PointForce>& forces)
      : first_(branches + 1, 0), forces_(forces.size()) {
    for (const PointForce& force : forces) ++first_[index_of(force.branch) + 1];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    for (const PointForce& force : forces) forces_[next[index_of(force.branch)]++] = force;
    for (std::size_t k = 0; k < branches; ++k) {
      std::ranges::stable_sort(forces_.begin() + static_cast<std::ptrdiff_t>(first_[k]),
                               forces_.begin() + static_cast<std::ptrdiff_t>(first_[k + 1]), {},
                               &PointForce::position);
    }
  }
  std::span<const PointForce> on(std::size_t k) const {
    return {forces_.data() + first_[k], first_[k + 1] - first_[k]};
  }

 private:
  std::vector<std::size_t> first_;
  std::vector<PointForce> forces_;
};

// What depends on the branch alone of what is beyond its end.
struct AtEnd {
  LoadIntegrals force;
  PathIntegrals path;
};

// Takes the work of the forces on one branch from the potential.
AtEnd add_own_loads(const BeamTree& tree, std::size_t k, std::span<const PointForce> forces,
                    const Vec3& by_volume, GeometricStiffness& result) {
  const Vec3& d = tree.members[k].direction;
  Walk walk(tree.members[k].beam, tree.compliances[k]);
  double at = 0;
  for (const PointForce& point : forces) {
    if (point.force.isZero(0)) continue;
    if (point.position > at) walk.go_to(at = point.position);
    add_force(walk.of_force_here(), point.force, d, result);
  }
  if (at < 1) walk.go_to(1);
  if (!by_volume.isZero(0)) add_force(walk.of_volume(), by_volume, d, result);
  return {walk.of_force_here(), walk.path()};
}

}  // namespace

std::vector<GeometricStiffness> geometric_stiffness(const BeamTree& tree, const DeadLoads& loads) {
  check_dead_loads(tree, loads);
  std::vector<GeometricStiffness> result(tree.parent.size());
  std::vector<AtEnd> at_end(tree.parent.size());
  const ForcesOnBranches forces(tree.parent.size(), loads.points);
  tbb::parallel_for(std::size_t{0}, tree.parent.size(), [&](std::size_t k) {
    at_end[k] = add_own_loads(tree, k, forces.on(k), loads.per_volume[k], result[k]);
  });
  // What is beyond the end of each branch, about that end; and what is on it, about the node that carries it.
  std::vector<Vec3> force(tree.parent.size(), Vec3::Zero());
  std::vector<Mat3> moments(tree.parent.size(), Mat3::Zero());
  std::vector<Vec3> own_force(tree.parent.size(), Vec3::Zero());
  std::vector<Mat3> own_moments(tree.parent.size(), Mat3::Zero());
  for (const PointForce& point : loads.points) {
    const std::size_t k = index_of(point.branch);
    const Member& member = tree.members[k];
    own_force[k] += point.force;
    own_moments[k] +=
        (member.start_arm + point.position * member.beam.length * member.direction) * point.force.transpose();
  }
  for (int i = tree.branch_count() - 1; i >= 0; --i) {
    const std::size_t k = index_of(i);
    const Member& member = tree.members[k];
    const Vec3& d = member.direction;
    const Vec3& by_volume = loads.per_volume[k];
    if (!force[k].isZero(0) || !moments[k].isZero(0)) {
      add_force(at_end[k].force, force[k], d, result[k]);
      add_moments(at_end[k].path, moments[k], d, result[k]);
    }
    const int parent = tree.parent[k];
    if (parent < 0) continue;
    const VolumeBeyond all = volume_beyond(member.beam, 0);
    own_force[k] += all.volume * by_volume;
    own_moments[k] += (all.volume * member.start_arm + all.moment * d) * by_volume.transpose();
    force[index_of(parent)] += force[k] + own_force[k];
    moments[index_of(parent)] += moments[k] + tree.reach[k] * force[k].transpose() + own_moments[k];
  }
  return result;
}

namespace {

// The lower triangle R with R R^T = T^T T, found without squaring T.
Mat6 lower_root(const Mat6& t) {
  const Mat6 upper = Eigen::HouseholderQR<Mat6>(t).matrixQR();
  return upper.transpose().triangularView<Eigen::Lower>();
}

// lower^-1 b: Eigen takes the way of large matrices for it.
template <int columns>
Eigen::Matrix<double, 6, columns> solve_lower(const Mat6& lower, const Eigen::Matrix<double, 6, columns>& b) {
  Eigen::Matrix<double, 6, columns> x;
  for (int i = 0; i < 6; ++i) {
    Eigen::Matrix<double, 1, columns> rest = b.row(i);
    for (int j = 0; j < i; ++j) rest -= lower(i, j) * x.row(j);
    x.row(i) = rest / lower(i, i);
  }
  return x;
}

// Takes the loads from a branch and all that it carries. How many these are.
int unload(int branch, BeamTree& tree) {
  std::vector<bool> carried(tree.parent.size(), false);
  int count = 0;
  for (int k = branch; k < tree.branch_count(); ++k) {
    const int parent = tree.parent[index_of(k)];
    carried[index_of(k)] = k == branch || (parent >= 0 && carried[index_of(parent)]);
    if (!carried[index_of(k)]) continue;
    ++count;
    tree.geometric[index_of(k)] = {};
    LoadedBranch& loaded = tree.loaded[index_of(k)];
    loaded.root = lower_root(
        compliance_root(tree.compliances[index_of(k)], tree.members[index_of(k)].direction).transpose());
    loaded.carry << -cross_matrix(tree.reach[index_of(k)]), Mat3::Identity();
  }
  return count;
}

}  // namespace

bool take_load(std::vector<GeometricStiffness> geometric, BeamTree& tree, double given_up) {
  check_equal("branches with a geometric stiffness", static_cast<std::ptrdiff_t>(geometric.size()),
              tree.branch_count());
  tree.geometric = std::move(geometric);
  tree.loaded.assign(tree.parent.size(), {});
  // What hangs on the end of each branch resists its rotation alone: nothing heeds a translation.
  std::vector<Mat3> hung(tree.parent.size(), Mat3::Zero());
  int freed = 0;
  for (int i = tree.branch_count() - 1; i >= 0; --i) {
    const std::size_t k = index_of(i);
    Mat6 end = tree.geometric[k].relative;
    end.bottomRightCorner<3, 3>() += hung[k];
    ThreeBySix coupling = tree.geometric[k].carried;
    coupling.rightCols<3>() += hung[k];
    const Mat6 root = compliance_root(tree.compliances[k], tree.members[k].direction);
    const Eigen::LLT<Mat6> pivot(Mat6::Identity() + root.transpose() * end * root);
    if (pivot.info() != Eigen::Success) {
      if (given_up == 0) return false;
      freed += unload(i, tree);
      if (freed > given_up * tree.branch_count()) return false;
      continue;
    }
    const Mat6 lower = pivot.matrixL();
    const SixByThree half = solve_lower<3>(lower, root.transpose() * coupling.transpose());
    const Mat6 stretched = solve_lower<6>(lower, root.transpose());  // S P^-1 S^T = T^T T with T = L^-1 S^T
    tree.loaded[k].root = lower_root(stretched);
    tree.loaded[k].carry = -stretched.transpose() * half;
    tree.loaded[k].carry.topRows<3>() -= cross_matrix(tree.reach[k]);
    tree.loaded[k].carry.bottomRows<3>() += Mat3::Identity();
    const int parent = tree.parent[k];
    if (parent >= 0) hung[index_of(parent)] += hung[k] - half.transpose() * half;
  }
  return true;
}

BeamTree under_load(BeamTree tree, const DeadLoads& loads) {
  if (!take_load(geometric_stiffness(tree, loads), tree))
    throw InputError("loads on the plant", "more than it can stand under", "smaller ones");
  return tree;
}

}  // namespace tremula
