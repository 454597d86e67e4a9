// Less noise in a traced picture, guided by what is seen in it.
#pragma once

#include "tremula/render/linear_image.hpp"

#include <string>

namespace tremula {

enum class Denoiser {
  own,                 // the one below, which is always there
  open_image_denoise,  // Intel's library, where the user has it: libOpenImageDenoise.so is looked for at run
                       // time
};

bool has_open_image_denoise();

// "non-local means of tremula", "Open Image Denoise 2.1.0": with what denoise works, for reports.
std::string denoiser_name(Denoiser denoiser);

// The light, with less noise. Our own: non-local means (Rousselle et al. 2012 and 2013) on the light divided
// by the albedo, so that textures stay. Pixels count for each other as far as normals and albedo are alike
// and the light around them differs by no more than its noise. That is known from half of the samples;
// without them it is estimated from the picture, which takes leaves and their shadows for noise too. The same
// bytes on any number of threads. What is not finite becomes finite. Throws InputError unless the images of
// what was traced are of one size, and Error where the denoiser that was asked for is not there or fails.
LinearImage denoise(const TracedImage& traced, Denoiser denoiser = Denoiser::own);

}  // namespace tremula
