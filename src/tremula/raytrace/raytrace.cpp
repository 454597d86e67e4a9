#include "tremula/raytrace/raytrace.hpp"

#include "tremula/base/error.hpp"
#include "tremula/raytrace/far_light.hpp"
#include "tremula/raytrace/grass.hpp"
#include "tremula/raytrace/path.hpp"
#include "tremula/raytrace/posed_scene.hpp"
#include "tremula/raytrace/sampling.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <mutex>
#include <string>
#include <utility>

#include <tbb/parallel_for.h>

namespace tremula {
namespace {

using Clock = std::chrono::steady_clock;
using Eigen::Vector2f;
using Eigen::Vector3f;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

void check_within(const char* what, std::int64_t found, std::int64_t least, std::int64_t most) {
  if (found < least || found > most)
    throw InputError(what, std::to_string(found), std::to_string(least) + " to " + std::to_string(most));
}

void check_number(const char* what, double found, bool good, const char* wanted) {
  if (!std::isfinite(found) || !good) throw InputError(what, std::to_string(found), wanted);
}

void check_rgb(const char* what, const Vector3f& found, float most, const char* wanted) {
  if (found.allFinite() && found.minCoeff() >= 0 && found.maxCoeff() <= most) return;
  throw InputError(
      what, std::to_string(found[0]) + ", " + std::to_string(found[1]) + ", " + std::to_string(found[2]),
      wanted);
}

void check_scene(const TraceScene& scene) {
  check_within("poses of a loop", scene.poses_per_loop, 1, 4096);
  check_number("posed triangles", scene.posed_triangles, scene.posed_triangles > 0, "a number above 0");
  check_number("height of the ground", scene.ground.height, true, "a finite height [m]");
  check_rgb("colour of the ground", scene.ground.color, 1, "three numbers from 0 to 1");
  check_number("height of the grass", scene.ground.grass_height,
               scene.ground.grass_height >= 0 && scene.ground.grass_height <= 1, "a height from 0 to 1 [m]");
  check_rgb("extinction of the haze", scene.haze.extinction, 1e6F, "three numbers from 0 to 1e6 [1/m]");
  for (const std::shared_ptr<const RayShape>& shape : scene.ray_shapes) {
    if (!shape || !shape->pose) throw InputError("shapes of the scene", "one that is not there", "shapes");
  }
  if (scene.uniform_sky) check_rgb("uniform sky", *scene.uniform_sky, 1e9F, "three numbers from 0 to 1e9");
}

void check_options(const TraceOptions& options) {
  check_within("width of the picture", options.width, 1, 16384);
  check_within("height of the picture", options.height, 1, 16384);
  check_within("samples of a pixel", options.samples, 1, 65536);
  check_within("bounces of light", options.bounces, 0, 64);
  check_number("shutter", options.shutter, options.shutter >= 0, "a time of 0 or more [s]");
  check_number("radius of the lens", options.lens.radius, options.lens.radius >= 0,
               "a length of 0 or more [m]");
  check_number("distance of focus", options.lens.focus_distance, options.lens.focus_distance > 0,
               "a distance above 0 [m]");
}

void check_camera(const Camera& camera, const GroundLook& ground) {
  const bool finite = camera.eye.allFinite() && camera.right.allFinite() && camera.up.allFinite() &&
                      camera.forward.allFinite();
  if (!finite) throw InputError("camera", "a number that is not finite", "finite numbers");
  check_number("camera: half height", camera.half_height, camera.half_height > 0, "a number above 0");
  check_number("camera: aspect", camera.aspect, camera.aspect > 0, "a number above 0");
  if (ground.kind != GroundKind::none && camera.eye.z() <= ground.height) {
    throw InputError("camera: height of the eye", std::to_string(camera.eye.z()) + " m",
                     "one above the ground, which is at " + std::to_string(ground.height) + " m");
  }
}

// The camera at equidistant instants of the shutter; between them it is taken to go straight on.
std::vector<Camera> cameras_within(const std::function<Camera(double)>& camera, double time, double shutter,
                                   const GroundLook& ground) {
  constexpr int most = 9;
  std::vector<Camera> cameras;
  const int count = shutter > 0 ? most : 1;
  for (int i = 0; i < count; ++i) {
    cameras.push_back(
        camera(count > 1 ? time + shutter * (static_cast<double>(i) / (count - 1) - 0.5) : time));
    check_camera(cameras.back(), ground);
  }
  return cameras;
}

Camera between(const std::vector<Camera>& cameras, double share) {
  if (cameras.size() == 1) return cameras.front();
  const double place = share * static_cast<double>(cameras.size() - 1);
  const std::size_t i = std::min(static_cast<std::size_t>(place), cameras.size() - 2);
  const double t = place - static_cast<double>(i);
  const Camera &a = cameras[i], &b = cameras[i + 1];
  const auto blend = [&](const auto& from, const auto& to) { return (from + t * (to - from)).eval(); };
  Camera camera;
  camera.eye = blend(a.eye, b.eye);
  camera.right = blend(a.right, b.right);
  camera.up = blend(a.up, b.up);
  camera.forward = blend(a.forward, b.forward);
  camera.half_height = a.half_height + t * (b.half_height - a.half_height);
  camera.aspect = a.aspect + t * (b.aspect - a.aspect);
  return camera;
}

// Through a place of the picture, 0 to 1 from its upper left corner, and of a thin lens, within the unit
// disc.
Ray camera_ray(const Camera& camera, const Lens& lens, const Eigen::Vector2d& place,
               const Vector2f& on_lens) {
  const Vec3 towards = camera.forward +
                       (2 * place.x() - 1) * camera.half_height * camera.aspect * camera.right +
                       (1 - 2 * place.y()) * camera.half_height * camera.up;
  if (!(lens.radius > 0)) return {camera.eye.cast<float>(), towards.normalized().cast<float>()};
  const Eigen::Vector2d at = lens.radius * on_lens.cast<double>();
  const Vec3 across = at.x() * camera.right + at.y() * camera.up;
  const Vec3 direction = lens.focus_distance * towards - across;
  return {(camera.eye + across).cast<float>(), direction.normalized().cast<float>()};
}

void make_room(LinearImage& image, int width, int height) {
  image.width = width;
  image.height = height;
  image.rgb.assign(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0.0F);
}

struct Picture {
  const TraceOptions& options;
  const std::vector<Camera>& cameras;
  const PathSettings& path;
};

// The mean of a pixel's samples.
void trace_pixel(const Picture& picture, int x, int y, TracedImage& image, std::uint64_t& rays) {
  const TraceOptions& options = picture.options;
  constexpr float filter = 0.8F;  // half the width of the tent over which a pixel is the mean [pixels]
  Rgb light = Rgb::Zero(), half = Rgb::Zero(), albedo = Rgb::Zero();
  Vector3f normal = Vector3f::Zero();
  const auto pixel = static_cast<std::uint32_t>(y) * static_cast<std::uint32_t>(options.width) +
                     static_cast<std::uint32_t>(x);
  for (int s = 0; s < options.samples; ++s) {
    Sampler sampler(options.seed, pixel, static_cast<std::uint32_t>(s));
    const Vector2f within = sampler.pair();
    const Eigen::Vector2d place(
        (x + 0.5 + static_cast<double>(filter * to_tent(within.x()))) / options.width,
        (y + 0.5 + static_cast<double>(filter * to_tent(within.y()))) / options.height);
    const Vector2f on_lens = options.lens.radius > 0 ? to_disc(sampler.pair()) : Vector2f(0, 0);
    const float time = options.shutter > 0 ? sampler.one() : 0.5F;
    Ray ray = camera_ray(between(picture.cameras, static_cast<double>(time)), options.lens, place, on_lens);
    ray.time = time;
    const PathSample sample = follow(picture.path, ray, sampler, rays);
    light += sample.light;
    if (s % 2 == 0) half += sample.light;
    albedo += sample.albedo;
    normal += sample.normal;
  }
  const float share = 1 / static_cast<float>(options.samples);
  Eigen::Map<Vector3f>(image.light.pixel(x, y)) = share * light;
  if (!image.half.rgb.empty())
    Eigen::Map<Vector3f>(image.half.pixel(x, y)) = half / static_cast<float>((options.samples + 1) / 2);
  Eigen::Map<Vector3f>(image.albedo.pixel(x, y)) = share * albedo;
  const float length = normal.norm();
  Eigen::Map<Vector3f>(image.normal.pixel(x, y)) = length > 0 ? Vector3f(normal / length) : normal;
}

// `done` gets what is done, one call at a time. Returns how many rays were shot.
std::uint64_t trace_tiles(const Picture& picture, TracedImage& image,
                          const std::function<void(double)>& done) {
  constexpr int tile = 16;  // [pixels]
  const int columns = (picture.options.width + tile - 1) / tile,
            rows = (picture.options.height + tile - 1) / tile;
  std::atomic<std::uint64_t> rays = 0;
  std::mutex telling;
  int finished = 0;
  tbb::parallel_for(0, columns * rows, [&](int number) {
    const int left = number % columns * tile, top = number / columns * tile;
    std::uint64_t of_tile = 0;
    for (int y = top; y < std::min(top + tile, picture.options.height); ++y) {
      for (int x = left; x < std::min(left + tile, picture.options.width); ++x)
        trace_pixel(picture, x, y, image, of_tile);
    }
    rays += of_tile;
    if (!done) return;
    const std::lock_guard lock(telling);
    done(static_cast<double>(++finished) / (columns * rows));
  });
  return rays;
}

// Every loop of many copies takes as many.
int poses_of(const TraceScene& scene) {
  double triangles = 0;
  for (const std::shared_ptr<const Loop>& loop : scene.loops) {
    if (!loop || loop->instances.size() < 2) continue;
    for (const SurfacePart& part : loop->rest->parts)
      triangles += static_cast<double>(part.triangles.size()) / 3;
  }
  if (!(triangles * scene.poses_per_loop > scene.posed_triangles)) return scene.poses_per_loop;
  return std::min(scene.poses_per_loop, std::max(2, static_cast<int>(scene.posed_triangles / triangles)));
}

}  // namespace

struct Tracer::Impl {
  TraceScene scene;
  std::vector<LoopShape> shapes;
  FarLight far_light;
  EmbreeDevice device;
  std::vector<std::shared_ptr<const Surface>> grass;

