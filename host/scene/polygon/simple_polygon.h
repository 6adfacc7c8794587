// Cuts outlines that nowhere touch themselves into triangles: the usual case, in a fraction of the time that a library
// for all cases takes. Points of the plane come in, indices of points go out; knows nothing of corners. `Outline` is
// FlatOutline or TiltedOutline.
#pragma once

#include <vector>

#include "scene/polygon/outline.h"

namespace turner {

// Whether the edges of a closed outline meet at common ends only. No point may equal its successor.
template <class Outline>
bool isSimple(const Outline& outline);

// A simple outline of n points as n - 2 triangles over all of its points, wound as it is, none without area: the
// constrained Delaunay triangulation, but for ties and near ties. Empty if rounding beyond what orientation() can bear
// got in the way.
template <class Outline>
std::vector<Triangle3> triangulateSimple(const Outline& outline);

// Any outline of n >= 3 points as n - 2 triangles over all of its points, of which some may be turned over, overlap or
// have no area: ears as long as there are some.
template <class Outline>
std::vector<Triangle3> triangulateAnyhow(const Outline& outline);

}  // namespace turner
