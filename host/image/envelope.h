// The envelope rule. At an edge, and behind curved mirrors, one rounding of the eye ray decides what a pixel shows. A
// picture in float32 may be off there by as much as the reference itself moves when its eye rays err by a few ulp.
// Knows pictures and bounds only: renderEnvelope of host/reference makes the bounds.
#pragma once

#include <cstddef>
#include <functional>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "image/image.h"

namespace turner {

struct Pixel {
  int x = 0, y = 0;
};

// The least and the most that the channels of a pixel become.
struct PixelBounds {
  glm::dvec3 least{0, 0, 0}, most{0, 0, 0};
};

// What float32 leaves of a colour of about 1 after a few bounces: less is no edge.
inline constexpr double kEnvelopeTolerance = 1e-5;

struct EnvelopeRule {
  double needed = 0;         // share of all pixels that differ by more than the tolerance in a channel, or hold a NaN
  double excused = 0;        // share of all pixels that need the rule and lie within their bounds
  size_t outside = 0;        // pixels that need the rule and are not excused by it
  double p99 = 0, p999 = 0;  // percentiles over all pixels that are not excused, by their largest channel error
};

// The pixels that need the rule, row by row. The pictures' windows are equal.
std::vector<Pixel> pixelsApart(const Image& picture, const Image& reference, double tolerance = kEnvelopeTolerance);

// The bounds of some pixels, by so many rays for each sample.
using BoundsOf = std::function<std::vector<PixelBounds>(std::span<const Pixel>, int rays)>;

// Rays for a sample that finds its bounds at an edge, and for one whose pixel those do not excuse: behind several
// curved mirrors few rays miss the extremes.
inline constexpr int kEnvelopeRays = 33, kDenseEnvelopeRays = 1025;

// Asks for the bounds of the pixels that need the rule; of those that they do not excuse, again with more rays.
EnvelopeRule applyEnvelope(const Image& picture, const Image& reference, const BoundsOf& boundsOf,
                           double tolerance = kEnvelopeTolerance);

}  // namespace turner
