#include "tremula/structure/sites.hpp"

#include "tremula/base/check.hpp"
#include "tremula/numerics/quadrature.hpp"

#include <algorithm>
#include <numbers>
#include <utility>

namespace tremula {
namespace {

// What carries a site.
struct Hold {
  int member;
  double place;  // 0 start … 1 end
};

// All that the functions of the sites work on.
struct BeamSites {
  std::shared_ptr<const void> owner;
  std::span<const Member> members;
  std::vector<Hold> holds;
  Eigen::Index row_count;
};

// What shape says of the ends at every site.
Eigen::MatrixXd motion_of(const BeamSites& beams, PointShape (*shape)(const Member&, double),
                          std::size_t first, std::size_t last,
                          Eigen::Ref<const Eigen::MatrixXd> displacements) {
  check_equal("rows of the displacements", displacements.rows(), beams.row_count);
  Eigen::MatrixXd motion(3 * static_cast<Eigen::Index>(last - first), displacements.cols());
  Eigen::MatrixXd ends(12, displacements.cols());
  for (std::size_t s = first; s < last; ++s) {
    const Hold& hold = beams.holds[s];
    const Member& member = beams.members[static_cast<std::size_t>(hold.member)];
    if (s == first || hold.member != beams.holds[s - 1].member) {
      for (Eigen::Index c = 0; c < displacements.cols(); ++c) {
        const EndDisplacements moved = end_displacements(member, displacements.col(c));
        ends.col(c) << moved.start_translation, moved.start_rotation, moved.end_translation,
            moved.end_rotation;
      }
    }
    motion.middleRows<3>(3 * static_cast<Eigen::Index>(s - first)).noalias() =
        shape(member, hold.place).transpose() * ends;
  }
  return motion;
}

// The forces of all sites of one member as those on its two nodes, member by member.
Eigen::VectorXd gathered(const BeamSites& beams, const Eigen::Matrix3Xd& forces) {
  check_equal("columns of the forces on the sites", forces.cols(),
              static_cast<Eigen::Index>(beams.holds.size()));
  Eigen::VectorXd total = Eigen::VectorXd::Zero(beams.row_count);
  Eigen::Matrix<double, 12, 1> ends = Eigen::Matrix<double, 12, 1>::Zero();
  for (std::size_t s = 0; s < beams.holds.size(); ++s) {
    const Hold& hold = beams.holds[s];
    const Member& member = beams.members[static_cast<std::size_t>(hold.member)];
    ends += point_shape(member, hold.place) * forces.col(static_cast<Eigen::Index>(s));
    if (s + 1 < beams.holds.size() && beams.holds[s + 1].member == hold.member) continue;
    const Vec3 at_start = ends.head<3>();
    Vec6 start;
    start << at_start, ends.segment<3>(3) + member.start_arm.cross(at_start);
    if (member.end_row >= 0) total.segment<6>(member.end_row) += ends.tail<6>();
    if (member.start_row >= 0) total.segment<6>(member.start_row) += start;
    ends.setZero();
  }
  return total;
}

// What two parts say of sites first … last - 1, of which the first part has `split`.
template <class Told>
Eigen::MatrixXd told_by_both(const Told& one, const Told& other, std::size_t split, std::size_t first,
                             std::size_t last, Eigen::Ref<const Eigen::MatrixXd> displacements) {
  if (last <= split) return one(first, last, displacements);
  if (first >= split) return other(first - split, last - split, displacements);
  Eigen::MatrixXd both(3 * static_cast<Eigen::Index>(last - first), displacements.cols());
  both << one(first, split, displacements), other(0, last - split, displacements);
  return both;
}

}  // namespace

Sites join(Sites first, Sites second) {
  Sites result;
  const std::size_t split = first.sites.size();
  result.points.resize(3, first.point_count() + second.point_count());
  result.points << first.points, second.points;
  result.sites = std::move(first.sites);
  for (Site& site : second.sites) {
    site.point += static_cast<int>(first.point_count());
    result.sites.push_back(site);
  }
  const auto told = [split](auto one, auto other) {
    return [split, one = std::move(one), other = std::move(other)](
               std::size_t begin, std::size_t end, Eigen::Ref<const Eigen::MatrixXd> displacements) {
      return told_by_both(one, other, split, begin, end, displacements);
    };
  };
  result.motion = told(std::move(first.motion), std::move(second.motion));
  result.turning = told(std::move(first.turning), std::move(second.turning));
  result.gather = [split, one = std::move(first.gather),
                   other = std::move(second.gather)](const Eigen::Matrix3Xd& forces) -> Eigen::VectorXd {
    const auto own = static_cast<Eigen::Index>(split);
    return one(forces.leftCols(own)) + other(forces.rightCols(forces.cols() - own));
  };
  return result;
}

std::vector<SiteBlock> cut_between_points(const Sites& sites) {
  constexpr std::size_t sites_together = 2048;
  std::vector<SiteBlock> blocks;
  for (std::size_t first = 0, last; first < sites.sites.size(); first = last) {
    last = std::min(first + sites_together, sites.sites.size());
    while (last < sites.sites.size() && sites.sites[last].point == sites.sites[last - 1].point) ++last;
    blocks.push_back({first, last});
  }
  return blocks;
}

Sites find_sites(std::span<const Member> members, std::shared_ptr<const void> owner,
                 std::span<const BladeSite> blades, Eigen::Index row_count) {
  static const std::vector<QuadraturePoint> quadrature = gauss_legendre(4);
  std::vector<std::vector<std::size_t>> blades_of(blades.empty() ? 0 : members.size());
  for (std::size_t i = 0; i < blades.size(); ++i)
    blades_of[static_cast<std::size_t>(blades[i].member)].push_back(i);

  const auto beams = std::make_shared<BeamSites>(BeamSites{std::move(owner), members, {}, row_count});
  Sites result;
  result.points.resize(3, static_cast<Eigen::Index>(members.size()));
  const std::size_t count = quadrature.size() * members.size() + blades.size();
  result.sites.reserve(count);
  beams->holds.reserve(count);
  for (std::size_t k = 0; k < members.size(); ++k) {
    const Member& member = members[k];
    const int index = static_cast<int>(k);
    result.points.col(index) = member.point(0.5);
    const Beam& beam = member.beam;
    for (const QuadraturePoint& point : quadrature) {
      const double diameter =
          2 * (beam.start_radius + point.position * (beam.end_radius - beam.start_radius));
      const double length = beam.length * point.weight;
      result.sites.push_back({index, SiteKind::cylinder, member.direction, diameter * length, point.position,
                              (beam.start_radius + beam.end_radius) * length,
                              std::numbers::pi / 4 * diameter * diameter * length,
                              std::numbers::pi / 4 * diameter * diameter * length});
      beams->holds.push_back({index, point.position});
    }
    if (blades_of.empty()) continue;
    for (const std::size_t i : blades_of[k]) {
      const BladeSite& blade = blades[i];
      result.sites.push_back({index, blade.is_ribbon ? SiteKind::ribbon : SiteKind::blade, blade.normal,
                              blade.area, blade.place, 0, blade.mass / blade_density, blade.carried});
      beams->holds.push_back({index, blade.place});
    }
  }
  result.motion = [beams](std::size_t first, std::size_t last,
                          Eigen::Ref<const Eigen::MatrixXd> displacements) {
    return motion_of(*beams, point_shape, first, last, displacements);
  };
  result.turning = [beams](std::size_t first, std::size_t last,
                           Eigen::Ref<const Eigen::MatrixXd> displacements) {
    return motion_of(*beams, turn_shape, first, last, displacements);
  };
  result.gather = [beams](const Eigen::Matrix3Xd& forces) { return gathered(*beams, forces); };
  return result;
}

}  // namespace tremula
