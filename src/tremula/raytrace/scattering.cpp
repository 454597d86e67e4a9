#include "tremula/raytrace/scattering.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace tremula {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr float pi = std::numbers::pi_v<float>;
constexpr float at_normal = 0.04F;  // reflected by wax and varnish, refractive index 1.5

float fresnel(float cosine) {
  const float rest = 1 - std::clamp(cosine, 0.0F, 1.0F), square = rest * rest;
  return at_normal + (1 - at_normal) * square * square * rest;
}

// Smith's term of one direction: how much of the facets it sees.
float seen(float cosine, float alpha) {
  const float square = alpha * alpha;
  return 2 * cosine / (cosine + std::sqrt(square + (1 - square) * cosine * cosine));
}

struct Lobes {
  float gloss, reflected;  // chances: of the coat; of the reflecting side, if it is not the coat
};

Lobes lobes_of(const Scattering& spot, float cosine) {
  const float reflected = spot.reflected.sum(), transmitted = spot.transmitted.sum();
  const float both = reflected + transmitted;
  Lobes lobes{0, both > 0 ? reflected / both : 1};
  if (spot.gloss == nullptr) return lobes;
  const float coat = spot.gloss->share(cosine), dull = (1 - coat) * both / 3;
  lobes.gloss = dull > 0 ? coat / (coat + dull) : 1;
  return lobes;
}

}  // namespace

Gloss::Gloss(float roughness) : alpha(std::clamp(roughness * roughness, 0.01F, 1.0F)) {
  // Per direction the mean of what samples of the facets bring, over a grid of them.
  constexpr int grid = 24;
  for (int i = 0; i <= steps; ++i) {
    const float cosine = std::max(static_cast<float>(i) / steps, 0.002F);
    const Vector3f to_eye(std::sqrt(1 - cosine * cosine), 0, cosine);
    double sum = 0;
    for (int a = 0; a < grid; ++a) {
      for (int b = 0; b < grid; ++b) {
        const Vector2f random((static_cast<float>(a) + 0.5F) / grid, (static_cast<float>(b) + 0.5F) / grid);
        const Vector3f to_light = sample(to_eye, random);
        float density = 0;
        if (to_light.z() <= 0) continue;
        const float found = value(to_eye, to_light, density);
        if (density > 0) sum += static_cast<double>(found / density);
      }
    }
    share_[static_cast<std::size_t>(i)] = static_cast<float>(sum / (grid * grid));
  }
  // 2 times the integral of share(c) c, of which share is piecewise linear.
  double mean = 0;
  for (int i = 0; i < steps; ++i) {
    const double a = static_cast<double>(i) / steps, b = static_cast<double>(i + 1) / steps;
    const auto low = static_cast<double>(share_[static_cast<std::size_t>(i)]);
    const auto high = static_cast<double>(share_[static_cast<std::size_t>(i) + 1]);
    mean += (b - a) * (low * (2 * a + b) + high * (a + 2 * b)) / 3;
  }
  mean_share_ = static_cast<float>(mean);
}

float Gloss::share(float cosine) const {
  const float place = std::clamp(cosine, 0.0F, 1.0F) * steps;
  const int cell = std::min(static_cast<int>(place), steps - 1);
  const float t = place - static_cast<float>(cell);
  return (1 - t) * share_[static_cast<std::size_t>(cell)] + t * share_[static_cast<std::size_t>(cell) + 1];
}

float Gloss::passed(float to_eye, float to_light) const {
  return (1 - share(to_eye)) * (1 - share(to_light)) / (1 - mean_share_);
}

float Gloss::value(const Vector3f& to_eye, const Vector3f& to_light, float& density) const {
  const Vector3f half = (to_eye + to_light).normalized();
  const float square = alpha * alpha, slope = half.z() * half.z() * (square - 1) + 1;
  const float facets = square / (pi * slope * slope);
  const float of_eye = seen(to_eye.z(), alpha), of_light = seen(to_light.z(), alpha);
  density = facets * of_eye / (4 * to_eye.z());
  // Heights correlated (Heitz 2014): 1 / (1 + L_eye + L_light) with L = 1 / seen - 1.
  const float both = of_eye * of_light / (of_eye + of_light - of_eye * of_light);
  return facets * both * fresnel(to_light.dot(half)) / (4 * to_eye.z());
}

