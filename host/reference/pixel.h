// The value of a pixel: the mean of its samples, or the bounds of that mean where eye rays err.
#pragma once

#include "image/envelope.h"
#include "image/settings.h"
#include "reference/precision.h"
#include "reference/samples.h"
#include "reference/whitted.h"

namespace turner::reference {

// The mean of the pixel's samples.
dvec3 pixelColor(Whitted& whitted, const ImagePlane& plane, const RenderSettings& settings, int x, int y);

// The means of the samples' least and largest values, each by so many rays that err by up to 4 ulp of a float near 1 in
// each component of their direction.
PixelBounds pixelBounds(Whitted& whitted, const ImagePlane& plane, const RenderSettings& settings, int x, int y,
                        int rays);

}  // namespace turner::reference
