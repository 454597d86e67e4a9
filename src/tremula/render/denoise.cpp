#include "tremula/render/denoise.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/error.hpp"
#include "tremula/render/atmosphere.hpp"
#include "tremula/render/open_image_denoise.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <tbb/parallel_for.h>
#include <Eigen/Core>

namespace tremula {
namespace {

using Eigen::Vector3f;

constexpr int passes = 4;                                      // holes of 1, 2, 4, 8 pixels
constexpr float least_albedo = 0.01F;                          // light is divided by no less
constexpr float normal_spread = 0.25F, albedo_spread = 0.06F;  // differences that count as one
constexpr float noise_spread = 1.6F;                           // of light, in deviations of its noise
constexpr std::array<float, 3> spline = {3.0F / 8, 1.0F / 4, 1.0F / 16};  // B3, from its middle

struct Guide {
  Vector3f normal, albedo;
};

struct Planes {
  int width, height;
  std::vector<Guide> guides;
  std::vector<Vector3f> light;  // divided by the albedo
  std::vector<float> variance;  // of its luminance

  std::size_t place(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
  bool inside(int x, int y) const { return x >= 0 && y >= 0 && x < width && y < height; }
};

// Of a weight e^-difference.
float difference(const Guide& a, const Guide& b) {
  return (a.normal - b.normal).squaredNorm() / (normal_spread * normal_spread) +
         (a.albedo - b.albedo).squaredNorm() / (albedo_spread * albedo_spread);
}

Vector3f finite(const float* pixel) {
  return Vector3f(Eigen::Map<const Vector3f>(pixel)).unaryExpr([](float v) {
    return std::isfinite(v) ? v : 0.0F;
  });
}

Vector3f divisor(const Guide& guide) { return guide.albedo.cwiseMax(least_albedo); }

template <class Function>
void for_each_pixel(const Planes& planes, const Function& function) {
  tbb::parallel_for(0, planes.height, [&](int y) {
    for (int x = 0; x < planes.width; ++x) function(x, y, planes.place(x, y));
  });
}

Planes planes_of(const TracedImage& traced) {
  Planes planes{traced.light.width, traced.light.height, {}, {}, {}};
  const std::size_t count = traced.light.rgb.size() / 3;
  planes.guides.resize(count);
  planes.light.resize(count);
  planes.variance.resize(count);
  for_each_pixel(planes, [&](int x, int y, std::size_t i) {
    planes.guides[i] = {finite(traced.normal.pixel(x, y)), finite(traced.albedo.pixel(x, y)).cwiseMax(0.0F)};
    planes.light[i] = finite(traced.light.pixel(x, y)).cwiseQuotient(divisor(planes.guides[i]));
  });
  return planes;
}

// What is left of a linear change, or of a straight edge along an axis, is nothing; of noise it is 36 times
// its variance (Immerkær 1996). Beside it how alike the pixels are that it was taken of.
std::array<float, 2> curvature(const Planes& planes, int x, int y) {
  const Guide& here = planes.guides[planes.place(x, y)];
  float sum = 0, unlike = 0;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const std::size_t i =
          planes.place(std::clamp(x + dx, 0, planes.width - 1), std::clamp(y + dy, 0, planes.height - 1));
      const float weight = (dx == 0 ? 2.0F : -1.0F) * (dy == 0 ? 2.0F : -1.0F);
      sum += weight * luminance(planes.light[i]);
      unlike += difference(here, planes.guides[i]) / 9;
    }
  }
  return {sum * sum / 36, std::exp(-unlike) + 1e-6F};
}

void estimate_variance(Planes& planes) {
  constexpr int reach = 3;
  std::vector<std::array<float, 2>> found(planes.light.size());
  for_each_pixel(planes, [&](int x, int y, std::size_t i) { found[i] = curvature(planes, x, y); });
  for_each_pixel(planes, [&](int x, int y, std::size_t i) {
    float sum = 0, weights = 0;
    for (int v = std::max(y - reach, 0); v <= std::min(y + reach, planes.height - 1); ++v) {
      for (int u = std::max(x - reach, 0); u <= std::min(x + reach, planes.width - 1); ++u) {
        const std::size_t j = planes.place(u, v);
        const float weight =
            found[j][1] * (std::exp(-difference(planes.guides[i], planes.guides[j])) + 1e-6F);
        sum += weight * found[j][0];
        weights += weight;
      }
    }
    planes.variance[i] = sum / weights;
  });
}

// What pixels are compared by: their luminance, smoothed, so that one that stands out by chance is not kept
// for it.
std::vector<float> smoothed_luminance(const Planes& planes) {
  std::vector<float> smoothed(planes.light.size());
  for_each_pixel(planes, [&](int x, int y, std::size_t i) {
    float sum = 0, weights = 0;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        if (!planes.inside(x + dx, y + dy)) continue;
        const std::size_t j = planes.place(x + dx, y + dy);
        const float weight = std::exp(-difference(planes.guides[i], planes.guides[j]));
        sum += weight * luminance(planes.light[j]);
        weights += weight;
      }
    }
    smoothed[i] = sum / weights;
  });
  return smoothed;
}

