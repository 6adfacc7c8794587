// Nested dielectrics: the media that a ray is in, and what coincident interfaces make of them.
// Schmidt and Budge, "Simple nested dielectrics in ray traced images", Journal of Graphics Tools 7(2), 2002.
#pragma once

#include <cstdint>
#include <vector>

#include "reference/aggregate.h"

namespace turner::reference {

// The overlapping media that a ray is in, ascending by priority: the last one is active. Indices into
// NestedDielectrics.
using Media = std::vector<uint32_t>;

// A ray's way through all interfaces that coincide with a hit.
struct Crossing {
  Media beyond;         // what the ray is in behind them
  double etaRatio = 1;  // the index of refraction behind them over that before them
  bool hidden = false;  // the same glass before and behind: no interface is to be seen
};

// The ray is in `media` and hits the surface.
Crossing crossInterfaces(const Aggregate& aggregate, const Ray& ray, const Hit& hit, const Surface& surface,
                         const Media& media);

}  // namespace turner::reference
