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

constexpr int reach = 5, patch = 1;    // pixels to either side: that count, that are compared
constexpr float least_albedo = 0.01F;  // light is divided by no less
constexpr float normal_spread = 0.6F, albedo_spread = 0.16F;  // differences that count as one
constexpr float noise_spread = 0.9F;                          // of light, in deviations of its noise
constexpr int band = 32;                                      // rows that are worked on at a time

// Numbers of pixels, row by row, each kind by itself: inner loops become vector code.
using Plane = std::vector<float>;

struct Planes {
  int width, height;
  std::array<Plane, 3> light;   // divided by the albedo
  std::array<Plane, 6> guides;  // normal and albedo, in units of their spread
  Plane divisors[3];
  Plane luminance, variance;  // of the light; variance of the noise in its luminance

  std::size_t place(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
};

float finite(float value) { return std::isfinite(value) ? value : 0.0F; }

template <class Function>
void for_each_row(const Planes& planes, const Function& function) {
  tbb::parallel_for(0, planes.height, function);
}

float luminance_of(const Planes& planes, const LinearImage& image, std::size_t i) {
  Vector3f divided;
  for (std::size_t c = 0; c < 3; ++c)
    divided[static_cast<int>(c)] = finite(image.rgb[3 * i + c]) / planes.divisors[c][i];
  return luminance(divided);
}

Planes planes_of(const TracedImage& traced) {
  Planes planes{traced.light.width, traced.light.height, {}, {}, {}, {}, {}};
  const std::size_t count = traced.light.rgb.size() / 3;
  for (Plane& plane : planes.light) plane.resize(count);
  for (Plane& plane : planes.guides) plane.resize(count);
  for (Plane& plane : planes.divisors) plane.resize(count);
  planes.luminance.resize(count);
  planes.variance.resize(count);
  for_each_row(planes, [&](int y) {
    for (std::size_t i = planes.place(0, y); i < planes.place(0, y + 1); ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        const float albedo = std::max(finite(traced.albedo.rgb[3 * i + c]), 0.0F);
        planes.guides[c][i] = finite(traced.normal.rgb[3 * i + c]) / normal_spread;
        planes.guides[3 + c][i] = albedo / albedo_spread;
        planes.divisors[c][i] = std::max(albedo, least_albedo);
        planes.light[c][i] = finite(traced.light.rgb[3 * i + c]) / planes.divisors[c][i];
      }
      planes.luminance[i] = luminance_of(planes, traced.light, i);
    }
  });
  return planes;
}

float difference(const Planes& planes, std::size_t a, std::size_t b) {
  float sum = 0;
  for (const Plane& guide : planes.guides) sum += (guide[a] - guide[b]) * (guide[a] - guide[b]);
  return sum;
}

struct Found {
  float variance, trust;
};

// What is left of a linear change, or of a straight edge along an axis, is nothing; of noise it is 36 times
// its variance (Immerkær 1996). It is trusted where the pixels are alike that it was taken of.
Found curvature(const Planes& planes, int x, int y) {
  float sum = 0, unlike = 0;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const std::size_t j =
          planes.place(std::clamp(x + dx, 0, planes.width - 1), std::clamp(y + dy, 0, planes.height - 1));
      sum += (dx == 0 ? 2.0F : -1.0F) * (dy == 0 ? 2.0F : -1.0F) * planes.luminance[j];
      unlike += difference(planes, planes.place(x, y), j) / 9;
    }
  }
  return {sum * sum / 36, std::exp(-unlike) + 1e-6F};
}

// The mean of what was found about the noise at the pixels around that are like this one.
void set_variance(Planes& planes, const std::vector<Found>& found, int around) {
  for_each_row(planes, [&](int y) {
    for (int x = 0; x < planes.width; ++x) {
      const std::size_t i = planes.place(x, y);
      float sum = 0, weights = 0;
      for (int v = std::max(y - around, 0); v <= std::min(y + around, planes.height - 1); ++v) {
        for (int u = std::max(x - around, 0); u <= std::min(x + around, planes.width - 1); ++u) {
          const std::size_t j = planes.place(u, v);
          const float weight = found[j].trust * (std::exp(-difference(planes, i, j)) + 1e-6F);
          sum += weight * found[j].variance;
          weights += weight;
        }
      }
      planes.variance[i] = sum / weights;
    }
  });
}

