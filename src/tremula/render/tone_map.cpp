#include "tremula/render/tone_map.hpp"

#include "tremula/base/color.hpp"
#include "tremula/base/error.hpp"
#include "tremula/base/number_text.hpp"
#include "tremula/render/atmosphere.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <tbb/parallel_for.h>
#include <Eigen/LU>

namespace tremula {
namespace {

constexpr double middle_grey = 0.18;
constexpr float brightest = 1e9F;  // beyond it all is white

struct Film {
  Eigen::Matrix3f inset, outset;
  float slope, toe_scale, shoulder_scale, grey_code, saturation;

  explicit Film(const ToneMapping& mapping);
  float curve(float light) const;
  Eigen::Vector3f operator()(const Eigen::Vector3f& light) const;
};

constexpr float stops_below = 10, stops_above = 6.5F;  // of middle grey
constexpr float toe_power = 3, shoulder_power = 3.25F;
constexpr float grey_place = stops_below / (stops_below + stops_above);

// Primaries are drawn in, so that what is too bright for one of them spills into the others, and out again.
// Matrix of B. Wrensch 2023 for linear sRGB, its rows made to add to 1: grey stays grey.
Film::Film(const ToneMapping& mapping)
    : slope(static_cast<float>(mapping.contrast)),
      grey_code(srgb_from_linear(static_cast<float>(middle_grey))),
      saturation(static_cast<float>(mapping.saturation)) {
  Eigen::Matrix3d in;
  in << 0.842479062253094, 0.0784335999999992, 0.0792237451477643, 0.0423282422610123, 0.878468636469772,
      0.0791661274605434, 0.0423756549057051, 0.0784336, 0.879142973793104;
  for (int r = 0; r < 3; ++r) in.row(r) /= in.row(r).sum();
  inset = in.cast<float>();
  outset = in.inverse().cast<float>();
  // So that the curve ends at 0 and at 1: a line through grey, bent by 1 / (1 + (line / scale)^p)^(1/p).
  const auto scale = [&](float run, float rise, float power) {
    const float line = slope * run;
    return line / std::pow(std::pow(line / rise, power) - 1, 1 / power);
  };
  toe_scale = scale(grey_place, grey_code, toe_power);
  shoulder_scale = scale(1 - grey_place, 1 - grey_code, shoulder_power);
}

float Film::curve(float light) const {
  const float stops = std::log2(std::max(light, 1e-10F) / static_cast<float>(middle_grey));
  const float place = std::clamp((stops + stops_below) / (stops_below + stops_above), 0.0F, 1.0F);
  const float line = slope * (place - grey_place);
  const bool toe = line < 0;
  const float scale = toe ? toe_scale : shoulder_scale, power = toe ? toe_power : shoulder_power;
  return std::clamp(grey_code + line / std::pow(1 + std::pow(std::abs(line) / scale, power), 1 / power), 0.0F,
                    1.0F);
}

Eigen::Vector3f Film::operator()(const Eigen::Vector3f& light) const {
  const Eigen::Vector3f inside = inset * light;
  const Eigen::Vector3f code =
      outset * Eigen::Vector3f(curve(inside.x()), curve(inside.y()), curve(inside.z()));
  const float grey = luminance(code);
  return (Eigen::Vector3f::Constant(grey) + saturation * (code - Eigen::Vector3f::Constant(grey)))
      .cwiseMax(0.0F)
      .cwiseMin(1.0F);
}

Eigen::Vector3f encoded(const Eigen::Vector3f& linear) {
  return linear.unaryExpr([](float channel) { return srgb_from_linear(std::clamp(channel, 0.0F, 1.0F)); });
}

// The specification's numbers, without its first step: that takes off what a surface of a refractive index
// of 1.5 reflects of a white surrounding, and colours here are no base colours.
Eigen::Vector3f neutral(Eigen::Vector3f color) {
  constexpr float start = 0.8F - 0.04F, desaturation = 0.15F, room = 1 - start;
  const float peak = color.maxCoeff();
  if (peak < start) return color;
  const float lower = 1 - room * room / (peak + room - start);
  color *= lower / peak;
  const float fade = 1 - 1 / (desaturation * (peak - lower) + 1);
  return color + fade * (Eigen::Vector3f::Constant(lower) - color);
}

class Mapper {
 public:
  explicit Mapper(const ToneMapping& mapping) : curve_(mapping.curve), film_(mapping) {
    const Eigen::Vector3f& white = mapping.white;
    gain_ = static_cast<float>(mapping.exposure) * luminance(white) * white.cwiseInverse();
  }
  Eigen::Vector3f operator()(const Eigen::Vector3f& light) const {
    const Eigen::Vector3f color = light.cwiseProduct(gain_).unaryExpr(
        [](float channel) { return channel > 0 ? std::min(channel, brightest) : 0.0F; });
    switch (curve_) {
      case ToneCurve::film:
        return film_(color);
      case ToneCurve::neutral:
        return encoded(neutral(color));
      case ToneCurve::clipped:
        break;
    }
    return encoded(color);
  }

