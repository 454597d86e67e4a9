// How fast pictures are traced:
//   bench_raytrace bound [WIDTH HEIGHT SAMPLES]   the oak; rays a second, beside those of Embree alone, which
//   shoots
//                                                 the same rays again and shades nothing
//   bench_raytrace oak [WIDTH HEIGHT SAMPLES]     the oak with motion blur, 960 x 540, 64 samples
//   bench_raytrace segments                       100 000 pieces of stem, 512 x 512, one sample
//   bench_raytrace forest [COPIES POSES PLANT]    10 000 saplings: memory, and how long a frame's poses take
//   bench_raytrace impressions [COPIES]           10 000 impressionist trees: the wind over them, their
//   poses, rays
// Seconds of the clock, and of processors: those are what counts on a machine that has other work.
#include "tremula/deformation/loop.hpp"
#include "tremula/geometry/grow.hpp"
#include "tremula/geometry/lsystem.hpp"
#include "tremula/geometry/plants.hpp"
#include "tremula/geometry/surface.hpp"
#include "tremula/pipeline.hpp"
#include "tremula/raytrace/impression_rays.hpp"
#include "tremula/raytrace/path.hpp"
#include "tremula/raytrace/raytrace.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <sys/resource.h>

namespace {

using namespace tremula;
using Eigen::Vector3f;

double processor_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double largest_megabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

struct Stopwatch {
  std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
  double processors = processor_seconds();

  double clock() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }
  double processor() const { return processor_seconds() - processors; }
};

Loop loop_in_wind(const std::string& preset, int modes) {
  const GrownPlant plant = grow(parse_lsystem(find_preset(preset).text, preset));
  const Subject subject = bake(plant.skeleton, {.modes = {.count = modes}});
  SurfaceOptions skin;
  skin.tube.color = plant.bark_color.value_or(skin.tube.color);
  skin.leaf.color = plant.leaf_color.value_or(skin.leaf.color);
  Weather weather;
  weather.wind = turbulent_wind({.speed = 8}, 0.2);
  return make_loop(subject.structure, mesh_surface(plant.skeleton, skin), set_in_motion(subject, weather),
                   {.name = preset, .wind_speed = 8});
}

Camera camera_of(const Loop& loop, double aspect) {
  Camera camera = frame_points(loop.rest->position, 0.3, 0.02, aspect);
  camera.eye.z() = std::max(camera.eye.z(), 1.5);
  return camera;
}

TraceOptions options_of(int count, char** arguments, TraceOptions options) {
  if (count > 2) options.width = std::atoi(arguments[2]);
  if (count > 3) options.height = std::atoi(arguments[3]);
  if (count > 4) options.samples = std::atoi(arguments[4]);
  return options;
}

void print(const char* what, const TraceCounts& counts, const Stopwatch& watch) {
  std::printf(
      "%s: %.2f s (build %.2f s), of processors %.2f s; %.1f M rays, %.2f M a processor second; "
      "%llu triangles, %llu copies, %.0f MB at most\n",
      what, watch.clock(), counts.seconds_build, watch.processor(), static_cast<double>(counts.rays) * 1e-6,
      static_cast<double>(counts.rays) * 1e-6 / watch.processor(),
      static_cast<unsigned long long>(counts.triangles), static_cast<unsigned long long>(counts.instances),
      largest_megabytes());
}

