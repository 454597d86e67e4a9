// Light along a path from the eye: what a ray of the camera sees (Kajiya 1986, with next-event estimation and
// multiple importance sampling by Veach's power heuristic).
#pragma once

#include "tremula/raytrace/far_light.hpp"
#include "tremula/raytrace/posed_scene.hpp"
#include "tremula/raytrace/raytrace.hpp"
#include "tremula/raytrace/sampling.hpp"

#include <cstdint>

namespace tremula {

struct PathSettings {
  const PosedScene& scene;
  const FarLight& far_light;
  const GroundLook& ground;
  int bounces = 6;
  float pixel = 0.001F;  // its size at distance 1
};

struct PathSample {
  Rgb light = Rgb::Zero();
  Rgb albedo = Rgb::Ones();  // of what is seen first
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();
};

// `rays` counts those that are shot.
PathSample follow(const PathSettings& settings, Ray ray, Sampler& sampler, std::uint64_t& rays);

}  // namespace tremula
