// From a scene and what moves in it to what is traced: light, ground, camera, exposure.
#pragma once

#include "tremula/raytrace/raytrace.hpp"
#include "tremula/render/tone_map.hpp"
#include "tremula/scene/film_camera.hpp"

#include "scene_objects.hpp"

namespace tremula::cli {

// A plant alone stands on the ground where it is lowest; a sheet flies high above it. The sun is behind the
// right shoulder of who looks across the wind.
void stand_alone(Scene& scene, const SceneCommands& commands, const Surface& rest);

FilmCamera camera_of(const Scene& scene, const SceneCommands& commands, const MovingScene& moving);
TraceScene trace_scene(const Scene& scene, bool under_water, SharedLoops loops);
// As bright as the day, and its white is the sun's about noon.
ToneMapping tones_of(const TraceScene& traced, double stops);

}  // namespace tremula::cli
