// Quadratic and edge functions, arranged so that they keep their digits and leave no cracks.
#include "reference/intersect.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

namespace turner::reference {
namespace {

// The smallest positive root of t^2 + 2 b t + c = 0 with b^2 - c = D, or kFarAway. The root without cancellation comes
// first, and the other one from their product c.
template <class Real>
double nearestRoot(Real b, Real c, Real D) {
  if (!(D >= 0)) return kFarAway;
  const Real q = b < 0 ? -b + std::sqrt(D) : -b - std::sqrt(D);
  const double t0 = double(b < 0 ? c / q : q), t1 = double(b < 0 ? q : c / q);
  return t0 > 0 ? t0 : t1 > 0 ? t1 : kFarAway;
}

}  // namespace

// The basis is that of Duff et al., "Building an orthonormal basis, revisited", JCGT 6(1), 2017.
Ray makeRay(const dvec3& origin, const dvec3& d, uint32_t originPrimitive) {
  const double sign = std::copysign(1.0, d.z);
  const double a = -1 / (sign + d.z);
  const double b = d.x * d.y * a;
  return {
      origin, d, originPrimitive, {1 + sign * d.x * d.x * a, sign * b, -sign * d.x}, {b, sign + d.y * d.y * a, -d.y}};
}

Box boxOf(const Sphere& sphere) {
  const double radius = std::abs(sphere.radius);
  return {sphere.center - radius, sphere.center + radius};
}

double intersect(const Ray& ray, const Sphere& sphere, bool startsOnIt) {
  const dvec3 f = ray.origin - sphere.center;
  const double b = glm::dot(f, ray.direction);
  // A ray that starts on the sphere has c = 0: the roots are 0, which is the start, and -2 b.
  if (startsOnIt) return b < 0 ? -2 * b : kFarAway;

  const double squaredRadius = sphere.radius * sphere.radius;
  const double c = glm::dot(f, f) - squaredRadius;
  if (std::abs(c) > 0x1p-10 * squaredRadius) {
    if (c > 0 && b >= 0) return kFarAway;  // outside, and on the way away from it
    // The discriminant from the distance between centre and ray, which keeps its digits where the sphere is far away:
    // Haines et al., "Precision improvements for ray/sphere intersection", Ray Tracing Gems, chapter 7 (2019).
    const dvec3 perpendicular = f - b * ray.direction;
    return nearestRoot(b, c, squaredRadius - glm::dot(perpendicular, perpendicular));
  }
  // Close to the surface c is a small difference of large squares, so that all of it is done in the wider type.
  const wide3 wideF = wide3(ray.origin) - wide3(sphere.center), d(ray.direction);
  const long double dd = glm::dot(d, d);
  const long double wideB = glm::dot(wideF, d) / dd;
  const long double radius = wideRadius(sphere);
  const long double wideC = (glm::dot(wideF, wideF) - radius * radius) / dd;
  return nearestRoot(wideB, wideC, wideB * wideB - wideC);
}

Surface surfaceOf(const Ray& ray, double t, const Sphere& sphere) {
  // Put the point back on the sphere: one Newton step, in the wider type as the centre may be far away.
  wide3 x = wide3(ray.origin) + (long double)(t)*wide3(ray.direction);
  wide3 f = x - wide3(sphere.center);
  const long double squaredRadius = wideRadius(sphere) * wideRadius(sphere);
  x -= f * ((glm::dot(f, f) - squaredRadius) / (2 * squaredRadius));

  Surface surface;
  surface.point = dvec3(x);
  surface.Ng = surface.Ns =
      dvec3(glm::normalize(x - wide3(sphere.center)) * std::copysign(1.0L, (long double)sphere.radius));
  // The point errs by rounding it to double; the rest, here and in another sphere's test nearby, is done in the wider
  // type.
  surface.errorBound = 8 * (kRounding * largestSize(surface.point) +
                            kWideRounding * (largestSize(sphere.center) + std::abs(sphere.radius)));
  return surface;
}

bool isInside(const dvec3& point, const Sphere& sphere) {
  const wide3 f = wide3(point) - wide3(sphere.center);
  return glm::dot(f, f) < wideRadius(sphere) * wideRadius(sphere);
}

// Without cracks: each vertex is projected without regard to the triangle it is in; neighbours get the same products
// for their common edge, with opposite signs; and as rounding is monotone, a difference of two rounded products is of
// the right sign or zero. A ray through an edge or a vertex is therefore inside at least one of the triangles around
// it.
dvec3 edgeAreas(const Ray& ray, const Scene& scene, const Triangle& triangle) {
  std::array<glm::dvec2, 3> p;
  for (size_t k = 0; k < 3; ++k) {
    const dvec3 v = scene.cornerOf(triangle, k) - ray.origin;
    p[k] = {glm::dot(v, ray.across1), glm::dot(v, ray.across2)};
  }
  return {p[1].x * p[2].y - p[1].y * p[2].x, p[2].x * p[0].y - p[2].y * p[0].x, p[0].x * p[1].y - p[0].y * p[1].x};
}

double intersectTriangle(const Ray& ray, const Scene& scene, const Triangle& triangle, const dvec3& normal) {
  const dvec3 area = edgeAreas(ray, scene, triangle);
  const bool anyNegative = area.x < 0 || area.y < 0 || area.z<0, anyPositive = area.x> 0 || area.y > 0 || area.z > 0;
  if (anyNegative == anyPositive) return kFarAway;  // outside, or seen exactly edge-on
  const double cosine = glm::dot(normal, ray.direction);
  if (cosine == 0) return kFarAway;
  // The distance of the plane, which at a grazing angle must not leave the triangle's own depth.
  const dvec3 toVertex = scene.cornerOf(triangle, 0) - ray.origin;
  const double depth0 = glm::dot(toVertex, ray.direction);
  const double depth1 = glm::dot(scene.cornerOf(triangle, 1) - ray.origin, ray.direction);
  const double depth2 = glm::dot(scene.cornerOf(triangle, 2) - ray.origin, ray.direction);
  const double t = std::clamp(glm::dot(normal, toVertex) / cosine, std::min({depth0, depth1, depth2}),
                              std::max({depth0, depth1, depth2}));
  return t > 0 ? t : kFarAway;
}

dvec3 faceNormal(const TriangleCorners& corners) {
  const wide3 v0(corners[0]);
  const wide3 normal = glm::cross(wide3(corners[1]) - v0, wide3(corners[2]) - v0);
  const long double length = glm::length(normal);
  return length > 0 ? dvec3(normal / length) : dvec3(0);
}

}  // namespace turner::reference
