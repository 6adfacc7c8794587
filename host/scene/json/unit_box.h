// Directions of any length, brought to where their squares neither overflow nor underflow.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/vec3.hpp>

namespace turner {

// The same direction, its squares far from overflow and underflow.
inline glm::dvec3 scaleToUnitBox(const glm::dvec3& v) {
  const double largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  return largest > 0 ? v / largest : v;
}

}  // namespace turner
