// The wind in a scene, to be seen: arrows that stand in it and turn, lengthen and shorten with it, and a tint
// of the ground below (F figure 3).
#pragma once

#include "tremula/deformation/loop.hpp"
#include "tremula/wind/travelling_field.hpp"

#include <cstddef>
#include <functional>
#include <memory>

#include <Eigen/Core>

namespace tremula {

// Arrows over a field from `low` to `high` [m], their middles on a lattice that is centred in it.
struct ArrowLattice {
  Eigen::Vector2d low{-20, -20}, high{20, 20};
  double z = 1.5;      // [m]
  double spacing = 2;  // from arrow to arrow [m]
  double scale = 0.2;  // length of an arrow for 1 m/s [s]
};
inline constexpr double most_gust_arrows = 40'000;
std::size_t arrow_count(const ArrowLattice& lattice);

// One loop of all arrows, in the field at their places; thickness follows the spacing. Throws InputError for
// a lattice that is none and for more than most_gust_arrows.
Loop gust_arrows(std::shared_ptr<const TravellingField> field, const ArrowLattice& lattice);

// At a place and a time [s]: a linear colour and how much of the ground it covers, 0–1; none of it outside
// `low` to `high`. The more the faster, in the colours of io/gust_plot.hpp, from the slowest to the
// fastest of the field.
std::function<Eigen::Vector4f(const Eigen::Vector2f& place, double time)> gust_tint(
    std::shared_ptr<const TravellingField> field, const ArrowLattice& lattice);

}  // namespace tremula
