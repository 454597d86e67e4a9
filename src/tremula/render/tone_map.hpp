// From light to what a screen shows: exposure, a curve like that of film, sRGB in 8 bits.
#pragma once

#include "tremula/render/daylight.hpp"
#include "tremula/render/image.hpp"
#include "tremula/render/linear_image.hpp"

namespace tremula {

enum class ToneCurve {
  film,     // AgX (Sobotka 2022): 16.5 stops about middle grey, bright colours fade to white
  neutral,  // Khronos PBR Neutral (2024): colours as they are up to 0.76, what is brighter fades to white
  clipped,  // as it is up to white
};

// Daylight of 5500 K (CIE D55), which films for daylight are balanced for: noon's sun and sky together.
inline const Eigen::Vector3f daylight_white(1.104F, 0.987F, 0.823F);

struct ToneMapping {
  double exposure = 1;  // what light is multiplied by, above 0; 0.18 is then middle grey
  ToneCurve curve = ToneCurve::film;
  double contrast = 2.5;              // of film: steepness at middle grey, 1.5 … 4; AgX by itself has 2
  double saturation = 1.25;           // of film, 0 … 2; AgX by itself has 1
  Eigen::Vector3f white = {1, 1, 1};  // the light that shall look white, whatever its brightness; above 0
  bool dither = false;                // breaks up steps in smooth skies by a pattern that stays where it is
};

// The exposure that shows this daylight as one expects it, the same for every picture of a film: what is as
// bright as the geometric mean of a grey card on the level ground (18 %, under sun and sky) and of the sky on
// average comes out a stop above middle grey, as leaves are darker than the card; and `stops` brighter.
double exposure_of(const Daylight& light, double stops = 0);

// The same where the same radiance comes from everywhere.
double exposure_of(const Eigen::Vector3f& uniform_sky, double stops = 0);

// One colour: linear sRGB, as it is in the light, to sRGB 0–1. Negative and not-a-number count as black,
// infinite as white.
Eigen::Vector3f tone_mapped(const Eigen::Vector3f& light, const ToneMapping& mapping);

// The picture on the screen. Throws InputError for an image without all its pixels and for numbers out of
// range.
Image tone_map(const LinearImage& image, const ToneMapping& mapping);

}  // namespace tremula
