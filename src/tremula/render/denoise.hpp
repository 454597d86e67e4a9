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

// "À-Trous wavelets of tremula", "Open Image Denoise 2.1.0": with what denoise works, for reports.
std::string denoiser_name(Denoiser denoiser);

// The light, with less noise. Our own: edge-avoiding À-Trous wavelets (Dammertz et al. 2010) on the light
// divided by the albedo, so that textures stay. Pixels count for each other as far as normals and albedo are
// alike and the light differs by no more than its noise, which is estimated from the picture. The same bytes
// on any number of threads. What is not finite becomes finite. Throws InputError unless light, albedo and
// normal are images of one size, and Error where the denoiser that was asked for is not there or fails.
LinearImage denoise(const TracedImage& traced, Denoiser denoiser = Denoiser::own);

}  // namespace tremula
