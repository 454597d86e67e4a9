#include "tremula/render/denoise.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <random>

#include <tbb/global_control.h>

#include "tremula/base/error.hpp"
#include "tremula/render/open_image_denoise.hpp"

namespace tremula {
namespace {

using Eigen::Vector3f;

LinearImage filled(int width, int height, const Vector3f& color) {
  LinearImage image{width, height, {}};
  for (int i = 0; i < width * height; ++i)
    image.rgb.insert(image.rgb.end(), {color.x(), color.y(), color.z()});
  return image;
}

// A ball of two colours before a sky that brightens upwards, on a ground with squares; half of the ground in
// a soft shadow that no guide knows of.
TracedImage still_life(int size) {
  TracedImage scene{filled(size, size, Vector3f::Zero()),
                    filled(size, size, Vector3f::Ones()),
                    filled(size, size, Vector3f::Zero()),
                    {}};
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      const float u = 2 * (static_cast<float>(x) + 0.5F) / static_cast<float>(size) - 1;
      const float v = 1 - 2 * (static_cast<float>(y) + 0.5F) / static_cast<float>(size);
      Vector3f normal = Vector3f::Zero(), albedo = Vector3f::Ones(),
               light = Vector3f(0.5F, 0.7F, 1) * (1 + v);
      if (u * u + v * v < 0.36F) {
        normal = Vector3f(u, v, std::sqrt(0.36F - u * u - v * v)) / 0.6F;
        albedo = std::sin(12 * u) > 0 ? Vector3f(0.1F, 0.4F, 0.05F) : Vector3f(0.6F, 0.3F, 0.2F);
        light = albedo * (0.3F + 2 * std::max(normal.dot(Vector3f(0.5F, 0.6F, 0.62F)), 0.0F));
      } else if (v < -0.3F) {
        normal = Vector3f::UnitY();
        albedo = (x / 8 + y / 8) % 2 == 0 ? Vector3f(0.3F, 0.3F, 0.3F) : Vector3f(0.05F, 0.06F, 0.05F);
        light = albedo * (0.4F + 1.5F / (1 + std::exp(-30 * (u + 0.3F * v))));
      }
      Eigen::Map<Vector3f>(scene.light.pixel(x, y)) = light;
      Eigen::Map<Vector3f>(scene.albedo.pixel(x, y)) = albedo;
      Eigen::Map<Vector3f>(scene.normal.pixel(x, y)) = normal;
    }
  }
  return scene;
}

// As of so many samples, each of which is bright one time in four; not the sky, which is seen as it is.
TracedImage with_noise(TracedImage scene, int samples) {
  std::mt19937 random(7);
  scene.half = scene.light;
  const auto share_bright = [&](int count) {
    int bright = 0;
    for (int s = 0; s < count; ++s) bright += random() % 4 == 0 ? 1 : 0;
    return 4 * static_cast<float>(bright) / static_cast<float>(count);
  };
  for (std::size_t i = 0; i < scene.light.rgb.size(); i += 3) {
    if (scene.normal.rgb[i] == 0 && scene.normal.rgb[i + 1] == 0 && scene.normal.rgb[i + 2] == 0) continue;
    const float one = share_bright(samples / 2), both = (one + share_bright(samples / 2)) / 2;
    for (std::size_t c = 0; c < 3; ++c) {
      scene.light.rgb[i + c] *= both;
      scene.half.rgb[i + c] *= one;
    }
  }
  return scene;
}

double mean_square(const LinearImage& a, const LinearImage& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.rgb.size(); ++i) sum += std::pow(a.rgb[i] - b.rgb[i], 2);
  return sum / static_cast<double>(a.rgb.size());
}

double sum_of(const LinearImage& image) {
  double sum = 0;
  for (const float value : image.rgb) sum += value;
  return sum;
}

