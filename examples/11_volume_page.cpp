// A volume of plants as a page: rice, moss and fur as strands that the browser's graphics card bends with the
// response of their tops to the field of the wind. Prints where some points of strands are, by species, time
// [s] and number, which the pages can be asked for too (window.tremula.vertex). With a folder it writes
// rice.html, moss.html and fur.html there.

#include <tremula/deformation/bent_space.hpp>
#include <tremula/dynamics/canopy_sway.hpp>
#include <tremula/geometry/strands.hpp>
#include <tremula/io/atomic_file.hpp>
#include <tremula/io/html.hpp>
#include <tremula/io/volume_page.hpp>
#include <tremula/wind/point_wind.hpp>
#include <tremula/wind/travelling_field.hpp>

#include <cstdio>
#include <string>
#include <vector>

int main(int argument_count, char** arguments) {
  using namespace tremula;

  const double heading = 35, tall = 0.8;
  const Wind wind(turbulent_wind({.speed = 8, .heading = heading}, 0.3));
  const TimeAxis loop{.period = 6, .sample_count = 180};
  bool finite = true;
  for (const char* species : {"rice", "moss", "fur"}) {
    StrandField field;
    for (int variant = 0; variant < 2; ++variant)
      field.patches.push_back(grow_strands(volume_plant_of(species), {.variant = variant}));
    const StrandPatch& first = field.patches.front();
    field.height = static_cast<double>(first.height);
    field.high = 1.5 * first.size.cast<double>();
    field.low = -field.high / 3;
    field.tallness = [tall](const Eigen::Vector2d&) { return tall; };
    const std::vector<Vec3> corners{{field.low.x(), field.low.y(), 0}, {field.high.x(), field.high.y(), 0}};
    TravellingField gusts = gust_field(wind, loop, plane_across(corners, heading, 0.3, {1.0}));
    gusts.ground = 0.3;
    field.sway = canopy_sway(gusts, {.frequency = 1.5, .give = 4e-3 * field.height});

    // In the order of the page: of the squares of the first variant, then of those of the second.
    struct Point {
      Eigen::Vector2d corner, foot;
      Vec3 resting;
      double held;
    };
    std::vector<Point> points;
    const double share = share_of_page(field);
    for (std::size_t variant = 0; variant < field.patches.size(); ++variant) {
      const StrandPatch& patch = field.patches[variant];
      for (const PatchSquare& square : squares_of(field)) {
        if (square.variant != variant) continue;
        for (const std::size_t number : strands_left(field, variant, share)) {
          const Strand& strand = patch.strands[number];
          for (const Eigen::Vector3f& point : strand.points) {
            points.push_back({square.corner.cast<double>(), patch.feet[strand.plant].cast<double>(),
                              point.cast<double>(), static_cast<double>(strand.held)});
          }
        }
      }
    }
    for (const double time : {0.0, 2.137, 5.99}) {
      for (int i = 0; i < 60; ++i) {
        const auto number = static_cast<std::size_t>((i + 0.5) * static_cast<double>(points.size()) / 60);
        const Point& point = points[number];
        const Eigen::Vector2d foot = point.corner + point.foot;
        const bool stands =
            (foot.array() >= field.low.array()).all() && (foot.array() <= field.high.array()).all();
        const Bend bend = bend_of(field.sway(foot, time), field.height);
        Vec3 at = bent_point(bend, point.resting, point.foot, point.held, field.height, tall);
        if (!stands) at << point.foot, 0;
        at += Vec3(point.corner.x(), point.corner.y(), gusts.ground);
        std::printf("%s %.17g %zu %.9g %.9g %.9g\n", species, time, number, at.x(), at.y(), at.z());
        finite = finite && at.allFinite();
      }
    }
    if (argument_count > 1 && can_write_html()) {
      const LoopFacts facts{.name = species, .frames_per_second = 30, .wind_speed = 8, .heading = heading};
      write_file_atomically(std::string(arguments[1]) + "/" + species + ".html",
                            encode_volume_page(field, facts));
    }
  }
  return finite ? 0 : 1;
}
