// Light along a path from the eye: what a ray of the camera sees (Kajiya 1986, with next-event estimation and
// multiple importance sampling by Veach's power heuristic).
#pragma once

#include "tremula/raytrace/far_light.hpp"
#include "tremula/raytrace/posed_scene.hpp"
#include "tremula/raytrace/raytrace.hpp"
#include "tremula/raytrace/sampling.hpp"

#include <cstdint>
#include <vector>

namespace tremula {

// A ray that was shot, for a benchmark that shoots it again.
struct ShotRay {
  Ray ray;
  float farthest = 0;
  bool any = false;  // asked whether something is in the way, not what
};

struct PathSettings {
  const PosedScene& scene;
  const FarLight& far_light;
  const GroundLook& ground;
  int bounces = 6;
  float pixel = 0.001F;                  // its size at distance 1
  std::vector<ShotRay>* shot = nullptr;  // takes all rays, where there is one; from one thread
};

struct PathSample {
  Rgb light = Rgb::Zero();
  Rgb albedo = Rgb::Ones();  // of what is seen first
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();
};

// `rays` counts those that are shot.
PathSample follow(const PathSettings& settings, Ray ray, Sampler& sampler, std::uint64_t& rays);

}  // namespace tremula