void smooth(Planes& planes, int step) {
  const std::vector<float> compared = smoothed_luminance(planes);
  Planes next{planes.width,
              planes.height,
              {},
              std::vector<Vector3f>(planes.light.size()),
              std::vector<float>(planes.light.size())};
  for_each_pixel(planes, [&](int x, int y, std::size_t i) {
    Vector3f sum = Vector3f::Zero();
    float variance = 0, weights = 0;
    for (int dy = -2; dy <= 2; ++dy) {
      for (int dx = -2; dx <= 2; ++dx) {
        const int u = x + dx * step, v = y + dy * step;
        if (!planes.inside(u, v)) continue;
        const std::size_t j = planes.place(u, v);
        const float apart = compared[j] - compared[i];
        const float noise = noise_spread * noise_spread * (planes.variance[i] + planes.variance[j]) +
                            1e-8F * compared[i] * compared[i] + 1e-20F;
        const float weight =
            spline[static_cast<std::size_t>(std::abs(dx))] * spline[static_cast<std::size_t>(std::abs(dy))] *
            std::exp(-difference(planes.guides[i], planes.guides[j]) - apart * apart / noise);
        sum += weight * planes.light[j];
        variance += weight * weight * planes.variance[j];
        weights += weight;
      }
    }
    next.light[i] = sum / weights;
    next.variance[i] = variance / (weights * weights);
  });
  planes.light = std::move(next.light);
  planes.variance = std::move(next.variance);
}

LinearImage denoise_by_wavelets(const TracedImage& traced) {
  Planes planes = planes_of(traced);
  estimate_variance(planes);
  for (int pass = 0; pass < passes; ++pass) smooth(planes, 1 << pass);
  LinearImage result{planes.width, planes.height, std::vector<float>(traced.light.rgb.size())};
  for_each_pixel(planes, [&](int x, int y, std::size_t i) {
    Eigen::Map<Vector3f>(result.pixel(x, y)) = planes.light[i].cwiseProduct(divisor(planes.guides[i]));
  });
  return result;
}

void check(const TracedImage& traced) {
  check_all_pixels(traced.light);
  for (const LinearImage* guide : {&traced.albedo, &traced.normal}) {
    check_all_pixels(*guide);
    check_equal("width of what guides the denoiser", guide->width, traced.light.width);
    check_equal("height of what guides the denoiser", guide->height, traced.light.height);
  }
}

}  // namespace

bool has_open_image_denoise() { return OpenImageDenoise::load() != nullptr; }

std::string denoiser_name(Denoiser denoiser) {
  if (denoiser == Denoiser::own) return "À-Trous wavelets of tremula";
  const auto library = OpenImageDenoise::load();
  return library ? "Open Image Denoise " + library->version() : "Open Image Denoise, which is not there";
}

LinearImage denoise(const TracedImage& traced, Denoiser denoiser) {
  check(traced);
  if (denoiser == Denoiser::own) return denoise_by_wavelets(traced);
  const auto library = OpenImageDenoise::load();
  if (!library)
    throw Error("Open Image Denoise is not there: no libOpenImageDenoise.so where the system looks");
  return library->denoise(traced);
}

}  // namespace tremula
