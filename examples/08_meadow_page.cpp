// A meadow in the wind as a page: blades are sown, follow the gusts that the field of the wind holds, and are
// drawn by the browser's graphics card from what the page says of each. Prints where some vertices of the
// skin are, by time [s] and number, which the page can be asked for too (window.tremula.vertex). With a
// folder it writes meadow.html there.

#include <tremula/deformation/grass_pose.hpp>
#include <tremula/geometry/meadow.hpp>
#include <tremula/io/atomic_file.hpp>
#include <tremula/io/grass_page.hpp>
#include <tremula/io/html.hpp>
#include <tremula/wind/point_wind.hpp>
#include <tremula/wind/travelling_field.hpp>

#include <cmath>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

int main(int argument_count, char** arguments) {
  using namespace tremula;

  // Stems with ears and leaves on them: all that a page has to put together.
  const double half = 0.7, heading = 35, ground = 0.2;
  Meadow meadow =
      sow(grass_species_named("wheat"), {.low = {-half, -half}, .high = {half, half}, .ground = ground});
  const Wind wind(turbulent_wind({.speed = 8, .heading = heading}, 0.3));
  const std::vector<Vec3> corners = {{-half, -half, 0}, {half, -half, 0}, {-half, half, 0}, {half, half, 0}};
  const TimeAxis loop{.period = 10, .sample_count = 300};
  const TravellingField gusts = gust_field(wind, loop, plane_across(corners, heading, 0.25, {meadow.height}));
  const GrassInWind grass = put_in_wind(std::move(meadow), gusts);

  std::vector<Eigen::Vector3f> positions(grass.all_vertices);
  bool finite = true;
  for (const double time : {0.0, 3.137, 8.99}) {
    pose_grass(grass, time, positions, {});
    for (std::uint32_t i = 0; i < 60; ++i) {
      const std::uint32_t vertex = static_cast<std::uint32_t>((i + 0.5) * grass.all_vertices / 60);
      const Eigen::Vector3d at = positions[vertex].cast<double>();
      std::printf("%.17g %u %.9g %.9g %.9g\n", time, vertex, at.x(), at.y(), at.z());
      finite = finite && at.allFinite();
    }
  }

  if (argument_count > 1 && can_write_html()) {
    const LoopFacts facts{.name = "meadow", .frames_per_second = 30, .wind_speed = 8, .heading = heading};
    write_file_atomically(std::string(arguments[1]) + "/meadow.html", encode_grass_page(grass, facts));
  }
  return finite ? 0 : 1;
}
