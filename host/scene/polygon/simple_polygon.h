// Cuts outlines that nowhere touch themselves into triangles: the usual case, in a fraction of the time that a library
// for all cases takes. Points of the plane come in, indices of points go out; knows nothing of space and corners.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "scene/polygon/plane.h"

namespace turner {

// Whether the edges of a closed outline meet at common ends only. No point may equal its successor.
bool isSimple(std::span<const PlanePoint> outline);

// A simple outline of n points as n - 2 triangles over all of its points, wound as it is, none without area: the
// constrained Delaunay triangulation, but for ties and near ties. Empty if rounding beyond what orientation() can bear
// got in the way.
std::vector<std::array<uint32_t, 3>> triangulateSimple(std::span<const PlanePoint> outline);

}  // namespace turner
