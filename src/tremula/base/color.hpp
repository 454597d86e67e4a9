// Colours as files and screens have them (sRGB, IEC 61966-2-1) and as light adds (linear).
#pragma once

#include <cmath>

namespace tremula {

template <class Number>
Number linear_from_srgb(Number channel) {  // 0–1
  return channel <= Number(0.04045) ? channel / Number(12.92)
                                    : std::pow((channel + Number(0.055)) / Number(1.055), Number(2.4));
}

template <class Number>
Number srgb_from_linear(Number channel) {  // 0–1
  return channel <= Number(0.0031308) ? Number(12.92) * channel
                                      : Number(1.055) * std::pow(channel, 1 / Number(2.4)) - Number(0.055);
}

}  // namespace tremula
