// Where a pixel's samples lie, and the eye rays through them.
#pragma once

#include <glm/vec2.hpp>

#include "image/settings.h"
#include "reference/precision.h"
#include "scene/scene.h"

namespace turner::reference {

// Where the sample of cell (i, j) of pixel (x, y) lies, in pixels from the top left of the picture. Both renderers
// compute it in integers, fractions of 2^-24, so that they look through the very same points.
glm::dvec2 samplePosition(int x, int y, int i, int j, const RenderSettings& settings);

// The image plane at distance 1 from the eye.
class ImagePlane {
 public:
  ImagePlane(const Camera& camera, const RenderSettings& settings);

  // The unit direction from the eye through a position in pixels.
  dvec3 directionThrough(const glm::dvec2& position) const;

 private:
  dvec3 forward, right, up;  // right and up reach from the centre to the height of the upper edge
  double width, height;      // pixels
};

}  // namespace turner::reference
