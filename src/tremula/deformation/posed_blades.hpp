// Blades of a meadow at one time, many side by side: what pose_grass does for each share of its work.
#pragma once

#include "tremula/deformation/grass_pose.hpp"

#include <array>
#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace tremula {

// The field of the gusts at one time: sample and column from x and y.
struct FieldNow {
  float cosine = 1, sine = 0;            // of the heading
  float now = 0, samples_per_metre = 0;  // sample at x = 0 [samples], and how much earlier downwind [1/m]
  int sample_count = 1, columns = 1;
  float first_column = 0, columns_per_metre = 1;  // across the wind [m], [1/m]
};

struct PoseOfGrass {
  const GrassInWind& grass;
  FieldNow field;
  struct KindSkin {
    BladeSkin skin;
    bool flat;                    // no vertex is off the flat side
    std::array<float, 4> shares;  // lengths of pieces, of the blade's
    int pieces;
  };
  std::vector<KindSkin> skins;  // (kinds)
  bool still = false;           // as it grows, in no wind
};
// `time` in seconds; `grass` has to outlive it.
PoseOfGrass pose_of(const GrassInWind& grass, double time, bool still);

// The angles [rad] along x and y by which a blade that is not stiff is driven, lean and gusts.
Eigen::Vector2f driven_angles(const PoseOfGrass& pose, std::size_t blade);

// Positions [m] and, unless they are null, unit normals of all vertices of the blades first … end: of whole
// plants. The same bytes however they are shared out.
void pose_plants(const PoseOfGrass& pose, std::size_t first, std::size_t end, Eigen::Vector3f* positions,
                 Eigen::Vector3f* normals);

}  // namespace tremula
