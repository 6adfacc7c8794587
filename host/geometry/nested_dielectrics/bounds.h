// Axis-aligned bounds in double precision, and when two of them touch but for rounding.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <glm/vector_relational.hpp>

#include "scene/scene.h"

namespace turner::nested_dielectrics {

using glm::dvec3;

// Seen from the eye, as are all bounds here: float32 rounds what the kernel gets in proportion to that.
inline Bounds boundsFromEye(const Scene& scene, Sphere sphere) {
  sphere.center -= scene.camera.eye;
  return boundsOf(sphere);
}
inline Bounds boundsFromEye(const Scene& scene, const Triangle& triangle) {
  const Bounds bounds = boundsOf(scene, triangle);
  return {bounds.lo - scene.camera.eye, bounds.hi - scene.camera.eye};
}

// Interfaces nearer to each other than this share of their distance from the eye touch. More than the
// distance within which the renderers take interfaces to coincide; what touches without need costs time, and no more.
constexpr double kTouching = 1e-5;

inline double sizeOf(const Bounds& box) {
  const dvec3 size = glm::max(glm::abs(box.lo), glm::abs(box.hi));
  return std::max({size.x, size.y, size.z});
}

inline bool meet(const Bounds& a, const Bounds& b) {
  const double slack = kTouching * std::max(sizeOf(a), sizeOf(b));
  return glm::all(glm::lessThanEqual(a.lo, b.hi + slack)) && glm::all(glm::lessThanEqual(b.lo, a.hi + slack));
}

inline bool holds(const Bounds& outer, const Bounds& inner) {
  const double slack = kTouching * sizeOf(outer);
  return glm::all(glm::lessThanEqual(outer.lo - slack, inner.lo)) &&
         glm::all(glm::lessThanEqual(inner.hi, outer.hi + slack));
}

}  // namespace turner::nested_dielectrics
