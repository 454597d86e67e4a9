// The camera of a scene over its film.
#pragma once

#include "tremula/render/camera.hpp"
#include "tremula/scene/scene.hpp"

#include <functional>
#include <span>

namespace tremula {

// What a camera has to know of what it looks at.
struct CameraView {
  std::span<const Eigen::Vector3f> points = {};  // to frame [m]; only where there is neither eye nor path
  double aspect = 16.0 / 9;                      // width / height of the picture
  double period = 0;                             // of the loop [s]; a path that repeats closes with it
  double azimuth = 0;  // to stand at where the scene says none (azimuth_across) [rad]
};

struct FilmCamera {
  std::function<Camera(double time)> camera;          // at any time [s]
  std::function<double(double time)> focus_distance;  // where all is sharp, along its forward axis [m]
  double lens_radius = 0;                             // [m]; 0: a pinhole
};

// Between the keys of a path, eye and look_at go along a cubic of each coordinate, which at every key has the
// slope of the parabola through it and its neighbours; heights and angles have it limited, so that they never
// leave what lies between two keys (Fritsch & Carlson 1980). A path that repeats has the same value and slope
// at its end and at its beginning. Throws InputError, naming the place in the scene's file, for a path that
// is not over before the loop, where the eye would be below the ground, and where it would be at what it
// looks at; and as frame_points does.
FilmCamera film_camera(const SceneCamera& camera, const SceneGround& ground, const CameraView& view);

}  // namespace tremula
