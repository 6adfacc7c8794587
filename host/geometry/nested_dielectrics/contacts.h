// Which solids of glass touch, overlap or lie in one another, or lie on something opaque.
#pragma once

#include <vector>

#include "geometry/nested_dielectrics/solids.h"
#include "scene/scene.h"

namespace turner::nested_dielectrics {

// Sets `marked` of each solid an interface of which meets one of another solid, or that lies in the bounds of a mesh.
void markMeeting(const Scene& scene, const std::vector<Solid>& solids, std::vector<bool>& marked);

// Sets `marked` of each solid in whose face something opaque lies, so that only rounding tells them apart.
void markOnOpaque(const Scene& scene, const std::vector<Solid>& solids, std::vector<bool>& marked);

}  // namespace turner::nested_dielectrics