// On one thread: the rays of the paths, with all that is done between them, and the rays alone.
void measure_bound(const Loop& loop, const TraceOptions& options) {
  TraceScene scene;
  scene.loops = {std::make_shared<const Loop>(loop)};
  const FarLight far_light(scene);
  const EmbreeDevice device = make_device();
  std::vector<LoopShape> shapes;
  shapes.push_back(shape_of(scene.loops[0], scene.poses_per_loop));
  const double as_many_as_in_a_frame = 960.0 * 540 * 64;
  const PosedScene posed(device.get(), {&shapes[0]}, {}, 3, options.shutter, as_many_as_in_a_frame);
  const Camera camera = camera_of(loop, static_cast<double>(options.width) / options.height);
  std::vector<ShotRay> shot;
  const auto trace_all = [&](std::vector<ShotRay>* log) {
    const PathSettings path{posed,
                            far_light,
                            scene.ground,
                            options.bounces,
                            static_cast<float>(2 * camera.half_height / options.height),
                            log};
    std::uint64_t rays = 0;
    for (int i = 0; i < options.width * options.height; ++i) {
      for (int s = 0; s < options.samples; ++s) {
        Sampler sampler(1, static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(s));
        const double x = (i % options.width + 0.5) / options.width,
                     y = (i / options.width + 0.5) / options.height;
        const Vec3 towards = camera.forward +
                             (2 * x - 1) * camera.half_height * camera.aspect * camera.right +
                             (1 - 2 * y) * camera.half_height * camera.up;
        Ray ray{camera.eye.cast<float>(), towards.normalized().cast<float>()};
        ray.time = sampler.one();
        follow(path, ray, sampler, rays);
      }
    }
    return rays;
  };
  const Stopwatch ours;
  const std::uint64_t rays = trace_all(nullptr);
  const double seconds = ours.processor();
  trace_all(&shot);
  const Stopwatch bare;
  std::uint64_t met = 0;
  for (const ShotRay& each : shot) {
    met += each.any ? posed.blocked(each.ray, each.farthest)
                    : static_cast<bool>(posed.closest(each.ray, each.farthest));
  }
  const double bound = bare.processor();
  const auto any = std::count_if(shot.begin(), shot.end(), [](const ShotRay& each) { return each.any; });
  std::printf(
      "shutter %.3g s: %.2f M rays (%.0f %% of them shadows, %.0f %% met something) a thread: ours %.2f M/s, "
      "Embree alone %.2f M/s: %.0f %% of it\n",
      options.shutter, static_cast<double>(rays) * 1e-6,
      100 * static_cast<double>(any) / static_cast<double>(shot.size()),
      100 * static_cast<double>(met) / static_cast<double>(shot.size()),
      static_cast<double>(rays) * 1e-6 / seconds, static_cast<double>(rays) * 1e-6 / bound,
      100 * bound / seconds);
}

void measure_oak(const TraceOptions& options) {
  const Loop loop = loop_in_wind("oak", 20);
  TraceScene scene;
  scene.loops = {std::make_shared<const Loop>(loop)};
  TraceCounts counts;
  const Tracer tracer(scene);
  const Camera camera = camera_of(loop, static_cast<double>(options.width) / options.height);
  const Stopwatch watch;
  tracer.trace([&](double) { return camera; }, 3, options, {}, &counts);
  print("oak", counts, watch);
}

// Stems of 50 pieces each that lean this way and that.
void measure_segments() {
  Skeleton skeleton;
  for (int stem = 0; stem < 2000; ++stem) {
    Vec3 at(0.25 * (stem % 50), 0.25 * (stem / 50), 0);
    const double turn = 2.4 * stem;
    skeleton.roots.push_back(at);
    for (int piece = 0; piece < 50; ++piece) {
      Branch branch;
      branch.start_node = piece == 0 ? stem : 2000 + 50 * stem + piece - 1;
      branch.start = at;
      at += Vec3(0.0012 * piece * std::cos(turn), 0.0012 * piece * std::sin(turn), 0.06);
      branch.end = at;
      branch.start_radius = 0.02 - 0.00036 * piece;
      branch.end_radius = branch.start_radius - 0.00036;
      skeleton.branches.push_back(branch);
    }
  }
  Loop loop;
  loop.period = 1;
  loop.coordinates = Eigen::MatrixXd::Zero(2, 1);
  loop.rest =
      std::make_shared<const Surface>(mesh_surface(skeleton, {.max_sides = 6, .bend_subdivisions = 0}));
  loop.skin_at = [vertices = loop.rest->vertex_count()](double) {
    return SurfaceDelta{std::vector<Vector3f>(vertices, Vector3f::Zero()),
                        std::vector<Vector3f>(vertices, Vector3f::Zero())};
  };
  TraceScene scene;
  scene.loops = {std::make_shared<const Loop>(loop)};
  const Tracer tracer(scene);
  const Camera camera = camera_of(loop, 1);
  for (const int bounces : {1, 6}) {
    TraceCounts counts;
    const Stopwatch watch;
    tracer.trace([&](double) { return camera; }, 0,
                 {.width = 512, .height = 512, .samples = 1, .bounces = bounces}, {}, &counts);
    print(("100 000 pieces, " + std::to_string(bounces) + " bounces").c_str(), counts, watch);
  }
}

