// Cones and cylinders as smooth triangles: the scene knows no cones.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>

#include "scene/scene.h"

namespace turner::nff {

// Cones and cylinders become this many smooth quads around the axis, and one or more along it: two triangles each, one
// where a radius is 0.
inline constexpr int kConeSegments = 32;

// Without its ends. Radii from 0, not both 0; base and apex are different points.
struct Cone {
  glm::dvec3 base;
  double baseRadius;
  glm::dvec3 apex;
  double apexRadius;
  bool inward;  // seen from inside
};

// How many pieces that is along the axis, for a cone of this length and larger radius.
int conePieces(double length, double radius);

// No fewer triangles than tessellateCone will add.
size_t mostConeTriangles(const Cone& cone);

// Appends the triangles of the cone's side and their normals.
void tessellateCone(const Cone& cone, uint32_t material, Scene& scene);

}  // namespace turner::nff
