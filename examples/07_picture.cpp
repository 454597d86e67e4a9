// A picture by path tracing: a loop, where the camera stands, where the sun stands. With a folder it writes
// picture.png there. Without Embree there is nothing to see, and it says so.

#include <tremula/deformation/loop.hpp>
#include <tremula/geometry/grow.hpp>
#include <tremula/geometry/plants.hpp>
#include <tremula/geometry/surface.hpp>
#include <tremula/io/atomic_file.hpp>
#include <tremula/pipeline.hpp>
#include <tremula/raytrace/raytrace.hpp>
#include <tremula/render/denoise.hpp>
#include <tremula/render/image.hpp>
#include <tremula/render/tone_map.hpp>

#include <cmath>
#include <cstdio>
#include <memory>
#include <string>

int main(int argument_count, char** arguments) {
  using namespace tremula;
  if (!can_trace()) {
    std::puts("this library was built without Embree");
    return 0;
  }

  const GrownPlant plant = grow(parse_lsystem(find_preset("sapling").text, "sapling"));
  const Subject subject = bake(plant.skeleton, {.modes = {.count = 12}});
  Weather weather;
  weather.loop = {.period = 12, .sample_count = 240};
  const auto loop = std::make_shared<const Loop>(
      make_loop(subject.structure, mesh_surface(plant.skeleton), set_in_motion(subject, weather), {}));

  TraceScene scene{.loops = {loop}};
  scene.daylight = {.sun_azimuth = -0.9, .sun_elevation = 0.6};
  const Camera camera =
      frame_points(loop->rest->position, -1.6, 0.05, 1);  // from the right of a wind along x
  const TracedImage traced = Tracer(scene).trace([&](double) { return camera; }, 4.2,
                                                 {.width = 96, .height = 96, .samples = 16, .shutter = 0.02});

  const ToneMapping tones{.exposure = exposure_of(Daylight(scene.daylight)), .white = daylight_white};
  const Image image = tone_map(denoise(traced), tones);
  if (argument_count > 1)
    write_file_atomically(std::string(arguments[1]) + "/picture.png", encode_png(image));

  // The sky, in the upper left corner, is blue and bright; the ground, below, is green.
  const std::uint8_t *sky = image.pixel(4, 4), *ground = image.pixel(4, 92);
  std::printf("sky %d %d %d, ground %d %d %d\n", sky[0], sky[1], sky[2], ground[0], ground[1], ground[2]);
  return sky[2] > sky[0] && sky[2] > 100 && ground[1] > ground[2] ? 0 : 1;
}
