// Pictures that must be equal, and made of numbers.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "image/image.h"

namespace turner::hard {

// How many values differ in a bit.
inline size_t differingValues(const Image& a, const Image& b) {
  size_t differing = a.rgb.size() != b.rgb.size();
  for (size_t i = 0; i < std::min(a.rgb.size(), b.rgb.size()); ++i)
    differing += std::bit_cast<uint32_t>(a.rgb[i]) != std::bit_cast<uint32_t>(b.rgb[i]);
  return differing;
}

inline size_t notFiniteValues(const Image& image) {
  return size_t(std::count_if(image.rgb.begin(), image.rgb.end(), [](float value) { return !std::isfinite(value); }));
}

}  // namespace turner::hard
