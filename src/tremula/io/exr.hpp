// Pictures as light has them, in OpenEXR files: half floats, packed by ZIP, Rec. 709 primaries.
#pragma once

#include "tremula/render/linear_image.hpp"

#include <string>

namespace tremula {

bool has_exr();  // whether this was built with OpenEXR

// The bytes of a file with the channels R, G, B. What half floats do not hold is written as the nearest they
// do, and what is not a number as 0. Throws InputError for an image without all its pixels, Error where this
// was built without OpenEXR.
std::string encode_exr(const LinearImage& image);

// The same with the layers "albedo" (R, G, B) and "normal" (X, Y, Z), as denoisers and compositors know them.
std::string encode_exr(const TracedImage& traced);

}  // namespace tremula
