// What drifts as a page: snow, rain, leaves and seeds are carried by the field of the wind, and drawn by the
// browser's graphics card from the paths that the page holds. Prints where some vertices of the skin are, by
// kind, time [s] and number, which the pages can be asked for too (window.tremula.vertex). With a folder it
// writes snow.html, rain.html, leaves.html and seeds.html there.

#include <tremula/deformation/drift_pose.hpp>
#include <tremula/dynamics/drift.hpp>
#include <tremula/io/atomic_file.hpp>
#include <tremula/io/drift_page.hpp>
#include <tremula/io/html.hpp>
#include <tremula/wind/point_wind.hpp>
#include <tremula/wind/travelling_field.hpp>

#include <cstdio>
#include <memory>
#include <string>

int main(int argument_count, char** arguments) {
  using namespace tremula;

  const double heading = 35, ground = 0.3;
  const Wind wind(turbulent_wind({.speed = 5, .heading = heading}, 0.3));
  const TimeAxis loop{.period = 6, .sample_count = 180};
  bool finite = true;
  for (const DriftKind& kind : drift_kinds()) {
    Drift drift{.kind = kind, .low = {-3, -3, ground}, .high = {3, 3, 5}, .lying_time = 1};
    drift.kind.number_density = 1;
    TravellingField gusts = gust_field(wind, loop, plane_around(drift, heading, ground));
    gusts.ground = ground;
    const auto paths = std::make_shared<const DriftPaths>(carry(gusts, drift));
    const LoopFacts facts{.name = kind.name, .frames_per_second = 30, .wind_speed = 5, .heading = heading};
    const DriftLook look = look_of(kind.form);
    const Loop posed = make_loop(paths, facts, look);

    const std::size_t count = posed.rest->vertex_count();
    for (const double time : {0.0, 2.137, 5.99}) {
      const SurfaceDelta delta = posed.skin_at(time);
      for (int i = 0; i < 60; ++i) {
        const auto vertex = static_cast<std::size_t>((i + 0.5) * static_cast<double>(count) / 60);
        const Eigen::Vector3d at = (posed.rest->position[vertex] + delta.position[vertex]).cast<double>();
        std::printf("%s %.17g %zu %.9g %.9g %.9g\n", kind.name.c_str(), time, vertex, at.x(), at.y(), at.z());
        finite = finite && at.allFinite();
      }
    }
    if (argument_count > 1 && can_write_html()) {
      write_file_atomically(std::string(arguments[1]) + "/" + kind.name + ".html",
                            encode_drift_page(drift, *paths, 1, look, facts));
    }
  }
  return finite ? 0 : 1;
}
