// Shapes of cones, where they stand for the hard cases, and the rays that are aimed at them: the eye is the origin and
// the view's scale 1, so that the kernel's frame is the scene's.
#pragma once

#include <cmath>
#include <vector>

#include "hard/cases.h"
#include "hard/cone_oracle.h"
#include "hard/vectors.h"
#include "layout.h"

namespace turner::hard {

// Of length 1.
struct ConeShape {
  double radius, otherRadius;
  double size() const { return std::hypot(1.0, std::max(radius, otherRadius)); }
};

inline std::vector<ConeShape> allConeShapes() {
  std::vector<ConeShape> shapes;
  for (const double r : {1e-5, 1e-3, 0.1, 1.0, 30.0, 1e3}) shapes.push_back({r, r});
  for (const double r : {1e-3, 0.1, 1.0, 10.0, 1e3}) shapes.push_back({0, r});
  for (const auto& [r, other] : {std::pair(0.3, 0.5), {1.0, 1.0001}, {1e-4, 1e-3}, {2.0, 12.0}, {100.0, 1100.0}})
    shapes.push_back({r, other});
  return shapes;
}

// Turned anyhow, so many sizes away from the eye and 1 large; either end is the base.
inline Cone coneAt(const ConeShape& shape, double away, Random& random) {
  const dvec3 middle = away * randomDirection(random), way = randomDirection(random) / shape.size();
  Cone cone{middle - 0.5 * way, shape.radius / shape.size(), middle + 0.5 * way, shape.otherRadius / shape.size(), 0};
  if (random() % 2) std::swap(cone.base, cone.apex), std::swap(cone.baseRadius, cone.apexRadius);
  return cone;
}

inline Scene coneScene(const std::vector<Cone>& cones) {
  Scene scene;
  scene.camera = {.eye = {0, 0, 0}, .target = {0, 0, -1}};
  scene.materials = {Material{.diffuse = {1, 1, 1}}};
  scene.cones = cones;
  return scene;
}

// Whether a ray leaves a cone or a sphere toward its inside.
inline bool goesInward(const TestRay& ray) {
  return (ray.leaving & gpu::kStartsInward) != 0;
}

// --- the rays ---

using ConeRayMaker = TestRay (*)(const ConeOracle&, double away, Random&);

// Through a target, from so many sizes away, about.
inline TestRay rayThrough(const ConeOracle& cone, const dvec3& target, const dvec3& direction, double away) {
  const vec3 origin(target - away * cone.size() * direction);
  return {origin, vec3(glm::normalize(target - dvec3(origin)))};
}

struct Place {
  dvec3 point, outward, generator;  // unit; along the surface toward the apex
};

inline Place placeOn(const ConeOracle& cone, double share, Random& random) {
  const dvec3 side = anywhereAcross(cone.axis(), random);
  return {cone.centerAt(share) + cone.radiusAt(share) * side, cone.cosine() * side - cone.sine() * cone.axis(),
          cone.sine() * side + cone.cosine() * cone.axis()};
}

inline double halvings(Random& random, int least, int most) {
  return std::ldexp(1.0, -least - int(random() % uint64_t(most - least + 1)));
}

inline TestRay anywhere(const ConeOracle& cone, double away, Random& random) {
  const dvec3 target = placeOn(cone, uniform(random, -0.05, 1.05), random).point;
  return rayThrough(cone, target, randomDirection(random), away);
}

inline TestRay atTheSilhouette(const ConeOracle& cone, double away, Random& random) {
  const Place place = placeOn(cone, uniform(random, 0, 1), random);
  const double off = (random() % 2 ? 1 : -1) * cone.widest() * halvings(random, 8, 26);
  return rayThrough(cone, place.point + off * place.outward, anywhereAcross(place.outward, random), away);
}

inline TestRay atTheRims(const ConeOracle& cone, double away, Random& random) {
  const Place place = placeOn(cone, double(random() % 2), random);
  const dvec3 off = std::min(cone.widest(), cone.slant()) * halvings(random, 4, 26) * randomDirection(random);
  return rayThrough(cone, place.point + off, randomDirection(random), away);
}

inline TestRay alongTheAxis(const ConeOracle& cone, double away, Random& random) {
  const dvec3 target = cone.centerAt(uniform(random, 0, 1)) +
                       1.1 * cone.widest() * uniform(random, 0, 1) * anywhereAcross(cone.axis(), random);
  const dvec3 tilt = halvings(random, 4, 30) * randomDirection(random);
  return rayThrough(cone, target, glm::normalize((random() % 2 ? 1.0 : -1.0) * cone.axis() + tilt), away);
}

inline TestRay alongAGenerator(const ConeOracle& cone, double away, Random& random) {
  const Place place = placeOn(cone, uniform(random, 0, 1), random);
  const dvec3 off = cone.widest() * halvings(random, 4, 26) * randomDirection(random);
  const dvec3 tilt = halvings(random, 4, 30) * randomDirection(random);
  return rayThrough(cone, place.point + off, glm::normalize((random() % 2 ? 1.0 : -1.0) * place.generator + tilt),
                    away);
}

inline TestRay atTheTip(const ConeOracle& cone, double away, Random& random) {
  const dvec3 off = random() % 8 ? cone.widest() * halvings(random, 4, 26) * randomDirection(random) : dvec3(0);
  const dvec3 tip = cone.centerAt(cone.radiusAt(0) < cone.radiusAt(1) ? 0 : 1);
  const double upright = random() % 2 ? 0 : random() % 2 ? 1 : -1;
  const dvec3 tilt = (upright == 0 ? 1 : halvings(random, 4, 30)) * randomDirection(random);
  return rayThrough(cone, tip + off, glm::normalize(upright * cone.axis() + tilt), away);
}

inline TestRay fromInside(const ConeOracle& cone, double, Random& random) {
  const double share = uniform(random, 0, 1);
  const dvec3 origin =
      cone.centerAt(share) + 0.95 * cone.radiusAt(share) * uniform(random, 0, 1) * anywhereAcross(cone.axis(), random);
  return {vec3(origin), vec3(randomDirection(random))};
}

}  // namespace turner::hard
