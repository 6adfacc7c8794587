// Axis-aligned boxes: in double, as primitives have them, and in float32, as acceleration structures see them.
#pragma once

#include <cmath>
#include <glm/common.hpp>
#include <glm/vec3.hpp>

namespace turner {

struct Box {
  glm::vec3 lo{0}, hi{0};
};

// Empty until something is included.
struct Bounds {
  glm::dvec3 lo{INFINITY}, hi{-INFINITY};

  void include(const Bounds& other) {
    lo = glm::min(lo, other.lo);
    hi = glm::max(hi, other.hi);
  }
  void include(const glm::dvec3& point) { include(Bounds{point, point}); }
  Bounds united(const Bounds& other) const { return {glm::min(lo, other.lo), glm::max(hi, other.hi)}; }
};

}  // namespace turner