// Half of the samples are off from all of them by the deviation of the mean of all.
void estimate_variance(Planes& planes, const LinearImage& half) {
  std::vector<Found> found(planes.luminance.size());
  for_each_row(planes, [&](int y) {
    for (int x = 0; x < planes.width; ++x) {
      const std::size_t i = planes.place(x, y);
      if (half.rgb.empty()) {
        found[i] = curvature(planes, x, y);
      } else {
        const float apart = luminance_of(planes, half, i) - planes.luminance[i];
        found[i] = {apart * apart, 1};
      }
    }
  });
  set_variance(planes, found, half.rgb.empty() ? 3 : 1);
}

// e^-x for small x, 0 from 4 on.
float fading(float x) {
  const float left = std::max(1 - std::max(x, 0.0F) / 4, 0.0F);
  return left * left * left * left;
}

// Rows [begin, end) of the picture, with what is around them.
class Band {
 public:
  Band(const Planes& planes, int begin, int end) : planes_(planes), begin_(begin), end_(end) {
    const std::size_t size = static_cast<std::size_t>(end - begin) * static_cast<std::size_t>(planes.width);
    for (Plane& sum : sums_) sum.resize(size);
    weights_.resize(size);
    across_.resize(static_cast<std::size_t>(end - begin + 2 * patch) *
                   static_cast<std::size_t>(planes.width));
    row_.resize(static_cast<std::size_t>(planes.width + 2 * patch));
    total_.resize(static_cast<std::size_t>(planes.width));
    unlike_.resize(static_cast<std::size_t>(planes.width));
  }

  void add_all() {
    for (int dy = -reach; dy <= reach; ++dy)
      for (int dx = -reach; dx <= reach; ++dx) add(dx, dy);
  }

  void put(LinearImage& image) const {
    for (int y = begin_; y < end_; ++y) {
      for (int x = 0; x < planes_.width; ++x) {
        const std::size_t i = planes_.place(x, y), b = planes_.place(x, y - begin_);
        for (std::size_t c = 0; c < 3; ++c)
          image.rgb[3 * i + c] = sums_[c][b] / weights_[b] * planes_.divisors[c][i];
      }
    }
  }

 private:
  // Squared differences of the light beyond what noise makes, in squared deviations of it (Rousselle et al.
  // 2012, eq. 5).
  void find_distances(int dx, int dy) {
    const int width = planes_.width;
    for (int y = begin_ - patch; y < end_ + patch; ++y) {
      const int here = std::clamp(y, 0, planes_.height - 1),
                there = std::clamp(here + dy, 0, planes_.height - 1);
      const float* __restrict l = &planes_.luminance[planes_.place(0, here)], * __restrict m =
                                                                                  &planes_.luminance
                                                                                       [planes_.place(0,
                                                                                                      there)];
      const float* __restrict v = &planes_.variance[planes_.place(0, here)], * __restrict w =
                                                                                 &planes_
                                                                                      .variance[planes_.place(
                                                                                          0, there)];
      const int first = std::max(0, -dx), last = std::min(width, width - dx);  // where x + dx is inside
      float* __restrict row = row_.data() + patch;
      for (int x = first; x < last; ++x) {
        const float apart = l[x] - m[x + dx], both = v[x] + w[x + dx];
        const float floor = 1e-6F * l[x] * l[x] + 1e-12F;
        row[x] =
            (apart * apart - v[x] - std::min(v[x], w[x + dx])) / (noise_spread * noise_spread * both + floor);
      }
      for (int x = -patch; x < first; ++x) row[x] = row[first];
      for (int x = last; x < width + patch; ++x) row[x] = row[last - 1];
      float* __restrict sum =
          &across_[static_cast<std::size_t>(y - begin_ + patch) * static_cast<std::size_t>(width)];
      static_assert(patch == 1);
      for (int x = 0; x < width; ++x) sum[x] = row[x - 1] + row[x] + row[x + 1];
    }
  }

