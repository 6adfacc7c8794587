// Rays, and where they hit one sphere or triangle.
// Comes in: a ray and a primitive of the scene. Goes out: the distance of the hit. Knows nothing of materials.
#pragma once

#include <cstdint>

#include "reference/precision.h"
#include "scene/scene.h"

namespace turner::reference {

constexpr uint32_t kNoPrimitive = UINT32_MAX;

struct Ray {
  dvec3 origin;
  dvec3 direction;           // unit
  uint32_t originPrimitive;  // that the ray starts on, or kNoPrimitive
  dvec3 across1, across2;    // with direction an orthonormal basis
};

// `direction` is a unit vector.
Ray makeRay(const dvec3& origin, const dvec3& direction, uint32_t originPrimitive);

// With all digits: the radius of a rounded scene's sphere may have more than a double holds.
inline long double wideRadius(const Sphere& sphere) {
  return (long double)(sphere.radius) + sphere.radiusRest;
}

// The distance at which the ray hits the sphere, or kFarAway.
double intersectSphere(const Ray& ray, const Sphere& sphere, bool startsOnIt);

// Whether the point is within the sphere's radius.
bool isInside(const dvec3& point, const Sphere& sphere);

// The distance at which the ray hits the triangle, edges included, or kFarAway. `normal` is its unit normal.
double intersectTriangle(const Ray& ray, const Scene& scene, const Triangle& triangle, const dvec3& normal);

// Twice the areas of the three triangles that the ray's point makes with the edges, seen along the ray: all of one sign
// if the point is inside, and then in the ratio of the barycentric coordinates.
dvec3 edgeAreas(const Ray& ray, const Scene& scene, const Triangle& triangle);

// The unit normal by counter-clockwise winding; 0 for a triangle without area, which no ray hits.
dvec3 faceNormal(const TriangleCorners& corners);

}  // namespace turner::reference
