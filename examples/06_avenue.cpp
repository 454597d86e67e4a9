// One tree in many places: a loop is made once, and every instance says where it stands, how it is turned,
// and how far it is ahead in time, so that no two sway alike. On bones: every instance has a skin of its own.
// With a folder it writes avenue.glb and avenue.html there.

#include <tremula/deformation/fit_rig.hpp>
#include <tremula/deformation/loop.hpp>
#include <tremula/geometry/grow.hpp>
#include <tremula/geometry/plants.hpp>
#include <tremula/geometry/surface.hpp>
#include <tremula/io/atomic_file.hpp>
#include <tremula/io/html.hpp>
#include <tremula/io/loop_writers.hpp>
#include <tremula/pipeline.hpp>

#include <cmath>
#include <cstdio>
#include <memory>
#include <string>

int main(int argument_count, char** arguments) {
  using namespace tremula;

  const GrownPlant plant = grow(parse_lsystem(find_preset("sapling").text, "sapling"));
  const Subject subject = bake(plant.skeleton, {.modes = {.count = 12}});
  Weather weather;
  weather.loop = {.period = 12, .sample_count = 240};
  const Surface surface = mesh_surface(plant.skeleton);
  const Motion motion = set_in_motion(subject, weather);
  Loop loop = make_loop(subject.structure, surface, motion,
                        {.name = "avenue", .frames_per_second = 20, .wind_speed = 6});
  // Without this the writers make morph targets.
  const ClipSource clip{"wind loop", &motion, 6};
  loop.rig = std::make_shared<const Rig>(
      fit_rig(subject.structure, surface, {&clip, 1}, {.tolerance = 0.01, .shapes_of = 0}));

  loop.instances.clear();
  for (int i = 0; i < 6; ++i) {
    // The golden section spreads turns and time shifts evenly and without a pattern.
    const double part = std::fmod(0.618034 * i, 1);
    loop.instances.push_back({.position = {1.6 * (i / 2), 1.8 * (i % 2), 0},
                              .turn = 6.283185 * part,
                              .scale = 1 - 0.3 * part,
                              .time_shift = loop.period * part});
    const Instance& it = loop.instances.back();
    std::printf("%.17g %.17g %.17g %.17g %.17g\n", it.position.x(), it.position.y(), it.turn, it.scale,
                it.time_shift);
  }

  if (argument_count > 1) {
    for (const LoopWriter& writer : loop_writers()) {
      const bool wanted = writer.extension == "glb" || (writer.extension == "html" && can_write_html());
      if (!wanted) continue;
      const std::string path = std::string(arguments[1]) + "/avenue." + std::string(writer.extension);
      write_file_atomically(path, writer.encode(loop, {}));
    }
  }
  return loop.instances.size() == 6 ? 0 : 1;
}