TEST(Denoise, LeavesWhatIsEvenAsItIs) {
  TracedImage scene{
      filled(40, 30, {0.2F, 0.5F, 3}), filled(40, 30, {0.5F, 0.2F, 0.9F}), filled(40, 30, {0, 0, 1}), {}};
  const LinearImage result = denoise(scene);
  for (std::size_t i = 0; i < result.rgb.size(); ++i)
    EXPECT_NEAR(result.rgb[i], scene.light.rgb[i], 1e-5F * scene.light.rgb[i]);
}

TEST(Denoise, LeavesAPictureWithoutNoiseAlmostAsItIs) {
  const TracedImage scene = still_life(96);
  EXPECT_LT(mean_square(denoise(scene), scene.light), 2e-5);
}

TEST(Denoise, TakesMostOfTheErrorAwayAndLessThanOnePerCentOfTheLight) {
  const TracedImage truth = still_life(128);
  for (const int samples : {4, 16, 64}) {
    const TracedImage noisy = with_noise(truth, samples);
    const LinearImage result = denoise(noisy);
    const double before = mean_square(noisy.light, truth.light), after = mean_square(result, truth.light);
    EXPECT_LT(after, 0.1 * before) << samples;
    EXPECT_NEAR(sum_of(result) / sum_of(noisy.light), 1, 0.01) << samples;
  }
}

TEST(Denoise, GuessesTheNoiseWhereHalfOfTheSamplesIsNotKnown) {
  const TracedImage truth = still_life(128);
  TracedImage noisy = with_noise(truth, 16);
  const double knowing = mean_square(denoise(noisy), truth.light);
  noisy.half = {};
  const double guessing = mean_square(denoise(noisy), truth.light);
  EXPECT_LT(guessing, 0.2 * mean_square(noisy.light, truth.light));
  EXPECT_LT(guessing, 3 * knowing);
}

// Squares of light and shadow, which only the light knows of.
TEST(Denoise, KeepsShadowsThatNoGuideKnowsOf) {
  TracedImage scene{filled(96, 96, Vector3f::Zero()), filled(96, 96, {0.4F, 0.3F, 0.2F}),
                    filled(96, 96, {0, 0, 1})};
  for (int y = 0; y < 96; ++y) {
    for (int x = 0; x < 96; ++x)
      Eigen::Map<Vector3f>(scene.light.pixel(x, y)).setConstant((x / 6 + y / 6) % 2 == 0 ? 1.0F : 0.1F);
  }
  for (const int samples : {64, 256}) {
    const TracedImage noisy = with_noise(scene, samples);
    const LinearImage result = denoise(noisy);
    EXPECT_LT(mean_square(result, scene.light), 0.75 * mean_square(noisy.light, scene.light)) << samples;
    std::array<double, 2> sums = {}, counts = {};  // of light and shadow, on either side of an edge
    for (int y = 0; y < 96; ++y) {
      for (int x = 0; x < 96; ++x) {
        if (x % 6 != 0 && x % 6 != 5) continue;
        const auto shadow = static_cast<std::size_t>((x / 6 + y / 6) % 2);
        sums[shadow] += *result.pixel(x, y);
        ++counts[shadow];
      }
    }
    EXPECT_NEAR(sums[0] / counts[0], 1, 0.1) << samples;
    EXPECT_NEAR(sums[1] / counts[1], 0.1, 0.03) << samples;
  }
}

TEST(Denoise, KeepsAnEdgeOfEitherGuideSharp) {
  for (const bool by_normal : {true, false}) {
    TracedImage scene{
        filled(64, 32, Vector3f::Zero()), filled(64, 32, {0.5F, 0.5F, 0.5F}), filled(64, 32, {0, 0, 1}), {}};
    for (int y = 0; y < 32; ++y) {
      for (int x = 0; x < 64; ++x) {
        const bool right = x >= 32;
        if (by_normal && right) Eigen::Map<Vector3f>(scene.normal.pixel(x, y)) = Vector3f::UnitX();
        if (!by_normal && right) Eigen::Map<Vector3f>(scene.albedo.pixel(x, y)) = Vector3f(0.1F, 0.1F, 0.1F);
        Eigen::Map<Vector3f>(scene.light.pixel(x, y)).setConstant(right ? 0.2F : 0.1F);
      }
    }
    const LinearImage result = denoise(with_noise(scene, 8));
    double left = 0, right = 0;
    for (int y = 0; y < 32; ++y) {
      left += *result.pixel(31, y) / 32;
      right += *result.pixel(32, y) / 32;
    }
    EXPECT_NEAR(left, 0.1, 0.02) << by_normal;
    EXPECT_NEAR(right, 0.2, 0.03) << by_normal;
  }
}