 private:
  ToneCurve curve_;
  Film film_;
  Eigen::Vector3f gain_;
};

void check(const char* what, double found, double low, double high, const char* wanted) {
  if (found >= low && found <= high) return;
  throw InputError(what, number_text(found), wanted);
}

void check(const ToneMapping& mapping) {
  check("exposure", mapping.exposure, 1e-12, 1e12, "1e-12 to 1e12");
  check("contrast", mapping.contrast, 1.5, 4, "1.5 to 4");
  check("saturation", mapping.saturation, 0, 2, "0 to 2");
  for (const float channel : mapping.white)
    check("white", channel, 1e-6, 1e6, "a colour of light, each of its numbers above 0");
}

// Interleaved gradient noise (Jimenez 2014), in [0, 1).
float pattern(int x, int y) {
  const auto fraction = [](float v) { return v - std::floor(v); };
  return fraction(52.9829189F *
                  fraction(0.06711056F * static_cast<float>(x) + 0.00583715F * static_cast<float>(y)));
}

double exposure_for(double card, double sky, double stops) {
  const double key = std::sqrt(std::max(card, 1e-9) * std::max(sky, 1e-9));
  return std::exp2(1 + stops) * middle_grey / key;
}

}  // namespace

double exposure_of(const Daylight& light, double stops) {
  constexpr double pi = std::numbers::pi;
  return exposure_for(double{luminance(light.level_irradiance())} * middle_grey / pi,
                      double{luminance(light.sky_irradiance())} / pi, stops);
}

double exposure_of(const Eigen::Vector3f& uniform_sky, double stops) {
  return exposure_for(double{luminance(uniform_sky)} * middle_grey, luminance(uniform_sky), stops);
}

Eigen::Vector3f tone_mapped(const Eigen::Vector3f& light, const ToneMapping& mapping) {
  check(mapping);
  return Mapper(mapping)(light);
}

Image tone_map(const LinearImage& image, const ToneMapping& mapping) {
  check(mapping);
  check_all_pixels(image);
  Image shown{image.width, image.height, std::vector<std::uint8_t>(image.rgb.size())};
  const Mapper map(mapping);
  tbb::parallel_for(0, image.height, [&](int y) {
    for (int x = 0; x < image.width; ++x) {
      const Eigen::Vector3f code = map(Eigen::Vector3f(Eigen::Map<const Eigen::Vector3f>(image.pixel(x, y))));
      const float rounding = mapping.dither ? pattern(x, y) : 0.5F;
      for (int c = 0; c < 3; ++c)
        shown.pixel(x, y)[c] = static_cast<std::uint8_t>(std::min(code[c] * 255 + rounding, 255.0F));
    }
  });
  return shown;
}

}  // namespace tremula
