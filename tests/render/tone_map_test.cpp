#include "tremula/render/tone_map.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "tremula/base/color.hpp"
#include "tremula/base/error.hpp"
#include "tremula/render/atmosphere.hpp"

namespace tremula {
namespace {

constexpr ToneCurve curves[] = {ToneCurve::film, ToneCurve::neutral, ToneCurve::clipped};

ToneMapping with(ToneCurve curve) {
  ToneMapping mapping;
  mapping.curve = curve;
  return mapping;
}

Eigen::Vector3f grey(float level) { return Eigen::Vector3f::Constant(level); }

TEST(ToneMapped, KeepsBlackBlackAndMiddleGreyMiddleGreyByEveryCurve) {
  for (const ToneCurve curve : curves) {
    EXPECT_LT(tone_mapped(grey(0), with(curve)).maxCoeff(), 1e-6F);
    const Eigen::Vector3f middle = tone_mapped(grey(0.18F), with(curve));
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(middle[c], srgb_from_linear(0.18F), 1e-5F);
  }
}

TEST(ToneMapped, OfGreyIsGreyAndRisesUpToWhite) {
  for (const ToneCurve curve : curves) {
    float before = -1;
    for (float stops = -9.5F; stops < 6.5F; stops += 0.25F) {
      const Eigen::Vector3f shown = tone_mapped(grey(0.18F * std::exp2(stops)), with(curve));
      EXPECT_LT(shown.maxCoeff() - shown.minCoeff(), 1e-5F);
      EXPECT_LE(shown.maxCoeff(), 1);
      EXPECT_TRUE(shown.y() > before || before > 1 - 1e-6F) << stops;
      before = shown.y();
    }
    EXPECT_GT(before, 0.97F);
  }
}

TEST(ToneMapped, ByFilmIsSymmetricOnlyWhereItHasToBe) {
  ToneMapping mapping = with(ToneCurve::film);
  const auto code = [&](float stops) { return tone_mapped(grey(0.18F * std::exp2(stops)), mapping).y(); };
  // Ends of the 16.5 stops, and the steepness at grey.
  EXPECT_NEAR(code(-10), 0, 1e-5);
  EXPECT_NEAR(code(6.5F), 1, 1e-5);
  for (const double contrast : {1.6, 2.0, 3.5}) {
    mapping.contrast = contrast;
    EXPECT_NEAR((code(0.1F) - code(-0.1F)) / 0.2 * 16.5, contrast, 0.01 * contrast);
  }
}

TEST(ToneMapped, ByNeutralKeepsColoursThatAreNotBright) {
  for (const Eigen::Vector3f& color : {Eigen::Vector3f(0.7F, 0.1F, 0), Eigen::Vector3f(0.05F, 0.3F, 0.6F),
                                       Eigen::Vector3f(0.01F, 0.02F, 0.75F)}) {
    const Eigen::Vector3f shown = tone_mapped(color, with(ToneCurve::neutral));
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(linear_from_srgb(shown[c]), color[c], 1e-5F);
  }
}

TEST(ToneMapped, KeepsTheOrderOfChannelsAndFadesBrightColoursToWhite) {
  const Eigen::Vector3f orange(1, 0.45F, 0.1F);
  for (const ToneCurve curve : {ToneCurve::film, ToneCurve::neutral}) {
    const auto spread = [&](float level) {
      const Eigen::Vector3f shown = tone_mapped(level * orange, with(curve));
      EXPECT_GE(shown.x(), shown.y());
      EXPECT_GE(shown.y(), shown.z());
      return shown.x() - shown.z();
    };
    EXPECT_GT(spread(0.5F), 0.3F);
    EXPECT_LT(spread(50), 0.6F * spread(0.5F));
  }
}

TEST(ToneMapped, IsFiniteForAnyNumber) {
  constexpr float infinite = std::numeric_limits<float>::infinity();
  for (const ToneCurve curve : curves) {
    for (const float value : {std::numeric_limits<float>::quiet_NaN(), -1.0F, -infinite}) {
      EXPECT_LT(tone_mapped(grey(value), with(curve)).maxCoeff(), 1e-6F);
    }
    EXPECT_GT(tone_mapped(grey(infinite), with(curve)).minCoeff(), 0.99F);
    EXPECT_TRUE(tone_mapped({infinite, 0, std::numeric_limits<float>::quiet_NaN()}, with(curve)).allFinite());
  }
}

TEST(ToneMapped, ExposureIsAFactorAndWhiteIsShownWhite) {
  ToneMapping mapping;
  const Eigen::Vector3f color(0.2F, 0.4F, 0.3F);
  const Eigen::Vector3f once = tone_mapped(4 * color, mapping);
  mapping.exposure = 4;
  EXPECT_LT((tone_mapped(color, mapping) - once).norm(), 1e-6F);
  mapping.white = {1.2F, 1, 0.7F};
  const Eigen::Vector3f shown = tone_mapped(0.1F * mapping.white, mapping);
  EXPECT_LT(shown.maxCoeff() - shown.minCoeff(), 1e-5F);
  mapping.white *= 3;
  EXPECT_LT((tone_mapped(0.1F * Eigen::Vector3f(1.2F, 1, 0.7F), mapping) - shown).norm(), 1e-5F);
}

LinearImage ramp(int width, int height) {
  LinearImage image{width, height, {}};
  for (int i = 0; i < width * height; ++i)
    for (const float share : {1.0F, 0.5F, 0.2F})
      image.rgb.push_back(share * static_cast<float>(i) / static_cast<float>(width));
  return image;
}

TEST(ToneMap, IsToneMappedPixelByPixelAndRoundsToTheNearest) {
  const LinearImage image = ramp(37, 11);
  const Image shown = tone_map(image, {});
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
    const Eigen::Vector3f code = tone_mapped({image.rgb[i], image.rgb[i + 1], image.rgb[i + 2]}, {});
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(shown.rgb[i + static_cast<std::size_t>(c)], code[c] * 255, 0.501);
  }
}

TEST(ToneMap, WithDitherHasTheMeanOfWhatLiesBetweenTwoSteps) {
  LinearImage image{64, 64, std::vector<float>(3 * 64 * 64, linear_from_srgb(100.3F / 255))};
  ToneMapping mapping = with(ToneCurve::clipped);
  mapping.dither = true;
  double sum = 0;
  for (const std::uint8_t value : tone_map(image, mapping).rgb) {
    EXPECT_TRUE(value == 100 || value == 101);
    sum += value;
  }
  EXPECT_NEAR(sum / (3 * 64 * 64), 100.3, 0.02);
  image.rgb.assign(image.rgb.size(), 0);
  for (const std::uint8_t value : tone_map(image, mapping).rgb) EXPECT_EQ(value, 0);
}

TEST(ToneMap, RefusesNumbersOutOfRangeAndImagesWithoutPixels) {
  const LinearImage image = ramp(2, 2);
  EXPECT_THROW(tone_map({2, 2, {}}, {}), InputError);
  ToneMapping mapping;
  mapping.exposure = 0;
  EXPECT_THROW(tone_map(image, mapping), InputError);
  mapping = {};
  mapping.white.y() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(tone_map(image, mapping), InputError);
  mapping = {};
  mapping.contrast = 10;
  EXPECT_THROW(tone_map(image, mapping), InputError);
}

TEST(ExposureOf, PutsAGreyCardAndTheSkyAtEqualStopsFromOneAboveMiddleGrey) {
  for (const double elevation : {0.05, 0.5, 1.2}) {
    DaylightSettings settings;
    settings.sun_elevation = elevation;
    const Daylight light(settings);
    const double exposure = exposure_of(light);
    const double card = exposure * luminance(light.level_irradiance()) * 0.18 / std::numbers::pi;
    const double sky = exposure * luminance(light.sky_irradiance()) / std::numbers::pi;
    EXPECT_NEAR(std::log2(card / 0.36), -std::log2(sky / 0.36), 1e-5);
    EXPECT_NEAR(exposure_of(light, 1) / exposure, 2, 1e-9);
  }
}

// x = 0.33242, y = 0.34743 (CIE 15).
TEST(DaylightWhite, HasTheChromaticityOfD55) {
  Eigen::Matrix3d xyz_from_srgb;
  xyz_from_srgb << 0.4124, 0.3576, 0.1805, 0.2126, 0.7152, 0.0722, 0.0193, 0.1192, 0.9505;
  const Eigen::Vector3d xyz = xyz_from_srgb * daylight_white.cast<double>();
  EXPECT_NEAR(xyz.x() / xyz.sum(), 0.33242, 1e-3);
  EXPECT_NEAR(xyz.y() / xyz.sum(), 0.34743, 1e-3);
}

TEST(ExposureOf, IsInverseToTheLight) {
  EXPECT_NEAR(exposure_of(Eigen::Vector3f(2, 2, 2)) / exposure_of(Eigen::Vector3f(4, 4, 4)), 2, 1e-6);
}

}  // namespace
}  // namespace tremula
