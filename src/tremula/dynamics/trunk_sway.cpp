#include "tremula/dynamics/trunk_sway.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/error.hpp"
#include "tremula/dynamics/lean.hpp"
#include "tremula/modes/solve_modes.hpp"
#include "tremula/wind/profile.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tremula {
namespace {

constexpr int mode_count = 2;  // the first, both ways

WindAt wind_at(const Wind& wind, const TimeAxis& loop, const Structure& structure) {
  if (wind.statistics) return [&wind](Eigen::Index, const Vec3& place) { return wind.statistics(place); };
  const PointWind at_rest = wind_at_points(wind, loop, structure.find_sites().points);
  return [statistics = statistics_of(at_rest, loop)](Eigen::Index point, const Vec3&) {
    return statistics[index_of(point)];
  };
}

// What both modes give together in one direction, as one oscillator.
struct Direction {
  Vec3 axis;
  Eigen::VectorXd share;  // (modes) of the top's static displacement, together 1
  double response = 0;    // that displacement [m s/m]
};

Direction direction_of(const Vec3& axis, const Eigen::MatrixX3d& top, const Eigen::MatrixXd& participation,
                       const Eigen::VectorXd& stiffness) {
  const Eigen::VectorXd even = axis.replicate(participation.rows() / 3, 1);
  const Eigen::VectorXd moved = (participation.transpose() * even).cwiseQuotient(stiffness);
  Direction direction{axis, moved.cwiseProduct(top * axis)};
  direction.response = direction.share.sum();
  direction.share /= direction.response;
  return direction;
}

}  // namespace

TrunkSway trunk_sway(const Structure& structure, const Wind& wind, const TimeAxis& loop,
                     const SwayOptions& options) {
  const bool on_foot = !structure.nodes.empty() && structure.nodes.front().row < 0 &&
                       structure.nodes.front().position.isZero() && structure.nodes.back().row >= 0;
  if (!on_foot || !structure.tree)
    throw InputError("trunk", "a structure without a foot", "one at the origin");
  if (!(options.crown_radius >= 0) || !std::isfinite(options.crown_radius))
    throw InputError("radius of the crown", number_text(options.crown_radius) + " m", "0 or more");
  const Lean lean =
      find_lean(structure, wind_at(wind, loop, structure), options.loads, {.shelter = {.on = false}});
  const Modes modes = solve_modes(lean.structure, {.count = mode_count});
  const Eigen::VectorXd omega = modes.omega();
  const Eigen::MatrixXd participation = modal_participation(lean.sites, lean.loads, modes.shapes);
  Eigen::MatrixXd damping = structural_damping(options.damping, omega).asDiagonal();
  if (options.damping.aerodynamic) damping += aerodynamic_damping(lean.sites, lean.loads, modes.shapes);
  const Eigen::MatrixXd turning = aerodynamic_stiffness(lean.sites, lean.loads, modes.shapes);
  const Eigen::VectorXd stiffness = omega.cwiseAbs2() + turning.diagonal();
  if (!(stiffness.minCoeff() > 0)) throw Error("trunk: the wind turns it over");

  const auto moved_at = [&](const Node& node) -> Eigen::MatrixX3d {
    if (node.row < 0) return Eigen::MatrixX3d::Zero(mode_count, 3);
    return modes.shapes.middleRows<3>(node.row).transpose();
  };
  const Eigen::MatrixX3d top = moved_at(structure.nodes.back());
  const Vec3 along = heading_direction(wind.reference.heading), across(-along.y(), along.x(), 0);
  const std::array<Direction, 2> directions{direction_of(along, top, participation, stiffness),
                                            direction_of(across, top, participation, stiffness)};
  TrunkSway sway;
  for (std::size_t i = 0; i < 2; ++i) {
    const Direction& of = directions[i];
    const double squared = of.share.dot(stiffness), rate = of.share.dot(damping.diagonal());
    if (!(squared > 0) || !(rate > 0) || !std::isfinite(of.response))
      throw InputError("trunk", "no mode that gusts drive", "a structure that the wind takes hold of");
    sway.frequency[i] = std::sqrt(squared) / (2 * std::numbers::pi);
    sway.damping_ratio[i] = rate / (2 * std::sqrt(squared));
    sway.static_response[i] = of.response;
  }
  for (const Node& node : structure.nodes) {
    sway.heights.push_back(node.position.z());
    const Vec3 stands = node.row < 0 ? Vec3(Vec3::Zero()) : Vec3(lean.displacement.segment<3>(node.row));
    sway.lean.emplace_back(stands.dot(along), stands.dot(across));
    Eigen::Vector2d share;
    for (int i = 0; i < 2; ++i) {
      const Direction& of = directions[index_of(i)];
      const Eigen::VectorXd weight = of.share.cwiseQuotient(top * of.axis);
      share[i] = weight.dot(moved_at(node) * of.axis);
    }
    sway.share.push_back(share);
  }
  if (std::ranges::adjacent_find(sway.heights, std::greater_equal{}) != sway.heights.end())
    throw InputError("trunk", "nodes that do not rise", "a trunk that stands upright");
  double weights = 0;
  for (Eigen::Index p = 0; p < lean.sites.points.cols(); ++p) {
    const Eigen::VectorXd drives = participation.middleRows<3>(3 * p).transpose() * along;
    const double weight = std::abs(drives.dot(directions[0].share.cwiseQuotient(top * along)));
    sway.gust_height += weight * lean.sites.points(2, p);
    weights += weight;
  }
  sway.gust_height /= weights;
  sway.response.along =
      oscillator_impedance(sway.frequency[0], sway.damping_ratio[0], sway.static_response[0]);
  sway.response.across =
      oscillator_impedance(sway.frequency[1], sway.damping_ratio[1], sway.static_response[1]);
  // A Gaussian has the variance of an even disc: s^2/2 = R^2/4 along each axis.
  if (options.crown_radius > 0)
    sway.response.spatial = {SpatialResponse::Kind::gaussian, options.crown_radius / std::numbers::sqrt2};
  return sway;
}

Structure tuned_structure(const Skeleton& skeleton, StructureOptions options, double frequency) {
  check_positive("frequency of the trunk", frequency, " Hz");
  const Material material = options.material;
  const auto first_mode = [&] { return solve_modes(assemble(skeleton, options), {.count = 1}).frequency[0]; };
  const auto stiffen = [&](double factor) {
    options.material.youngs_modulus = factor * material.youngs_modulus;
    options.material.shear_modulus = factor * material.shear_modulus;
  };
  // f^2 = a E - b, b from the weight that makes it softer: it is a line but for the shape, which weight
  // changes a little.
  const double gravity = options.gravity, wanted = frequency * frequency;
  options.gravity = 0;
  const double slope = std::pow(first_mode(), 2);
  options.gravity = gravity;
  double factor = std::max(wanted, 1e-12) / slope * 1.5;
  for (int i = 0; i < 6; ++i) {
    stiffen(factor);
    const double found = std::pow(first_mode(), 2);
    if (std::abs(found - wanted) < 1e-6 * wanted) break;
    factor += (wanted - found) / slope;
  }
  stiffen(factor);
  return assemble(skeleton, options);
}

}  // namespace tremula
