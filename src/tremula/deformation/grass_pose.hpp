// Where the wind puts all the blades of a meadow.
//
// What drives a blade are two angles (dynamics/grass_response.hpp); how it then stands is the shape of a
// heavy rod under the load that would turn its tip by as much if all were linear. Shapes are tabulated once a
// kind: the directions of its pieces over both angles, for every trajectory. A blade looks its own up and
// lays piece to piece, so that it keeps its length.
#pragma once

#include "tremula/deformation/bend_table.hpp"
#include "tremula/deformation/blade_skin.hpp"
#include "tremula/deformation/loop.hpp"
#include "tremula/dynamics/grass_response.hpp"
#include "tremula/geometry/meadow.hpp"
#include "tremula/wind/travelling_field.hpp"

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace tremula {

enum class GrassMotion {
  looked_up,  // every blade looks up the response field of its make: for millions
  in_time,    // an oscillator for every blade, integrated at its own foot (F section 5.2)
};

// A meadow and its wind, made ready to be posed at any time.
struct GrassInWind {
  Meadow meadow;
  std::vector<float> cos_azimuth, sin_azimuth, cos_facing, sin_facing;  // from x towards y
  std::vector<std::uint32_t> first_vertex;
  std::vector<std::uint32_t> vertex_count;  // of a blade, by kind
  std::uint32_t all_vertices = 0;
  std::vector<BendTable> bends;  // by kind

  // What a blade of the nominal length follows, by kind and frequency class: angles along the wind and
  // across, about the lean; (samples x columns), columns side by side.
  struct Follows {
    std::vector<std::array<float, 2>> angle;
    float lean = 0;        // [rad]
    float per_length = 0;  // 1 / nominal length [1/m]: longer blades sway more
  };
  std::vector<Follows> follows;  // (kinds x frequency classes); empty where the kind is stiff
  GrassMotion way = GrassMotion::looked_up;
  std::vector<std::vector<std::array<float, 2>>> of_blade;  // in time: (blades), samples each
  TimeAxis loop;
  double heading = 0;  // [degrees]
  double speed = 0;    // at which gusts travel [m/s]
  FieldPlane plane;

  std::size_t blade_count() const { return meadow.size(); }
};

// gusts: at the place of the meadow, heights above the ground. Throws InputError as blade_response, respond
// and check_species do, and for in_time of more blades than memory holds.
GrassInWind put_in_wind(Meadow meadow, const TravellingField& gusts,
                        GrassMotion way = GrassMotion::looked_up);

// The angles [rad] along x and y by which a blade is driven at a time [s], lean and gusts.
Eigen::Vector2d angles_of(const GrassInWind& grass, std::size_t blade, double time);

// Positions [m] and unit normals of all vertices (all_vertices); normals may be empty: then there are none.
// The same bytes on any number of threads, and at t and t + T.
void pose_grass(const GrassInWind& grass, double time, std::span<Eigen::Vector3f> positions,
                std::span<Eigen::Vector3f> normals);

// The skin as it grows, in no wind; a part for every kind of blades.
Surface grass_surface(const GrassInWind& grass);

// As few vertices as this make a loop with shapes that superpose, which morph targets and the page play; with
// more of them, writers of such files are told that there are none.
inline constexpr std::size_t most_morphed_vertices = 60'000;

Loop make_grass_loop(Meadow meadow, const TravellingField& gusts, const LoopFacts& facts,
                     GrassMotion way = GrassMotion::looked_up);

}  // namespace tremula
