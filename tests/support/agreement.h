// Whether two tracers of the benchmark have done the same work: a speed beside another picture is worth nothing.
#pragma once

#include <string>
#include <vector>

#include "image/image.h"
#include "image/settings.h"

namespace turner::test {

// Ray counts may differ by this share of each kind that has at least kFewRays.
inline constexpr double kMostCountError = 0.005;
inline constexpr uint64_t kFewRays = 1000;
// Of the pixels this share may differ by more than kPixelTolerance in a channel: at edges, where rounding decides.
inline constexpr double kMostBadPixels = 0.03;
inline constexpr double kPixelTolerance = 1e-3;

// What one tracer has made of the scene.
struct TracedPicture {
  const Image& image;
  RayCounts rays;
};

// The share of pixels that differ by more than kPixelTolerance in a channel, or hold a NaN. Throws InputError if the
// pictures differ in size.
double badPixels(const Image& turner, const Image& peer);

// A sentence for every way in which `peer` differs too much from `turner`; none: they agree. Throws InputError if the
// pictures differ in size.
std::vector<std::string> disagreements(const TracedPicture& turner, const TracedPicture& peer);

}  // namespace turner::test
