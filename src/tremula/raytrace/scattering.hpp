// How a spot of a surface throws light on: dull, or two-sided as leaves are, with a gloss over it.
#pragma once

#include "tremula/raytrace/sampling.hpp"
#include "tremula/render/sky.hpp"

#include <array>
#include <memory>

#include <Eigen/Core>

namespace tremula {

// A clear coat over a dull ground: microfacets of GGX (Walter et al. 2007) under Schlick's Fresnel term.
// What the coat does not send back is left to the ground, so that no energy is lost, and none made.
class Gloss {
 public:
  explicit Gloss(float roughness);  // 0 … 1

  float alpha = 0.1F;                                // width of the facets' slopes
  float share(float cosine) const;                   // of light from there that the coat reflects
  float passed(float to_eye, float to_light) const;  // factor of a dull ground beneath; symmetric
  // Value times the cosine to the light, and density, for unit vectors about z with z > 0.
  float value(const Eigen::Vector3f& to_eye, const Eigen::Vector3f& to_light, float& density) const;
  Eigen::Vector3f sample(const Eigen::Vector3f& to_eye, const Eigen::Vector2f& random) const;

 private:
  static constexpr int steps = 32;
  std::array<float, steps + 1> share_{};
  float mean_share_ = 0;  // over a hemisphere, by cosine
};

// What a spot is made of. All that is not reflected nor transmitted is swallowed.
struct Scattering {
  Eigen::Vector3f plane;                                   // unit, of the triangle, towards the eye
  Eigen::Vector3f normal;                                  // unit, of the smooth surface, towards the eye
  Rgb reflected = Rgb::Zero(), transmitted = Rgb::Zero();  // 0–1, together at most 1
  const Gloss* gloss = nullptr;                            // none: dull
};

// The smooth normal turned so that the eye sees its side.
Eigen::Vector3f facing(const Eigen::Vector3f& normal, const Eigen::Vector3f& to_eye);

// BSDF times cosine for light from `to_light`, and the density with which scatter() goes there. Light that
// the smooth normal would send to the wrong side of the triangle is mirrored by its plane: none is lost at
// silhouettes.
Rgb scattered(const Scattering& spot, const Eigen::Vector3f& to_eye, const Eigen::Vector3f& to_light,
              float& density);

// A direction for light to have come from. `choice` in [0, 1) picks the lobe.
Eigen::Vector3f scatter(const Scattering& spot, const Eigen::Vector3f& to_eye, float choice,
                        const Eigen::Vector2f& random);

}  // namespace tremula
