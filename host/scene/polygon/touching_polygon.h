// Outlines that touch themselves and yet have an inside: polygons with holes or with parts that meet, drawn in one go.
// GEOS appears in touching_polygon.cpp only.
#pragma once

#include <optional>
#include <vector>

#include "scene/polygon/outline.h"

namespace turner {

// Triangles as indices of corners, wound as the outline is; empty if the outline has no area. Nothing if it crosses or
// overlaps itself.
std::optional<std::vector<Triangle3>> triangulateTouching(const std::vector<PlanePoint>& points,
                                                          const std::vector<uint32_t>& corners);

}  // namespace turner
