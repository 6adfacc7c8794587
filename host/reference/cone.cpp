// Cones by Newton's method along the ray.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "reference/intersect.h"

namespace turner::reference {

Box boxOf(const Cone& cone) {
  const double baseRadius = std::abs(cone.baseRadius), apexRadius = std::abs(cone.apexRadius);
  Box box{cone.base - baseRadius, cone.base + baseRadius};
  box.include(Box{cone.apex - apexRadius, cone.apex + apexRadius});
  return box;
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

double intersect(const Ray& ray, const Cone& cone, bool startsOnIt) {
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

Surface surfaceOf(const Ray& ray, double t, const Cone& cone) {
  const wide3 base(cone.base), way = wide3(cone.apex) - base;
  const long double length = glm::length(way), baseRadius = std::abs(cone.baseRadius);
  const long double growth = (std::abs((long double)(cone.apexRadius)) - baseRadius) / length;
  const wide3 axis = way / length, x = wide3(ray.origin) + (long double)(t)*wide3(ray.direction);
  const long double height = glm::dot(x - base, axis);
  const wide3 across = (x - base) - height * axis;
  const long double distance = glm::length(across);
  // At the tip itself the normal is any; this one faces the ray.
  const wide3 sideways = distance > 0 ? across / distance : -wide3(ray.direction);
  const wide3 outward = glm::normalize(sideways - growth * axis);
  // Put the point back on the cone, along the normal.
  const long double above = (distance - (baseRadius + growth * height)) / std::sqrt(1 + growth * growth);

  Surface surface;
  surface.point = dvec3(x - above * outward);
  surface.Ng = surface.Ns = dvec3(cone.isInward() ? -outward : outward);
  // The point and both ends, as a ray's test of a neighbour sees them.
  const double size = std::max({largestSize(surface.point), largestSize(cone.base), largestSize(cone.apex),
                                std::abs(cone.baseRadius), std::abs(cone.apexRadius)});
  surface.errorBound = 16 * kRounding * size;
  return surface;
}

}  // namespace turner::reference
