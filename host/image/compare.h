// Says how far two pictures differ. Knows images only.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "image/image.h"

namespace turner {

// The difference A - B over linear R, G, B. Pixels with a NaN or an infinity in A or B are counted in nan or inf and as
// bad pixels, and are left out of all other figures.
struct Comparison {
  double rmse = 0;                    // over all channels
  double relRmse = 0;                 // sqrt(mean((a-b)^2 / (b^2 + 0.01)))
  double mae = 0;                     // mean absolute error over all channels
  double max = 0;                     // largest channel error
  double meanSigned = 0;              // mean of a - b over all channels: bias
  double p50 = 0, p99 = 0, p999 = 0;  // percentiles (nearest rank) over pixels by their largest channel error
  double badPixels = 0;               // share of pixels whose largest channel error exceeds the threshold
  uint64_t nan = 0, inf = 0;          // pixels with one or more of them, in A or B
  int width = 0, height = 0;          // of the compared window
};

// Throws InputError if display or data windows differ.
Comparison compareImages(const Image& a, const Image& b, double threshold);

// |A - B| per channel.
Image errorImage(const Image& a, const Image& b);

// Bounds a comparison may not exceed; negative: no such bound.
struct ErrorBounds {
  double rmse = -1, max = -1, badPixels = -1;
};

// A sentence for every bound that is set and does not hold; none: all hold. A NaN or an infinity breaks every bound.
std::vector<std::string> brokenBounds(const Comparison& comparison, const ErrorBounds& bounds);

}  // namespace turner