void measure_forest(int copies, int poses, const std::string& preset) {
  Loop loop = loop_in_wind(preset, 12);
  double reach = 0;
  for (const Vector3f& at : loop.rest->position)
    reach = std::max(reach, static_cast<double>(at.head<2>().norm()));
  const double side = 2 * reach * std::sqrt(copies);
  loop.instances.clear();
  for (int i = 0; i < copies; ++i) {
    const auto part = [&](double irrational) { return std::fmod(irrational * i, 1); };
    loop.instances.push_back(
        {.position = {side * (part(0.7548776662) - 0.5), side * (part(0.5698402910) - 0.5), 0},
         .turn = 6.283185 * part(0.618034),
         .scale = 0.7 + 0.6 * part(0.381966),
         .time_shift = loop.period * part(0.324718)});
  }
  TraceScene scene;
  scene.loops = {std::make_shared<const Loop>(loop)};
  scene.poses_per_loop = poses;
  Camera camera;
  camera.eye = {-side / 2, 0, 4};
  camera.half_height = 0.3;
  camera.aspect = 16.0 / 9;
  const Stopwatch loading;
  const Tracer tracer(scene);
  std::printf("scene of %d copies taken in %.2f s\n", copies, loading.clock());
  TraceCounts counts;
  const Stopwatch watch;
  tracer.trace([&](double) { return camera; }, 3,
               {.width = 480, .height = 270, .samples = 4, .shutter = 1.0 / 60}, {}, &counts);
  print("forest", counts, watch);
}

void measure_impressions(int copies) {
  const ImpressionistTree tree = impressionist_tree("round", 12);
  const double side = tree.width * std::sqrt(copies);
  std::vector<Instance> instances;
  std::vector<Vec3> places;
  for (int i = 0; i < copies; ++i) {
    const auto part = [&](double irrational) { return std::fmod(irrational * i, 1); };
    places.emplace_back(side * part(0.7548776662), side * (part(0.5698402910) - 0.5), 0);
    instances.push_back({.position = places.back(), .turn = 6.283185 * part(0.618034)});
  }
  const TimeAxis loop{.period = 20, .sample_count = 600};
  const Wind wind = turbulent_wind({.speed = 8}, 0.2);
  const Stopwatch blowing;
  const Structure trunk = assemble(trunk_skeleton(tree), {.material = find_material(tree.material)});
  const TrunkSway sway = trunk_sway(trunk, wind, loop, {.crown_radius = tree.width / 2});
  const TravellingField gusts = gust_field(wind, loop, plane_across(places, 0, 5, {sway.gust_height}));
  TraceScene scene;
  scene.ray_shapes = {impression_shape(tree, std::move(instances), impression_motion(sway, gusts))};
  std::printf("%d trees sway at %.2f Hz; their wind and what it does to them took %.2f s\n", copies,
              sway.frequency[0], blowing.clock());
  const Stopwatch posing;
  constexpr int frames = 20;
  for (int i = 0; i < frames; ++i) scene.ray_shapes[0]->pose(0.1 * i, 1.0 / 60);
  std::printf("a frame's poses: %.2f ms\n", 1000 * posing.clock() / frames);
  const Tracer tracer(scene);
  Camera camera;
  camera.eye = {-0.15 * side, 0, 25};
  camera.half_height = 0.25;
  camera.aspect = 16.0 / 9;
  TraceCounts counts;
  const Stopwatch watch;
  tracer.trace([&](double) { return camera; }, 3,
               {.width = 480, .height = 270, .samples = 4, .shutter = 1.0 / 60}, {}, &counts);
  print("impressions", counts, watch);
}

}  // namespace

int main(int count, char** arguments) {
  const std::string what = count > 1 ? arguments[1] : "bound";
  if (what == "bound") {
    const Loop loop = loop_in_wind("oak", 20);
    for (const double shutter : {0.0, 1.0 / 60}) {
      measure_bound(loop, options_of(count, arguments,
                                     {.width = 480, .height = 270, .samples = 4, .shutter = shutter}));
    }
  } else if (what == "oak") {
    measure_oak(options_of(count, arguments, {.shutter = 1.0 / 60}));
  } else if (what == "segments") {
    measure_segments();
  } else if (what == "forest") {
    measure_forest(count > 2 ? std::atoi(arguments[2]) : 10000, count > 3 ? std::atoi(arguments[3]) : 24,
                   count > 4 ? arguments[4] : "sapling");
  } else if (what == "impressions") {
    measure_impressions(count > 2 ? std::atoi(arguments[2]) : 10000);
  } else {
    std::fprintf(
        stderr,
        "bench_raytrace: '%s' is nothing to measure; bound, oak, segments, forest and impressions are\n",
        what.c_str());
    return 2;
  }
  return 0;
}