// The facets that the eye sees (Heitz, Sampling the GGX distribution of visible normals, JCGT 7 (4), 2018).
Vector3f Gloss::sample(const Vector3f& to_eye, const Vector2f& random) const {
  const Vector3f stretched = Vector3f(alpha * to_eye.x(), alpha * to_eye.y(), to_eye.z()).normalized();
  const float across = stretched.head<2>().squaredNorm();
  const Vector3f x = across > 0 ? Vector3f(Vector3f(-stretched.y(), stretched.x(), 0) / std::sqrt(across))
                                : Vector3f(1, 0, 0);
  const Vector3f y = stretched.cross(x);
  const float radius = std::sqrt(random.x()), angle = 2 * pi * random.y();
  const float a = radius * std::cos(angle), s = 0.5F * (1 + stretched.z());
  const float b = (1 - s) * std::sqrt(std::max(0.0F, 1 - a * a)) + s * radius * std::sin(angle);
  const Vector3f facet = a * x + b * y + std::sqrt(std::max(0.0F, 1 - a * a - b * b)) * stretched;
  const Vector3f normal =
      Vector3f(alpha * facet.x(), alpha * facet.y(), std::max(1e-6F, facet.z())).normalized();
  return 2 * to_eye.dot(normal) * normal - to_eye;
}

Vector3f facing(const Vector3f& normal, const Vector3f& to_eye) {
  constexpr float least = 0.02F;
  const float cosine = normal.dot(to_eye);
  if (cosine >= least) return normal;
  return (normal + (least - cosine) * to_eye).normalized();
}

Rgb scattered(const Scattering& spot, const Vector3f& to_eye, const Vector3f& to_light, float& density) {
  const float to_side = to_light.dot(spot.plane), straight = to_light.dot(spot.normal);
  const float mirrored = straight - 2 * to_side * spot.plane.dot(spot.normal);
  const float eye = to_eye.dot(spot.normal);
  const Lobes lobes = lobes_of(spot, eye);
  density = 0;
  Rgb sum = Rgb::Zero();
  const auto add_dull = [&](const Rgb& albedo, float chance, float cosine) {
    const float lobe = cosine / pi;
    sum += (spot.gloss ? spot.gloss->passed(eye, cosine) : 1.0F) * lobe * albedo;
    density += (1 - lobes.gloss) * chance * lobe;
  };
  if (to_side < 0) {
    if (straight < 0) add_dull(spot.transmitted, 1 - lobes.reflected, -straight);
    if (mirrored < 0) add_dull(spot.transmitted, 1 - lobes.reflected, -mirrored);
    return sum;
  }
  if (straight > 0) add_dull(spot.reflected, lobes.reflected, straight);
  if (mirrored > 0) add_dull(spot.reflected, lobes.reflected, mirrored);
  if (spot.gloss == nullptr) return sum;
  const LocalAxes axes(spot.normal);
  const Vector3f from = axes.in(to_eye);
  const auto add_gloss = [&](const Vector3f& direction) {
    float of_lobe = 0;
    sum += Rgb::Constant(spot.gloss->value(from, axes.in(direction), of_lobe));
    density += lobes.gloss * of_lobe;
  };
  if (straight > 0) add_gloss(to_light);
  if (mirrored > 0) add_gloss(to_light - 2 * to_side * spot.plane);
  return sum;
}

Vector3f scatter(const Scattering& spot, const Vector3f& to_eye, float choice, const Vector2f& random) {
  const LocalAxes axes(spot.normal);
  const Lobes lobes = lobes_of(spot, to_eye.dot(spot.normal));
  Vector3f direction;
  bool through = false;
  if (choice < lobes.gloss) {
    const Vector3f local = spot.gloss->sample(axes.in(to_eye), random);
    if (local.z() <= 0) return Vector3f::Zero();  // the coat's share knows of it
    direction = axes.out(local);
  } else {
    through = (choice - lobes.gloss) / (1 - lobes.gloss) >= lobes.reflected;
    direction = axes.out(to_cosine_lobe(random));
    if (through) direction = -direction;
  }
  const float to_side = direction.dot(spot.plane);
  if (through ? to_side > 0 : to_side < 0) direction -= 2 * to_side * spot.plane;
  return direction;
}

}  // namespace tremula
