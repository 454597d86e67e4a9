// Grass and what grows like it, as particles leave it (Reeves & Blau 1985; F section 5.2): a blade is the
// trajectory of a particle that leaves its foot with some speed, at an azimuth theta and a lean phi off the
// vertical, and falls. Many of them are a meadow.
#pragma once

#include "tremula/base/types.hpp"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

namespace tremula {

enum class BladeForm {
  blade,  // flat, widest below the middle, and ends in a point
  stem,   // narrow, and as wide at its tip
  ear,    // round and closed
};

// Blades of one make: they differ in size, azimuth, lean and droop, drawn between bounds.
struct BladeKind {
  BladeForm form = BladeForm::blade;
  std::string material = "blade";              // of its part of the surface (SurfaceMaterial::name)
  Eigen::Vector3f color{0.29F, 0.44F, 0.16F};  // sRGB, 0–1
  double length = 1;                           // on the average, in heights of the species
  double length_spread = 0.25;                 // either way, relative
  double width = 0.004;                        // at its widest [m]
  Eigen::Vector2d lean{0, 0.4};                // phi at the foot, from and to [rad]
  Eigen::Vector2d droop{0, 1};                 // g L / v0^2, from and to: 0 straight
  int pieces = 3;                              // straight ones that it is drawn with, 3 or 4
  double each = 1;                             // of them on a plant, on the average
  Eigen::Vector2d attached{0, 0};  // where on the stem before it, 0 foot … 1 tip; 0, 0: on the ground

  // How it moves (dynamics/grass_response.hpp). A frequency of 0: stiff, carried by its stem.
  double frequency = 0;  // first, upright, of one as long as they are on the average [Hz]
  double damping_ratio = 0.08;
  double mass = 1e-3;             // of a metre [kg/m]
  double tip_mass = 0;            // of what it carries at the tip [kg]
  double drag_area = 0;           // of what it carries at the tip, drag coefficient times area [m^2]
  double drag_coefficient = 0.6;  // on width times length; of flat ones that look to all sides
};

// Where its pieces meet, from 0 at the foot to 1 at the tip: (pieces + 1), multiples of 1/20.
std::vector<double> joints_of(const BladeKind& kind);

// How many different trajectories blades of one kind have.
inline constexpr int trajectories_per_kind = 12;

struct GrassSpecies {
  std::string name;
  double height = 0.3;      // of an average plant [m]
  double density = 1000;    // of plants [1/m^2]
  double canopy_decay = 2;  // a: below its tips the wind is U(h) exp(-a (1 - z/h))
  // What the meadow itself leaves of the mean wind and of its gusts at its tips, beside open ground.
  double mean_share = 0.4, gust_share = 0.7;
  double tufts = 0.3;            // by what share height waxes and wanes over half a metre
  std::vector<BladeKind> kinds;  // the first stands on the ground
};

// lawn, meadow, wheat, rice, reed. The theory chapter says where the numbers come from.
const std::vector<GrassSpecies>& grass_species();
const GrassSpecies& grass_species_named(std::string_view name);  // throws InputError for other names

// Throws InputError for numbers that are not finite or out of range, and for a species without kinds.
void check_species(const GrassSpecies& species);

// Directions (unit, z up, the azimuth along x) of the pieces (equally long) of a trajectory.
Eigen::Matrix3Xd trajectory(const BladeKind& kind, int number, int pieces);

// Struct of arrays: blades of one plant side by side, its stem first. Float: this is for pictures.
struct Meadow {
  GrassSpecies species;
  double height = 0.3;               // of an average plant [m]
  std::vector<float> x, y, z;        // feet [m]; of what is on a stem, those of the stem
  std::vector<float> length, width;  // [m]
  std::vector<float> azimuth;        // theta, from x towards y [rad]
  std::vector<float> facing;         // where the flat side looks, from x towards y [rad]
  std::vector<float> attached;       // where on the last stem before it; below 0: on the ground
  std::vector<std::uint8_t> kind, trajectory;
  std::vector<std::uint8_t> frequency_class;  // 0 the shortest of its kind … 2 the longest

  std::size_t size() const { return x.size(); }
};
inline constexpr int frequency_classes = 3;

// Fewer and wider blades far from the eyes: as many per area at a distance d from the nearest as
// `full_until`/d of what is said.
struct Thinning {
  std::vector<Eigen::Vector2d> eyes;
  double full_until = 10;  // [m]
  double widest = 4;       // at most so many times wider
};

struct SowOptions {
  Eigen::Vector2d low{-1, -1}, high{1, 1};  // along x and y [m]
  // Share of the density, and of the height, at a place, 0–1; empty: 1.
  std::function<double(const Eigen::Vector2d&)> density_at = {}, height_at = {};
  std::optional<double> density = {}, height = {};  // in place of those of the species
  double ground = 0;                                // height of the feet [m]
  std::optional<Thinning> thinning = {};
  std::uint64_t seed = 1;
};

// Every plant has a place by the address of its square of ground, so what grows does not depend on how large
// the field is. Throws InputError for a field that ends before it begins or in which nothing grows, for more
// blades than memory holds, and as check_species does.
Meadow sow(const GrassSpecies& species, const SowOptions& options);

}  // namespace tremula
