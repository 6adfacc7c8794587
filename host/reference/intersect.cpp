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

double intersectSphere(const Ray& ray, const Sphere& sphere, bool startsOnIt) {
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

namespace {

// A ray and a cone, from the ray's foot on: the place that is nearest to the cone's base. Along the ray the signed
// distance across the axis, |y(t)| - radius(s(t)), is convex, as a norm of a linear function less a linear function: so
// Newton's steps from the left go to the root where it falls, and from the right to the one where it rises, and never
// pass it. No quadratic, no second half of a double cone (there it is positive), no case of a parallel generator.
struct ConeOnRay {
  double foot;                    // of the ray
  double height, climb;           // along the axis: of the foot, and by how much a unit of the ray goes up
  dvec3 across, drift;            // the same across the axis
  double length, radius, growth;  // of the cone; radius at the base, growth by a unit of height
  double reach;                   // from the base to the farthest point, and more

  double distance(double t, double& derivative) const {
    const dvec3 y = across + t * drift;
    const double size = glm::length(y);
    derivative = (size > 0 ? glm::dot(y, drift) / size : -glm::length(drift)) - growth * climb;
    return size - (radius + growth * (height + t * climb));
  }

  bool isBetweenEnds(double t) const {
    const double s = height + t * climb, slack = 1e-15 * reach;
    if (std::abs(growth) <= 1) return s >= -slack && s <= length + slack;
    // Nearly a disc: by the radius, which is known better than the height.
    const double size = glm::length(across + t * drift), other = radius + growth * length;
    return size >= std::min(radius, other) - slack && size <= std::max(radius, other) + slack &&
           radius + growth * s >= -slack * (1 + std::abs(growth));
  }

  // From t on, to the right (way 1) or to the left (-1); kFarAway where there is no root.
  double newton(double t, double way) const {
    for (int step = 0; step < 200; ++step) {
      double derivative;
      const double value = distance(t, derivative);
      // Past the least value, which is above 0 unless it is the tip's.
      if (!(way * derivative < 0)) return value <= 8 * kRounding * reach ? t : kFarAway;
      if (value <= 0) return t;
      const double next = t - value / derivative;
      if (next == t) return t;
      if (way * (next - t) > 4 * reach) return kFarAway;
      t = next;
    }
    return t;
  }
};

ConeOnRay coneOnRay(const Ray& ray, const Cone& cone, bool startsOnIt) {
  const dvec3 way = cone.apex - cone.base, f = ray.origin - cone.base;
  ConeOnRay on;
  on.length = glm::length(way);
  on.radius = std::abs(cone.baseRadius);
  on.growth = (std::abs(cone.apexRadius) - on.radius) / on.length;
  on.reach = std::hypot(on.length, std::max(on.radius, std::abs(cone.apexRadius))) * (1 + 1e-12);
  on.foot = startsOnIt ? 0 : -glm::dot(f, ray.direction);
  const dvec3 axis = way / on.length, p = f + on.foot * ray.direction;
  on.height = glm::dot(p, axis);
  on.climb = glm::dot(ray.direction, axis);
  on.across = p - on.height * axis;
  on.drift = ray.direction - on.climb * axis;
  return on;
}

}  // namespace

double intersectCone(const Ray& ray, const Cone& cone, bool startsOnIt) {
  const ConeOnRay on = coneOnRay(ray, cone, startsOnIt);
  double derivative;
  const auto hitAt = [&](double t) { return t < kFarAway && on.foot + t > 0 && on.isBetweenEnds(t); };
  if (startsOnIt) {
    // Outward it never comes back, as the inside is convex; inward it does where the distance rises again.
    if (on.distance(0, derivative), !(derivative < 0)) return kFarAway;
    if (on.distance(2 * on.reach, derivative) <= 0) return kFarAway;
    const double t = on.newton(2 * on.reach, -1);
    return hitAt(t) ? t : kFarAway;
  }
  if (on.distance(-on.reach, derivative) > 0)
    if (const double t = on.newton(-on.reach, 1); hitAt(t)) return on.foot + t;
  if (on.distance(on.reach, derivative) > 0)
    if (const double t = on.newton(on.reach, -1); hitAt(t)) return on.foot + t;
  return kFarAway;
}

bool isInside(const dvec3& point, const Sphere& sphere) {
  const wide3 f = wide3(point) - wide3(sphere.center);
  return glm::dot(f, f) < wideRadius(sphere) * wideRadius(sphere);
}

// Without cracks: each vertex is projected without regard to the triangle it is in; neighbours get the same products
// for their common edge, with opposite signs; and as rounding is monotone, a difference of two rounded products is of
// the right sign or zero. A ray through an edge or a vertex is therefore inside at least one of the triangles around
// it.
dvec3 edgeAreas(const Ray& ray, const TriangleCorners& corners) {
  std::array<glm::dvec2, 3> p;
  for (int k = 0; k < 3; ++k) {
    const dvec3 v = corners[k] - ray.origin;
    p[k] = {glm::dot(v, ray.across1), glm::dot(v, ray.across2)};
  }
  return {p[1].x * p[2].y - p[1].y * p[2].x, p[2].x * p[0].y - p[2].y * p[0].x, p[0].x * p[1].y - p[0].y * p[1].x};
}

double intersectTriangle(const Ray& ray, const TriangleCorners& corners, const dvec3& normal) {
  const dvec3 area = edgeAreas(ray, corners);
  const bool anyNegative = area.x < 0 || area.y < 0 || area.z<0, anyPositive = area.x> 0 || area.y > 0 || area.z > 0;
  if (anyNegative == anyPositive) return kFarAway;  // outside, or seen exactly edge-on
  const double cosine = glm::dot(normal, ray.direction);
  if (cosine == 0) return kFarAway;
  // The distance of the plane, which at a grazing angle must not leave the triangle's own depth.
  const dvec3 toVertex = corners[0] - ray.origin;
  const double depth0 = glm::dot(toVertex, ray.direction);
  const double depth1 = glm::dot(corners[1] - ray.origin, ray.direction);
  const double depth2 = glm::dot(corners[2] - ray.origin, ray.direction);
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
