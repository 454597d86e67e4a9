// Where the wind takes hold of a structure.
#pragma once

#include "tremula/base/types.hpp"
#include "tremula/structure/member.hpp"

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace tremula {

enum class SiteKind {
  cylinder,  // wood: the wind across its axis counts
  blade,     // a leaf, which folds and turns in the wind; it may have lift along its normal
  ribbon,    // a piece of a long blade that stays flat: the flow through its plane, and friction along it
  plate,     // a piece of a sheet: the wind through its plane counts
};

struct Site {
  int point = 0;  // of Sites::points: whose wind it feels
  SiteKind kind = SiteKind::cylinder;
  Vec3 axis = Vec3::UnitZ();  // along the cylinder, or out of the blade or plate; unit vector
  double area = 0;            // diameter times length, or one side of the blade or plate [m^2]
  double place = 0;           // along its member, 0 start … 1 end
  double mean_area = 0;       // the same with the mean diameter of the cylinder, as S eq. 3 has one a branch
  double volume = 0;          // that it takes in the fluid [m^3]
  double carried = 0;         // of the fluid that moves with it across its axis, or across its blade [m^3]
};

// One wind a point, as S eq. 4 has one a branch, and several sites that feel it.
struct Sites {
  Eigen::Matrix3Xd points;  // (3 x P) [m]
  std::vector<Site> sites;  // (S) in the order of their points
  // The translations of sites first … last - 1 when the structure moves by each column: (3 (last - first) x
  // c) [m]. Called by several threads.
  std::function<Eigen::MatrixXd(std::size_t first, std::size_t last,
                                Eigen::Ref<const Eigen::MatrixXd> displacements)>
      motion;
  // Likewise the rotations of their cross sections [rad].
  std::function<Eigen::MatrixXd(std::size_t first, std::size_t last,
                                Eigen::Ref<const Eigen::MatrixXd> displacements)>
      turning;
  // The transpose of motion: the forces on the structure's rows of forces (3 x S) [N] on all sites.
  std::function<Eigen::VectorXd(const Eigen::Matrix3Xd& forces)> gather;
  Eigen::Index point_count() const { return points.cols(); }
};

// Those of two parts of one structure, with their points one after the other.
Sites join(Sites first, Sites second);

// Sites first … last - 1.
struct SiteBlock {
  std::size_t first, last;
};

// All sites in blocks of a few thousand, none of which parts the sites of one point.
std::vector<SiteBlock> cut_between_points(const Sites& sites);

// A leaf, as a site of its member.
struct BladeSite {
  int member = 0;
  double place = 1;  // along the member, 0 start … 1 end
  Vec3 normal = Vec3::UnitZ();
  double area = 0;         // one side [m^2]
  double mass = 0;         // [kg]
  double carried = 0;      // of the fluid that moves with it along its normal [m^3]
  bool is_ribbon = false;  // as Leaf::is_ribbon
};

// A blade is as heavy as the water that it displaces: nobody measures the volume of leaves.
inline constexpr double blade_density = 1000;  // [kg/m^3]

// Of beams with one point each, in the middle: four sites a member, at the Gauss points of the integrals over
// its length, and one a blade, where its member carries it. `owner` keeps the members. row_count: of the
// structure.
Sites find_sites(std::span<const Member> members, std::shared_ptr<const void> owner,
                 std::span<const BladeSite> blades, Eigen::Index row_count);

}  // namespace tremula
