#include "tremula/dynamics/lean.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace tremula {
namespace {

std::vector<GustStatistics> wind_of_points(const WindAt& wind, const Eigen::Matrix3Xd& points) {
  std::vector<GustStatistics> result;
  for (Eigen::Index p = 0; p < points.cols(); ++p) result.push_back(wind(p, points.col(p)));
  return result;
}

// (S) What the sites leave of the wind for each other. The drag of leaves that fold depends on the wind that
// is left of `before`.
Eigen::VectorXd shares_of_wind(const Sites& sites, const Eigen::Matrix3Xd& places,
                               const std::vector<GustStatistics>& wind, const LoadLaw& law,
                               const ShelterOptions& options, const Eigen::VectorXd& before) {
  Vec3 mean = Vec3::Zero();
  for (const GustStatistics& at_point : wind) mean += at_point.mean;
  if (!options.on || mean.norm() == 0) return Eigen::VectorXd::Ones(before.size());
  Eigen::VectorXd areas(before.size());
  for (Eigen::Index s = 0; s < areas.size(); ++s) {
    const Site& site = sites.sites[index_of(s)];
    areas[s] = drag_area(site, before[s] * wind[index_of(site.point)].mean, law);
  }
  return find_shelter(places, areas, mean.normalized(), options);
}

constexpr int most_rounds = 20;

// (S) What shelter leaves of the wind, found in rounds: less wind folds fewer leaves, which leave less of it.
// The two last rounds tell where the next would make no difference (Anderson 1965, J. ACM 12, with a memory
// of one).
struct Shares {
  Eigen::VectorXd now, last = {}, last_change = {};

  // True where nothing changes any more.
  bool settle(const Eigen::VectorXd& left) {
    constexpr double settled = 1e-4;  // of the wind
    const Eigen::VectorXd change = left - now;
    double back = 0;  // of the way to the last
    if (last.size() > 0) {
      const Eigen::VectorXd differs = change - last_change;
      const double size = differs.squaredNorm();
      if (size > 0) back = std::clamp(change.dot(differs) / size, -0.5, 1.0);
    }
    Eigen::VectorXd next = now + change;
    if (back != 0) next += back * (last + last_change - next);
    last = std::move(now);
    last_change = change;
    now = next.cwiseMax(0).cwiseMin(1);
    return change.cwiseAbs().maxCoeff() < settled;
  }
};

// Where each site is on members that stand straight.
Eigen::Matrix3Xd places_of(const Structure& structure, const Sites& sites) {
  Eigen::Matrix3Xd places(3, static_cast<Eigen::Index>(sites.sites.size()));
  for (Eigen::Index s = 0; s < places.cols(); ++s) {
    const Site& site = sites.sites[index_of(s)];
    places.col(s) = structure.members[index_of(site.point)].point(site.place);
  }
  return places;
}

Lean small_lean(const Structure& structure, const WindAt& wind, const LoadLaw& law,
                const LeanOptions& options) {
  Lean lean{.displacement = {}, .structure = structure, .sites = structure.find_sites(), .loads = {}};
  const std::vector<GustStatistics> at_points = wind_of_points(wind, lean.sites.points);
  const Eigen::Matrix3Xd places = places_of(structure, lean.sites);
  Shares share{Eigen::VectorXd::Ones(places.cols())};
  for (int round = 0; round < most_rounds; ++round) {
    if (share.settle(shares_of_wind(lean.sites, places, at_points, law, options.shelter, share.now))) break;
  }
  lean.loads = find_loads(lean.sites, at_points, law, share.now);
  lean.displacement = structure.flexibility(mean_force(lean.sites, lean.loads));
  return lean;
}

// The drag on the branches of a tree, wherever they are.
class DragOnBranches {
 public:
  DragOnBranches(const BeamTree& tree, const Sites& sites, const WindAt& wind, const LoadLaw& law)
      : tree_(tree), sites_(sites), wind_(wind), law_(law), first_(tree.parent.size() + 1, 0) {
    for (const Site& site : sites.sites) ++first_[index_of(site.point) + 1];
    for (std::size_t k = 1; k < first_.size(); ++k) first_[k] += first_[k - 1];
  }

  EndLoads on(int k, const BentBranch& branch, const Eigen::VectorXd& share) const {
    const Member& member = tree_.members[index_of(k)];
    const GustStatistics here = wind_(k, point_on(member, branch, 0.5).position);
    EndLoads loads;
    for (std::size_t s = first_[index_of(k)]; s < first_[index_of(k) + 1]; ++s) {
      Site site = sites_.sites[s];
      site.axis = point_on(member, branch, site.place).frame * site.axis;
      const SiteLoad load = load_on(site, here, share[static_cast<Eigen::Index>(s)], law_);
      add_force(member, branch, site.place, load.mean, load.turning, loads);
    }
    return loads;
  }

