// Painted trees as a page: the trunk of one sways as an oscillator in the field of the wind, and so does
// every copy, at its own place; the browser's graphics card shifts crowns and leaves by it. Prints where some
// vertices are, by shape, time [s] and number, which the pages can be asked for too (window.tremula.vertex).
// With a folder it writes oak.html and pine.html there.

#include <tremula/deformation/impression_motion.hpp>
#include <tremula/dynamics/trunk_sway.hpp>
#include <tremula/geometry/impression.hpp>
#include <tremula/io/atomic_file.hpp>
#include <tremula/io/html.hpp>
#include <tremula/io/impression_page.hpp>
#include <tremula/structure/structure.hpp>
#include <tremula/wind/point_wind.hpp>
#include <tremula/wind/travelling_field.hpp>

#include <cstdio>
#include <string>
#include <vector>

int main(int argument_count, char** arguments) {
  using namespace tremula;

  const double heading = 35, speed = 16;
  const Wind wind(turbulent_wind({.speed = speed, .heading = heading}, 0.3));
  const TimeAxis loop{.period = 6, .sample_count = 180};
  const std::vector<Instance> instances = {{.position = {0, 0, 0}, .turn = 0.4},
                                           {.position = {14, 3, 0.5}, .turn = 2, .scale = 0.8},
                                           {.position = {-4, 15, 0}, .turn = 4, .time_shift = 1.3}};
  std::vector<Vec3> places;
  for (const Instance& at : instances) places.push_back(at.position);
  bool finite = true;
  for (const char* shape : {"oak", "pine"}) {
    const ImpressionistTree tree = impressionist_tree(shape, 12);
    const Structure trunk = assemble(trunk_skeleton(tree), {.material = find_material(tree.material)});
    const TrunkSway sway = trunk_sway(trunk, wind, loop, {.crown_radius = tree.width / 2});
    const TravellingField gusts =
        gust_field(wind, loop, plane_across(places, heading, 3, {sway.gust_height}));
    const ImpressionMotion motion = impression_motion(sway, gusts);

    const ImpressionMesh mesh = mesh_for_page(tree, instances.size());
    const TrunkCurve curve = trunk_curve(motion);
    const std::size_t all = mesh.positions.size() * instances.size();
    for (const double time : {0.0, 2.137, 5.99}) {
      for (int i = 0; i < 60; ++i) {
        const auto vertex = static_cast<std::size_t>((i + 0.5) * static_cast<double>(all) / 60);
        const Vec3 resting = mesh.positions[vertex % mesh.positions.size()].cast<double>();
        const Vec3 at =
            place_in_wind(motion, curve, instances[vertex / mesh.positions.size()], resting, time);
        std::printf("%s %.17g %zu %.9g %.9g %.9g\n", shape, time, vertex, at.x(), at.y(), at.z());
        finite = finite && at.allFinite();
      }
    }
    if (argument_count > 1 && can_write_html()) {
      const LoopFacts facts{
          .name = shape, .frames_per_second = 30, .wind_speed = speed, .heading = heading, .seed = tree.seed};
      write_file_atomically(std::string(arguments[1]) + "/" + shape + ".html",
                            encode_impressions_page(tree, instances, motion, facts));
    }
  }
  return finite ? 0 : 1;
}