  explicit Impl(TraceScene given) : scene(std::move(given)), far_light(scene) {
    const int poses = poses_of(scene);
    for (const auto& loop : scene.loops) shapes.push_back(shape_of(loop, poses));
    device = make_device();
    const GroundLook& ground = scene.ground;
    if (ground.kind == GroundKind::grass && ground.grass_height > 0) grass = grass_tiles(ground.grass_height);
  }
};

bool can_trace() { return true; }

Tracer::Tracer(TraceScene scene) {
  check_scene(scene);
  impl_ = std::make_unique<Impl>(std::move(scene));
}

Tracer::~Tracer() = default;
Tracer::Tracer(Tracer&&) noexcept = default;
Tracer& Tracer::operator=(Tracer&&) noexcept = default;

TracedImage Tracer::trace(const std::function<Camera(double time)>& camera, double time,
                          const TraceOptions& options, const std::function<void(double)>& done,
                          TraceCounts* counts) const {
  check_options(options);
  check_number("time of the picture", time, true, "a finite time [s]");
  const std::vector<Camera> cameras = cameras_within(camera, time, options.shutter, impl_->scene.ground);
  const Clock::time_point start = Clock::now();
  const double paths = static_cast<double>(options.width) * options.height * options.samples;
  std::vector<const LoopShape*> shapes;
  for (const LoopShape& shape : impl_->shapes) shapes.push_back(&shape);
  const std::vector<LoopShape> grass = grass_before(cameras.front(), impl_->scene.ground, impl_->grass);
  for (const LoopShape& shape : grass) shapes.push_back(&shape);
  const PosedScene posed(impl_->device.get(), shapes, impl_->scene.ray_shapes, time, options.shutter, paths);
  const double built = seconds_since(start);

  TracedImage image;
  for (LinearImage* each : {&image.light, &image.albedo, &image.normal})
    make_room(*each, options.width, options.height);
  if (options.samples > 1) make_room(image.half, options.width, options.height);
  const auto pixel = static_cast<float>(2 * cameras.front().half_height / options.height);
  GroundLook ground = impl_->scene.ground;
  ground.time = time;
  const PathSettings path{posed, impl_->far_light, ground, options.bounces, pixel};
  const std::uint64_t rays = trace_tiles({options, cameras, path}, image, done);
  if (counts)
    *counts = {
        rays,  posed.triangle_count(),      posed.copy_count(), posed.pose_count(), posed.shape_count(),
        built, seconds_since(start) - built};
  return image;
}

}  // namespace tremula