  void add(int dx, int dy) {
    const int width = planes_.width, first = std::max(0, -dx), last = std::min(width, width - dx);
    if (first >= last) return;
    find_distances(dx, dy);
    constexpr float share = 1.0F / ((2 * patch + 1) * (2 * patch + 1));
    for (int y = std::max(begin_, -dy); y < std::min(end_, planes_.height - dy); ++y) {
      const std::size_t from = planes_.place(0, y), to = planes_.place(0, y + dy),
                        out = planes_.place(0, y - begin_);
      float* __restrict total = total_.data();
      float* __restrict unlike = unlike_.data();
      float* __restrict weights = &weights_[out];
      std::fill(total_.begin(), total_.end(), 0.0F);
      std::fill(unlike_.begin(), unlike_.end(), 0.0F);
      for (int k = 0; k <= 2 * patch; ++k) {
        const float* sum = &across_[out + static_cast<std::size_t>(k) * static_cast<std::size_t>(width)];
        for (int x = 0; x < width; ++x) total[x] += share * sum[x];
      }
      for (const Plane& guide : planes_.guides) {
        const float *a = &guide[from], *b = &guide[to];
        for (int x = first; x < last; ++x) unlike[x] += (a[x] - b[x + dx]) * (a[x] - b[x + dx]);
      }
      for (int x = first; x < last; ++x) {
        total[x] = fading(total[x]) * fading(unlike[x]);
        weights[x] += total[x];
      }
      for (std::size_t c = 0; c < 3; ++c) {
        const float* light = &planes_.light[c][to];
        float* __restrict sum = &sums_[c][out];
        for (int x = first; x < last; ++x) sum[x] += total[x] * light[x + dx];
      }
    }
  }

  const Planes& planes_;
  int begin_, end_;
  std::array<Plane, 3> sums_;
  Plane weights_, across_, row_, total_, unlike_;
};

LinearImage denoise_by_non_local_means(const TracedImage& traced) {
  Planes planes = planes_of(traced);
  estimate_variance(planes, traced.half);
  LinearImage result{planes.width, planes.height, std::vector<float>(traced.light.rgb.size())};
  tbb::parallel_for(0, (planes.height + band - 1) / band, [&](int b) {
    Band rows(planes, b * band, std::min((b + 1) * band, planes.height));
    rows.add_all();
    rows.put(result);
  });
  return result;
}

void check(const TracedImage& traced) {
  check_all_pixels(traced.light);
  for (const LinearImage* guide : {&traced.albedo, &traced.normal, &traced.half}) {
    if (guide == &traced.half && guide->rgb.empty()) continue;
    check_all_pixels(*guide);
    check_equal("width of what guides the denoiser", guide->width, traced.light.width);
    check_equal("height of what guides the denoiser", guide->height, traced.light.height);
  }
}

}  // namespace

bool has_open_image_denoise() { return OpenImageDenoise::load() != nullptr; }

std::string denoiser_name(Denoiser denoiser) {
  if (denoiser == Denoiser::own) return "non-local means of tremula";
  const auto library = OpenImageDenoise::load();
  return library ? "Open Image Denoise " + library->version() : "Open Image Denoise, which is not there";
}

LinearImage denoise(const TracedImage& traced, Denoiser denoiser) {
  check(traced);
  if (denoiser == Denoiser::own) return denoise_by_non_local_means(traced);
  const auto library = OpenImageDenoise::load();
  if (!library)
    throw Error("Open Image Denoise is not there: no libOpenImageDenoise.so where the system looks");
  return library->denoise(traced);
}

}  // namespace tremula
