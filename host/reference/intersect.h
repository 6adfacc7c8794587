// Rays, and where they hit one sphere, cone or triangle.
// Comes in: a ray and a primitive of the scene. Goes out: the distance of the hit, and the surface there.
#pragma once

#include <cstdint>

#include "reference/box_tree.h"
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

// The surface at a hit, seen from where the ray came from.
struct Surface {
  dvec3 point;
  dvec3 Ng, Ns;  // unit; Ng, and for what is smooth Ns too, on the side that the ray came from
  bool front;    // hit on the side that the primitive's own normal points to
  const Material* material;
  uint32_t primitive;
  double errorBound;  // the point is on the surface but for this distance
};

// `direction` is a unit vector.
Ray makeRay(const dvec3& origin, const dvec3& direction, uint32_t originPrimitive);

// With all digits: the radius of a rounded scene's sphere may have more than a double holds.
inline long double wideRadius(const Sphere& sphere) {
  return (long double)(sphere.radius) + sphere.radiusRest;
}

// For each type of primitive but triangles: a box around it, the distance at which a ray hits it, or kFarAway, and the
// surface there, its point put back onto the primitive, its normals on the primitive's own side; front, material and
// primitive are the caller's.
Box boxOf(const Sphere& sphere);
Box boxOf(const Cone& cone);
double intersect(const Ray& ray, const Sphere& sphere, bool startsOnIt);
double intersect(const Ray& ray, const Cone& cone, bool startsOnIt);
Surface surfaceOf(const Ray& ray, double t, const Sphere& sphere);
Surface surfaceOf(const Ray& ray, double t, const Cone& cone);

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
