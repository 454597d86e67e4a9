#include "shot.hpp"

#include "tremula/scene/haze.hpp"

#include <algorithm>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace tremula::cli {
namespace {

constexpr double degree = std::numbers::pi / 180;

const std::map<std::string, GroundKind> ground_kinds{
    {"none", GroundKind::none}, {"grass", GroundKind::grass}, {"soil", GroundKind::soil},
    {"sand", GroundKind::sand}, {"snow", GroundKind::snow},   {"plain", GroundKind::plain}};

// What moves, at rest and at some instants, for a camera to frame: the skin of a few, boxes of many.
std::vector<Eigen::Vector3f> points_of(const SharedLoops& loops) {
  constexpr int instants = 6;
  constexpr std::size_t few = 4, most_points = 4000;  // copies; points of a skin
  std::vector<Eigen::Vector3f> points;
  for (const std::shared_ptr<const Loop>& loop : loops) {
    std::vector<Eigen::Vector3f> own;
    const std::vector<Eigen::Vector3f>& rest = loop->rest->position;
    const std::size_t stride = 1 + rest.size() / most_points;
    for (int i = 0; i < instants; ++i) {
      const SurfaceDelta delta = loop->skin_at(loop->period * i / instants);
      for (std::size_t v = 0; v < rest.size(); v += stride) own.push_back(rest[v] + delta.position[v]);
    }
    if (loop->instances.size() > few) {
      Eigen::AlignedBox3f box;
      for (const Eigen::Vector3f& point : own) box.extend(point);
      own.clear();
      for (int corner = 0; corner < 8; ++corner)
        own.push_back(box.corner(static_cast<Eigen::AlignedBox3f::CornerType>(corner)));
    }
    for (const Instance& instance : loop->instances) {
      const Eigen::Matrix3f turn = (instance.scale * instance.rotation()).cast<float>();
      for (const Eigen::Vector3f& point : own)
        points.push_back(turn * point + instance.position.cast<float>());
    }
  }
  return points;
}

// From where the first of what moves is best looked at.
double azimuth_of(const SharedLoops& loops, double heading) {
  const Loop& loop = *loops.front();
  std::vector<std::vector<Eigen::Vector3f>> normals;
  for (int i = 0; i < 4; ++i) {
    const SurfaceDelta delta = loop.skin_at(loop.period * i / 4);
    std::vector<Eigen::Vector3f> pose;
    for (std::size_t v = 0; v < delta.normal.size(); ++v)
      pose.push_back((loop.rest->normal[v] + delta.normal[v]).normalized());
    normals.push_back(std::move(pose));
  }
  return azimuth_across(normals, heading * degree);
}

}  // namespace

FilmCamera camera_of(const Scene& scene, const SceneCommands& commands, const MovingScene& moving) {
  SharedLoops framed = moving.loops();
  if (!scene.camera.frame.empty()) {
    framed.clear();
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
      if (std::ranges::find(scene.camera.frame, scene.objects[i].name) == scene.camera.frame.end()) continue;
      framed.insert(framed.end(), moving.objects[i].begin(), moving.objects[i].end());
    }
  }
  const bool stands = scene.camera.eye || !scene.camera.path.empty();
  if (!stands && framed.empty()) {
    const std::string at = scene.camera.place.line > 0 ? text_of(scene.camera.place) + ": " : "";
    throw InputError(at + "camera.eye", "none", "where the camera stands, in a scene without [[objects]]");
  }
  std::vector<Eigen::Vector3f> points;
  if (!stands) points = points_of(framed);
  const Eigen::Vector2d size = scene.picture.size.cast<double>();
  return film_camera(scene.camera, scene.ground,
                     {.points = points,
                      .aspect = size.x() / size.y(),
                      .period = commands.loop.period,
                      .azimuth = stands ? 0 : azimuth_of(framed, commands.wind.heading)});
}

TraceScene trace_scene(const Scene& scene, bool under_water, SharedLoops loops) {
  TraceScene traced{.loops = std::move(loops),
                    .ground = {ground_kinds.at(scene.ground.kind), scene.ground.height, scene.ground.color,
                               scene.ground.grass_height}};
  traced.under_water = scene.medium.kind == "water" || (scene.medium.kind == "auto" && under_water);
  traced.haze.extinction = extinction_of(scene.medium, traced.under_water);
  traced.daylight = {.sun_azimuth = scene.sky.sun_azimuth,
                     .sun_elevation = scene.sky.sun_elevation,
                     .turbidity = scene.sky.turbidity};
  if (scene.sky.uniform) {
    const auto radiance = static_cast<float>(*scene.sky.uniform);
    traced.uniform_sky = Eigen::Vector3f(radiance, radiance, radiance);
  }
  return traced;
}

void stand_alone(Scene& scene, const SceneCommands& commands, const Surface& rest) {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& point : rest.position) box.extend(point);
  const double low = box.min().z(), size = box.sizes().maxCoeff();
  const bool hangs = !rest.parts.empty() && rest.parts.front().material.name == "cloth";
  scene.ground.height = hangs ? low - 3 * size : low;
  if (hangs) scene.camera.elevation = -12 * degree;
  if (commands.under_water) {
    scene.ground.kind = "sand";
    scene.medium.visibility =
        std::max(default_visibility_in_water, 8 * size);  // it is seen from 2 or 3 times its size
  }
  constexpr double from_camera = 50;  // [degrees]
  scene.sky.sun_azimuth = (commands.wind.heading - 105 + from_camera) * degree;
}

ToneMapping tones_of(const TraceScene& traced, double stops) {
  if (traced.uniform_sky) return {.exposure = exposure_of(*traced.uniform_sky, stops), .dither = true};
  return {.exposure = exposure_of(Daylight(traced.daylight), stops), .white = daylight_white, .dither = true};
}

}  // namespace tremula::cli