  // What shelters what on the bent tree.
  Eigen::VectorXd shares(const std::vector<BentBranch>& bent, const ShelterOptions& options,
                         const Eigen::VectorXd& before) const {
    Sites turned{.points = Eigen::Matrix3Xd(3, sites_.points.cols()),
                 .sites = sites_.sites,
                 .motion = {},
                 .turning = {},
                 .gather = {}};
    Eigen::Matrix3Xd places(3, static_cast<Eigen::Index>(turned.sites.size()));
    for (std::size_t k = 0; k < bent.size(); ++k)
      turned.points.col(static_cast<Eigen::Index>(k)) = point_on(tree_.members[k], bent[k], 0.5).position;
    for (std::size_t s = 0; s < turned.sites.size(); ++s) {
      Site& site = turned.sites[s];
      const BentPoint point =
          point_on(tree_.members[index_of(site.point)], bent[index_of(site.point)], site.place);
      site.axis = point.frame * site.axis;
      places.col(static_cast<Eigen::Index>(s)) = point.position;
    }
    return shares_of_wind(turned, places, wind_of_points(wind_, turned.points), law_, options, before);
  }

 private:
  const BeamTree& tree_;
  const Sites& sites_;
  const WindAt& wind_;
  const LoadLaw& law_;
  std::vector<std::size_t> first_;  // site of every branch
};

double farthest(const std::vector<BentBranch>& a, const std::vector<BentBranch>& b) {
  double distance = 0;
  for (std::size_t k = 0; k < a.size(); ++k) distance = std::max(distance, (a[k].end - b[k].end).norm());
  return distance;
}

double size_of(const std::vector<BentBranch>& bent) {
  Eigen::AlignedBox3d box;
  for (const BentBranch& branch : bent) box.extend(branch.start).extend(branch.end);
  return box.diagonal().norm();
}

// Forces on the strains that the given shape answers to: those of its weight.
Eigen::VectorXd weight_at_rest(const BeamTree& tree, const DeadLoadsOnBranches& weight,
                               const std::vector<BentBranch>& given) {
  const BranchLoads loads = [&](int k, const BentBranch& branch) {
    EndLoads load;
    weight.add_to(k, branch, load);
    return load;
  };
  return forces_on_strains(tree, Eigen::VectorXd::Zero(tree.size()), given,
                           sum_wrenches(tree, given, loads).at_end);
}

std::vector<PointForce> drag_of_sites(const Lean& lean) {
  std::vector<PointForce> forces;
  for (std::size_t s = 0; s < lean.loads.sites.size(); ++s)
    forces.push_back({lean.sites.sites[s].point, lean.sites.sites[s].place, lean.loads.sites[s].mean});
  return forces;
}

// In turn, what the crown leaves of the wind and how the tree stands in it.
Lean large_lean(const Structure& structure, const WindAt& wind, const LoadLaw& law,
                const LeanOptions& options) {
  constexpr double settled = 1e-5;  // of the size of the tree
  const BeamTree& tree = *structure.tree;
  const Sites sites = structure.find_sites();
  const DragOnBranches drag(tree, sites, wind, law);
  Shares share{Eigen::VectorXd::Ones(static_cast<Eigen::Index>(sites.sites.size()))};
  const bool heavy = !structure.weight.per_volume.empty();
  const DeadLoadsOnBranches weight(
      tree, heavy ? structure.weight : DeadLoads{std::vector<Vec3>(tree.parent.size(), Vec3::Zero()), {}});
  const BranchLoads loads = [&](int k, const BentBranch& branch) {
    EndLoads load = drag.on(k, branch, share.now);
    weight.add_to(k, branch, load);
    return load;
  };
  const Eigen::VectorXd straight = Eigen::VectorXd::Zero(tree.size());
  std::vector<BentBranch> bent = bend(tree, straight);
  EquilibriumOptions search{.tolerance = 1e-8};
  if (heavy) search.at_rest = weight_at_rest(tree, weight, bent);
  const double size = size_of(bent);
  Equilibrium rest;
  for (int round = 0; round < most_rounds; ++round) {
    const bool calm = share.settle(drag.shares(bent, options.shelter, share.now));
    rest = find_equilibrium(tree, loads, search);
    const double went = farthest(rest.bent, bent);
    search.start = rest.strains;
    bent = rest.bent;
    if ((calm && went < settled * size) || !options.shelter.on) break;
  }
  const bool moved = !rest.strains.isZero(0);  // in calm air all is where it was, to the bit
  Lean lean{.displacement = moved ? displacement_of(tree, bent) : straight,
            .structure = {},
            .sites = moved ? bent_structure(structure, bent).find_sites() : sites,
            .loads = {},
            .strains = std::move(rest.strains),
            .wrenches = std::move(rest.wrenches)};
  lean.loads = find_loads(lean.sites, wind_of_points(wind, lean.sites.points), law, share.now);
  lean.structure = moved ? bent_structure(structure, bent, drag_of_sites(lean)) : structure;
  return lean;
}

}  // namespace

Lean find_lean(const Structure& structure, const WindAt& wind, const LoadOptions& loads,
               const LeanOptions& options) {
  const LoadLaw law = load_law(loads);
  const bool bends =
      structure.tree && options.rotations == Rotations::large && loads.model != LoadModel::paper;
  return bends ? large_lean(structure, wind, law, options) : small_lean(structure, wind, law, options);
}

}  // namespace tremula
