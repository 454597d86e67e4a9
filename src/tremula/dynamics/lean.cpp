#include "tremula/dynamics/lean.hpp"

#include "tremula/base/error.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <tbb/parallel_for.h>

namespace tremula {
namespace {

std::vector<GustStatistics> wind_of_points(const WindAt& wind, const Eigen::Matrix3Xd& points) {
  std::vector<GustStatistics> result;
  for (Eigen::Index p = 0; p < points.cols(); ++p) result.push_back(wind(p, points.col(p)));
  return result;
}

// (S) What the sites leave of the wind for each other; of what is flat that is all of it, and it has all. The
// drag of leaves that fold depends on the wind that is left of `before`.
Eigen::VectorXd shares_of_wind(const std::vector<Site>& sites, const Eigen::Matrix3Xd& places,
                               const std::vector<GustStatistics>& wind, const LoadLaw& law,
                               const ShelterOptions& options, const Eigen::VectorXd& before) {
  Vec3 mean = Vec3::Zero();
  for (const GustStatistics& at_point : wind) mean += at_point.mean;
  if (!options.on || mean.norm() == 0) return Eigen::VectorXd::Ones(before.size());
  Eigen::VectorXd areas(before.size());
  for (Eigen::Index s = 0; s < areas.size(); ++s) {
    const Site& site = sites[index_of(s)];
    areas[s] =
        site.kind == SiteKind::plate ? 0 : drag_area(site, before[s] * wind[index_of(site.point)].mean, law);
  }
  Eigen::VectorXd shares = find_shelter(places, areas, mean.normalized(), options);
  for (Eigen::Index s = 0; s < areas.size(); ++s) {
    if (sites[index_of(s)].kind == SiteKind::plate) shares[s] = 1;
  }
  return shares;
}

// (S) What shelter leaves of the wind, found in rounds: less wind folds fewer leaves, which leave less of it.
// The two last rounds tell where the next would make no difference (Anderson 1965, J. ACM 12, with a memory
// of one).
struct Shares {
  Eigen::VectorXd now, last = {}, last_change = {};

  // The largest change.
  double follow(const Eigen::VectorXd& left) {
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
    return change.size() > 0 ? change.cwiseAbs().maxCoeff() : 0;
  }
};
// Of the wind. A leaf whose fold goes back and forth may keep the rounds from agreeing as closely for ever.
double settled_share(int round) { return round <= 50 ? 1e-4 : 1e-3; }

// Of a structure that hardly moves any more.
void check_round(int round, double change) {
  constexpr int most_rounds = 100;
  if (round <= most_rounds) return;
  throw Error("lean: wind and crown do not settle with each other: after " + std::to_string(most_rounds) +
              " rounds the wind at leaves and branches still changes by " + std::to_string(change) +
              " of itself; choose another wind, or no shelter");
}

// Where each site is on members that stand straight; of a plate, the middle of its element.
Eigen::Matrix3Xd places_of(const Structure& structure, const Sites& sites) {
  Eigen::Matrix3Xd places(3, static_cast<Eigen::Index>(sites.sites.size()));
  for (Eigen::Index s = 0; s < places.cols(); ++s) {
    const Site& site = sites.sites[index_of(s)];
    places.col(s) = site.kind == SiteKind::plate ? Vec3(sites.points.col(site.point))
                                                 : structure.members[index_of(site.point)].point(site.place);
  }
  return places;
}

Lean small_lean(const Structure& structure, const WindAt& wind, const LoadLaw& law,
                const LeanOptions& options) {
  Lean lean{.displacement = {}, .structure = structure, .sites = structure.find_sites(), .loads = {}};
  const std::vector<GustStatistics> at_points = wind_of_points(wind, lean.sites.points);
  const Eigen::Matrix3Xd places = places_of(structure, lean.sites);
  Shares share{Eigen::VectorXd::Ones(places.cols())};
  for (int round = 1; !structure.sheet; ++round) {  // what is flat does not shelter itself
    const double change =
        share.follow(shares_of_wind(lean.sites.sites, places, at_points, law, options.shelter, share.now));
    if (change < settled_share(round)) break;
    check_round(round, change);
  }
  lean.loads = find_loads(lean.sites, at_points, law, share.now);
  lean.displacement = structure.flexibility(mean_force(lean.sites, lean.loads));
  return lean;
}

// The drag on the branches of a tree, wherever they are.
class DragOnBranches {
 public:
  DragOnBranches(const BeamTree& tree, const Sites& sites, const WindAt& wind, const LoadLaw& law)
      : tree_(tree),
        at_rest_(sites.sites),
        wind_at_(wind),
        law_(law),
        first_(tree.parent.size() + 1, 0),
        shapes_(at_rest_.size()),
        sites_(at_rest_),
        places_(3, static_cast<Eigen::Index>(at_rest_.size())),
        wind_(tree.parent.size()) {
    for (const Site& site : at_rest_) ++first_[index_of(site.point) + 1];
    for (std::size_t k = 1; k < first_.size(); ++k) first_[k] += first_[k - 1];
    tbb::parallel_for(std::size_t{0}, at_rest_.size(), [&](std::size_t s) {
      shapes_[s] = shape_at(tree_.members[index_of(at_rest_[s].point)].beam, at_rest_[s].place);
    });
  }

