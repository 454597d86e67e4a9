// How a structure stands in the mean wind.
//
// A tree is bent as far as weight and wind bend it: the drag is that on the shape it has there, in the wind
// of the places where its branches then are, less what the crown upwind has taken (shelter.hpp). That
// branches turn out of the wind is not put in; it comes out. The loads that are left for the gusts are those
// on that shape, and what vibrates is the tree about it.
#pragma once

#include "tremula/dynamics/loads.hpp"
#include "tremula/dynamics/shelter.hpp"
#include "tremula/structure/equilibrium.hpp"
#include "tremula/structure/structure.hpp"
#include "tremula/wind/gust_statistics.hpp"

#include <functional>

#include <Eigen/Core>

namespace tremula {

enum class Rotations {
  large,  // of trees; frames have small ones
  small,  // displacements superpose, and loads are those on the structure at rest (S sections 2 and 3)
};

struct LeanOptions {
  Rotations rotations = Rotations::large;
  ShelterOptions shelter = {};
};

// The wind that a point of the sites feels where it then is: (index of the point, place [m]). Called by
// several threads.
using WindAt = std::function<GustStatistics(Eigen::Index point, const Vec3& place)>;

struct Lean {
  Eigen::VectorXd displacement;  // from rest (rows) [m, rad]
  Structure structure;           // as it stands, for what is small about it
  Sites sites;                   // of that
  Loads loads;
  // Of a tree with large rotations; empty otherwise.
  Eigen::VectorXd strains = {};
  Wrenches wrenches = {};
};

// Throws as load_law, find_shelter and find_equilibrium do, and Error where shelter and shape do not settle.
Lean find_lean(const Structure& structure, const WindAt& wind, const LoadOptions& loads,
               const LeanOptions& options = {});

}  // namespace tremula
