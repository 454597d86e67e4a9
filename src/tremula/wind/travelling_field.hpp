// A field that the mean wind carries along as it is: what it is at x along the wind and time t, it was on the
// plane x = 0 at t - x/U (Taylor's hypothesis; F eq. 3, section 5.3 and errata F12). So a plane across the
// wind over one loop tells it everywhere and always. Gusts are one; what follows them at every place in the
// same way (dynamics/response_field.hpp) is another.
#pragma once

#include "tremula/base/types.hpp"
#include "tremula/numerics/time_axis.hpp"
#include "tremula/wind/point_wind.hpp"

#include <array>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace tremula {

// Where a field is known: columns across the wind, to the left of its heading, from layer to layer.
struct FieldPlane {
  int columns = 1;
  double first_column = 0, spacing = 1;  // [m] across
  std::vector<double> heights = {1};     // of the layers above the ground, rising [m]
};

// The columns that cover all points (x, y) [m] in a wind with that heading [degrees], `spacing` [m] apart or
// a little less.
FieldPlane plane_across(std::span<const Vec3> points, double heading, double spacing,
                        std::vector<double> heights);

struct TravellingField {
  TimeAxis loop;
  double heading = 0;  // where it travels to, from x towards y [degrees]
  double speed = 0;    // U [m/s]; 0: it stays where it is, the same along the heading
  FieldPlane plane;
  double ground = 0;       // height of the ground, from which layers count [m]
  std::vector<Vec3> mean;  // of the layers, world axes
  // What is about the mean, along, across and up (the fourth is 0): (layers x samples x columns), columns
  // side by side.
  std::vector<std::array<float, 4>> values;

  std::size_t index(int layer, int sample, int column) const {
    return (static_cast<std::size_t>(layer) * static_cast<std::size_t>(loop.sample_count) +
            static_cast<std::size_t>(sample)) *
               static_cast<std::size_t>(plane.columns) +
           static_cast<std::size_t>(column);
  }
};

// What is about the mean at a place [m] and a time [s]: along, across, up. Linear between samples, columns
// and layers; beyond the columns and layers the last count. The same bits at t and t + T.
Eigen::Vector3f local_value_at(const TravellingField& field, const Vec3& place, double time);
// In world axes, and with the mean.
Vec3 value_at(const TravellingField& field, const Vec3& place, double time);
// The mean alone, at a height z of the world [m].
Vec3 mean_at(const TravellingField& field, double z);

// The gusts of a wind [m/s] on a plane: bin 0, what is slower than the loop, is in them as structures feel
// it. Throws InputError for a plane that is none (no columns, heights that do not rise, numbers that are not
// finite), one of more than most_field_values, and as wind_at_points does.
TravellingField gust_field(const Wind& wind, const TimeAxis& loop, const FieldPlane& plane);

inline constexpr double most_field_values = 2.5e8;  // 4 GB

// Throws InputError for a plane that is none, a loop without period or samples, and more values than that.
void check_plane(const FieldPlane& plane, const TimeAxis& loop);

}  // namespace tremula