TEST(Denoise, IsTheSameOnAnyNumberOfThreads) {
  const TracedImage noisy = with_noise(still_life(64), 8);
  const LinearImage many = denoise(noisy);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(denoise(noisy).rgb, many.rgb);
}

TEST(Denoise, MakesWhatIsNotFiniteFinite) {
  TracedImage scene = with_noise(still_life(32), 8);
  scene.light.pixel(5, 5)[0] = std::numeric_limits<float>::quiet_NaN();
  scene.light.pixel(9, 20)[1] = std::numeric_limits<float>::infinity();
  scene.normal.pixel(20, 20)[2] = std::numeric_limits<float>::quiet_NaN();
  scene.albedo.pixel(16, 16)[0] = -1;
  for (const float value : denoise(scene).rgb) EXPECT_TRUE(std::isfinite(value));
}

TEST(Denoise, RefusesGuidesOfAnotherSize) {
  TracedImage scene = still_life(16);
  scene.normal = filled(15, 16, Vector3f::Zero());
  EXPECT_THROW(denoise(scene), InputError);
  scene = still_life(16);
  scene.half = filled(16, 15, Vector3f::Zero());
  EXPECT_THROW(denoise(scene), InputError);
  scene = still_life(16);
  scene.albedo.rgb.pop_back();
  EXPECT_THROW(denoise(scene), InputError);
}

TEST(OpenImageDenoise, IsAnErrorOrADenoiserButNeverACrash) {
  const TracedImage truth = still_life(64), noisy = with_noise(truth, 8);
  if (has_open_image_denoise()) {
    EXPECT_LT(mean_square(denoise(noisy, Denoiser::open_image_denoise), truth.light),
              mean_square(noisy.light, truth.light));
  } else {
    EXPECT_THROW(denoise(noisy, Denoiser::open_image_denoise), Error);
    EXPECT_EQ(denoiser_name(Denoiser::open_image_denoise), "Open Image Denoise, which is not there");
  }
  EXPECT_EQ(OpenImageDenoise::load("/no/such/library.so"), nullptr);
}

// A library with its functions and constants of ours (open_image_denoise_stub.cpp): the output is colour plus
// albedo.
TEST(OpenImageDenoise, IsCalledByItsInterfaceOfVersionsOneAndTwo) {
  TracedImage scene = still_life(16);
  for (const std::string library : {TREMULA_OIDN_STUB_1, TREMULA_OIDN_STUB_2}) {
    const auto loaded = OpenImageDenoise::load(library);
    ASSERT_NE(loaded, nullptr) << library;
    EXPECT_EQ(loaded->version(), library == TREMULA_OIDN_STUB_1 ? "1.4.3" : "2.3.1");
    const LinearImage result = loaded->denoise(scene);
    for (std::size_t i = 0; i < result.rgb.size(); ++i)
      EXPECT_EQ(result.rgb[i], scene.light.rgb[i] + scene.albedo.rgb[i]);
    try {
      loaded->denoise({filled(13, 1, Vector3f::Zero()),
                       filled(13, 1, Vector3f::Zero()),
                       filled(13, 1, Vector3f::Zero()),
                       {}});
      FAIL();
    } catch (const Error& error) {
      EXPECT_STREQ(error.what(), "Open Image Denoise fails: thirteen is too much");
    }
  }
}

}  // namespace
}  // namespace tremula
