// Cuts planar polygons, concave ones too, into triangles. GEOS appears in polygon.cpp only.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace turner {

// Triangles as indices into `corners`, wound as the polygon is: a fan from the first corner where the polygon is
// convex, a triangulation without new vertices where it is not. Empty if the polygon has no area. Throws
// std::invalid_argument, saying why, where the outline crosses itself.
std::vector<std::array<uint32_t, 3>> triangulatePolygon(std::span<const glm::dvec3> corners);

}  // namespace turner
