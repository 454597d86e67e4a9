#include "tremula/structure/prestress.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/error.hpp"
#include "tremula/structure/element_blocks.hpp"

#include <algorithm>
#include <string>
#include <utility>

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

// What turns with the branch in other ways than its end: int (alpha' p_a - alpha p_a'), int (p_1 p_2' - p_2
// p_1').
struct PathIntegrals {
  Eigen::Vector2d twist_slope = Eigen::Vector2d::Zero();
  double slopes = 0;
};

// The beam at the points of its quadrature, and how long a piece of it each stands for.
struct BeamPoint {
  VolumePoint at;
  Shape shape;
  Strain strain;
};

// Up to `end` (1: the whole beam). The quadrature is that of the whole, which a part needs no more than.
std::vector<BeamPoint> beam_points(const Beam& beam, const Compliance& c, double end = 1) {
  std::vector<BeamPoint> points;
  for (const VolumePoint& point : volume_points(beam)) {
    const double s = end * point.s;
    points.push_back({{s, end * point.length, end * point.volume}, shape_at(beam, s), strain_at(beam, c, s)});
  }
  return points;
}

PathIntegrals path_integrals(const std::vector<BeamPoint>& points) {
  PathIntegrals path;
  for (const auto& [at, shape, strain] : points) {
    const Eigen::Vector2d slope = shape.slope.tail<2>();
    path.twist_slope += at.length * (strain.torsion * slope - shape.torsion[1] * strain.curvature);
    path.slopes += at.length * (slope[0] * strain.curvature[1] - slope[1] * strain.curvature[0]);
  }
  return path;
}

// Of a unit force at s, from the points up to there.
LoadIntegrals of_force_at(const Beam& beam, double s, const std::vector<BeamPoint>& points) {
  LoadIntegrals integrals;
  for (const auto& [at, shape, strain] : points)
    integrals.add(shape, strain, at.length, 1, (s - at.s) * beam.length);
  integrals.add_base(shape_at(beam, 0), s * beam.length);
  integrals.move(shape_at(beam, s), 1);
  return integrals;
}

// Of a unit force on every unit of volume.
LoadIntegrals of_volume(const Beam& beam, const std::vector<BeamPoint>& points) {
  LoadIntegrals integrals;
  for (const auto& [at, shape, strain] : points) {
    const VolumeBeyond beyond = volume_beyond(beam, at.s);
    integrals.add(shape, strain, at.length, beyond.volume, beyond.moment);
    integrals.move(shape, at.volume);
  }
  integrals.add_base(shape_at(beam, 0), volume_beyond(beam, 0).moment);
  return integrals;
}

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
  loads.per_volume.assign(skeleton.branches.size(), (options.material.density - fluid) * down);
  for (const Leaf& leaf : skeleton.leaves) {
    constexpr double water = 1000;  // [kg/m^3]
    loads.points.push_back({leaf.branch, leaf.position, leaf.mass * std::max(0.0, 1 - fluid / water) * down});
  }
  return loads;
}

std::vector<GeometricStiffness> geometric_stiffness(const BeamTree& tree, const DeadLoads& loads) {
  check_dead_loads(tree, loads);
  std::vector<GeometricStiffness> result(tree.parent.size());
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
    if (point.force.isZero(0)) continue;
    const std::vector<BeamPoint> points = beam_points(member.beam, tree.compliances[k], point.position);
    add_force(of_force_at(member.beam, point.position, points), point.force, member.direction, result[k]);
  }
  for (int i = tree.branch_count() - 1; i >= 0; --i) {
    const std::size_t k = index_of(i);
    const Member& member = tree.members[k];
    const Vec3& d = member.direction;
    const Vec3& by_volume = loads.per_volume[k];
    const std::vector<BeamPoint> points = beam_points(member.beam, tree.compliances[k]);
    add_force(of_volume(member.beam, points), by_volume, d, result[k]);
    if (!force[k].isZero(0) || !moments[k].isZero(0)) {
      add_force(of_force_at(member.beam, 1, points), force[k], d, result[k]);
      add_moments(path_integrals(points), moments[k], d, result[k]);
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
    const SixByThree half = pivot.matrixL().solve(root.transpose() * coupling.transpose());
    const Mat6 stretched = pivot.matrixL().solve(root.transpose());  // S P^-1 S^T = T^T T with T = L^-1 S^T
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
