// Solids: an outer closed surface, and the hollows in it.
#pragma once

#include <vector>

#include "geometry/nested_dielectrics/closed_surfaces.h"

namespace turner::nested_dielectrics {

struct Solid {
  std::vector<const Surface*> surfaces;  // the outer one, then those of its hollows
  const Surface& outer() const { return *surfaces[0]; }
};

// Surfaces that face inward are hollows in the smallest solid of their material whose bounds hold theirs; a hollow in
// no solid is none of anything. `surfaces` outlives the result.
std::vector<Solid> solidsOf(const std::vector<Surface>& surfaces);

// Calls visit(primitive, bounds) for all primitives of a solid, numbered spheres first, then triangles.
template <class Visit>
void forPrimitives(const Scene& scene, const Solid& solid, Visit&& visit) {
  for (const Surface* surface : solid.surfaces) {
    if (surface->sphere != kNoMedium) visit(surface->sphere, boundsFromEye(scene, scene.spheres[surface->sphere]));
    for (const uint32_t i : surface->triangles)
      visit(uint32_t(scene.spheres.size()) + i, boundsFromEye(scene, scene.triangles[i]));
  }
}

}  // namespace turner::nested_dielectrics
