// How a lean becomes a motion: the ways that pipeline.cpp chooses from, each of the stages of dynamics in
// turn. Not for users, who call set_in_motion.
#pragma once

#include "tremula/pipeline.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace tremula {

inline void tell(const Progress& progress, std::string_view stage, double done = 0) {
  if (progress) progress(stage, done);
}

inline Eigen::Matrix3Xd above(double ground, Eigen::Matrix3Xd points) {
  points.row(2).array() -= ground;
  return points;
}

// As many modes as were baked, of the structure as it stands; the baked ones where it stands as at rest.
Modes modes_about(const Lean& lean, Modes baked);

// By modes and static shapes of the structure as it leans.
Motion by_modes(const Lean& lean, Modes modes, const Weather& weather, const PointWind& wind,
                const Progress& progress);

// By modes and the shape that the pull adds to them, of the structure as it leans.
Motion after_release(const Lean& lean, Modes modes, const Weather& weather);

// By modes and static shapes about the lean in the mean wind, or about rest, through every instant.
Motion through_gusts(const Lean& lean, Modes modes, const Weather& weather, const PointWind& wind,
                     const Progress& progress);

// By the branches, each for itself (F), told as a few shapes.
Motion by_oscillators(const Lean& lean, const Weather& weather, const PointWind& wind,
                      const Progress& progress, std::vector<std::string>* warnings);

// A flag by the angles of its threads, told as a few shapes; its lean is the mean of them.
Motion by_flapping(const Structure& structure, const Weather& weather, double ground,
                   const Progress& progress, std::vector<std::string>* warnings);

}  // namespace tremula
