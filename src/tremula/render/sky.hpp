// The light that does not come straight from the sun: how much of the sky and of the ground a point inside,
// beside or below a plant sees. The plant is taken as a fog as dense as its leaves and twigs (Beer's law with
// a projection of one half, as for leaves that face all ways), on a coarse grid.
#pragma once

#include "tremula/geometry/surface.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace tremula {

using Rgb = Eigen::Vector3f;  // linear, not limited to 1

struct FogGrid {
  Eigen::Vector3f low = Eigen::Vector3f::Zero();  // corner of the first cell [m]
  float cell = 1;                                 // edge of a cell [m]
  Eigen::Vector3i size = Eigen::Vector3i::Ones();
  std::vector<float> extinction;  // (size product, x fastest) [1/m]

  std::size_t index(const Eigen::Vector3i& c) const {
    return (static_cast<std::size_t>(c.z()) * static_cast<std::size_t>(size.y()) +
            static_cast<std::size_t>(c.y())) *
               static_cast<std::size_t>(size.x()) +
           static_cast<std::size_t>(c.x());
  }
  // Share of light from far away in `direction` (unit) that arrives at `point`.
  float transmittance(const Eigen::Vector3f& point, const Eigen::Vector3f& direction) const;
};

// An empty one. `low` and `high` hold all that will be put in; `cells` along the longest edge.
FogGrid make_fog(const Eigen::Vector3f& low, const Eigen::Vector3f& high, int cells);

// Puts the triangles of a part in.
void add_fog(FogGrid& grid, std::span<const Eigen::Vector3f> positions, const SurfacePart& part);

// What comes from where when nothing is in the way.
struct Surroundings {
  Rgb zenith, horizon;  // radiance of the sky
  Rgb ground;           // radiance of the ground
  Rgb foliage;          // radiance of the plant itself, where it hides the rest

  Rgb radiance(const Eigen::Vector3f& direction) const;
};

// Irradiance by place and normal, first order spherical harmonics per cell of the fog.
class AmbientLight {
 public:
  AmbientLight(const FogGrid& fog, const Surroundings& surroundings);
  Rgb irradiance(const Eigen::Vector3f& point, const Eigen::Vector3f& normal) const;

 private:
  struct Harmonics {
    Rgb mean = Rgb::Zero();
    std::array<Rgb, 3> slope = {Rgb::Zero(), Rgb::Zero(), Rgb::Zero()};
  };
  FogGrid fog_;
  std::vector<Harmonics> cells_;
};

// Share of the sky that the ground sees, on a square around `centre`.
class GroundLight {
 public:
  GroundLight(const FogGrid& fog, const Eigen::Vector2f& centre, float ground_level, float half_width);
  float sky_share(float x, float y) const;

 private:
  static constexpr int cells = 64;
  Eigen::Vector2f centre_;
  float half_width_;
  std::vector<float> share_;
};

}  // namespace tremula