  // Where the sites are on the tree as it stands, and in what wind.
  void look_at(const std::vector<BentBranch>& bent) {
    tbb::parallel_for(std::size_t{0}, bent.size(), [&](std::size_t k) {
      const BentCurve curve = curve_of(tree_.members[k], bent[k]);
      wind_[k] = wind_at_(static_cast<Eigen::Index>(k), position_on(curve, 0.5));
      for (std::size_t s = first_[k]; s < first_[k + 1]; ++s) {
        const Site& site = at_rest_[s];
        sites_[s].axis = site.kind == SiteKind::cylinder ? direction_on(curve, site.place)
                                                         : point_on(curve, site.place).frame * site.axis;
        places_.col(static_cast<Eigen::Index>(s)) = position_on(curve, site.place);
      }
    });
  }

  // On a branch of that tree.
  EndLoads on(int k, const BentBranch& branch, const Eigen::VectorXd& share) const {
    const Vec3 direction = branch.chord_frame * tree_.members[index_of(k)].direction;
    EndLoads loads;
    for (std::size_t s = first_[index_of(k)]; s < first_[index_of(k) + 1]; ++s) {
      const SiteLoad load = load_on(sites_[s], wind_[index_of(k)], share[static_cast<Eigen::Index>(s)], law_);
      add_force(shapes_[s], direction, load.mean, load.turning, loads);
    }
    return loads;
  }

  // What shelters what on that tree.
  Eigen::VectorXd shares(const ShelterOptions& options, const Eigen::VectorXd& before) const {
    return shares_of_wind(sites_, places_, wind_, law_, options, before);
  }

 private:
  const BeamTree& tree_;
  const std::vector<Site>& at_rest_;
  const WindAt& wind_at_;
  const LoadLaw& law_;
  std::vector<std::size_t> first_;  // site of every branch
  std::vector<Shape> shapes_;       // of the branches at the sites
  std::vector<Site> sites_;
  Eigen::Matrix3Xd places_;           // of them [m]
  std::vector<GustStatistics> wind_;  // of the branches
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

// What the crown leaves of the wind changes in every step of the search for how the tree stands in it.
Lean large_lean(const Structure& structure, const WindAt& wind, const LoadLaw& law,
                const LeanOptions& options) {
  constexpr double near = 1e-2, settled = 1e-5;  // of the size of the tree
  const BeamTree& tree = *structure.tree;
  const Sites sites = structure.find_sites();
  DragOnBranches drag(tree, sites, wind, law);
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
  EquilibriumOptions search{.tolerance = 1e-7};
  if (heavy) search.at_rest = weight_at_rest(tree, weight, bent);
  const double size = size_of(bent);
  bool calm = !options.shelter.on;
  int round = 0;
  search.on_shape = [&](const std::vector<BentBranch>& now) {
    drag.look_at(now);
    const double went = farthest(now, bent);
    if (!options.shelter.on || (calm && went < settled * size)) return true;
    bent = now;
    const double change = share.follow(drag.shares(options.shelter, share.now));
    calm = change < settled_share(round);
    if (!calm && went < near * size) check_round(++round, change);
    return false;
  };
  Equilibrium rest = find_equilibrium(tree, loads, search);
  bent = std::move(rest.bent);
  const bool moved = !rest.strains.isZero(0);  // in calm air all is where it was, to the bit
  Lean lean{.displacement = moved ? displacement_of(tree, bent) : straight,
            .structure = {},
            .sites = moved ? bent_sites(structure, bent) : sites,
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
