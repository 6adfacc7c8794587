// Cuts polygons, concave and warped ones too, into triangles.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace turner {

struct CutPolygon {
  // Indices into the corners, wound as the polygon is; none if it has no area.
  std::vector<std::array<uint32_t, 3>> triangles;
  // The outline crosses or overlaps itself: it was cut at all of its corners nevertheless, for what it is worth.
  bool crossesItself = false;
};

// A fan from the first corner where the polygon is convex, a triangulation without new vertices where it is not. A
// planar polygon may touch itself, and have holes. A warped one, whose corners lie in no plane, is cut at every corner,
// so that no triangle is turned over as seen along the polygon's normal (Newell's).
CutPolygon triangulatePolygon(std::span<const glm::dvec3> corners);

}  // namespace turner
