// The types of primitives: which one a reference is to, what it takes, and what is called for each. A scene's types alone
// are compiled.
#include "sphere.glsl"
#include "cone.glsl"
#include "triangle.glsl"

// The type of what a reference is to, in the order in which lists have them.
const uint kSpheres = 0u, kCones = 1u, kPairs = 2u;

bool isOfTriangles(const uint reference) {
  return TRIANGLES && ((!SPHERES && !CONES) || (reference & kRefTriangle) != 0u);
}

uint typeOf(const uint reference) {
  bool isCone = CONES && (!SPHERES || (reference & kRefCone) != 0u);
  return isOfTriangles(reference) ? kPairs : isCone ? kCones : kSpheres;
}

uint unitsOf(const uint type) {
  return TRIANGLES && type == kPairs ? kPairUnits : CONES && type == kCones ? kConeUnits : kSphereUnits;
}

Intersection intersect(const Ray ray, const RayFactors factors, const uint primitive, const uint type) {
  Intersection found = Intersection(kNoHit, kRefNone, 0u, false, 0u, 0u, 0.0);
  if (SPHERES && type == kSpheres) found = intersectSphere(ray, factors, primitive);
  if (CONES && type == kCones) found = intersectCone(ray, factors, primitive);
  if (TRIANGLES && type == kPairs) found = intersectTrianglePair(ray, factors, primitive);
  return found;
}

// Turns the hit of a ray into the surface there.
Surface surfaceAt(const Ray ray, const RayFactors factors, const float t, const uint primitive) {
  uint type = typeOf(primitive);
  Surface surface = Surface(vec3(0), vec3(0), vec3(0), false, true, 0.0, 0u);
  if (SPHERES && type == kSpheres) surface = sphereSurface(ray, factors, t, primitive);
  if (CONES && type == kCones) surface = coneSurface(ray, factors, primitive);
  if (TRIANGLES && type == kPairs) surface = triangleSurface(ray, factors, t, primitive);
  if (dot(surface.Ns, -ray.direction) <= 0.0) surface.Ns = surface.Ng;
  return surface;
}
