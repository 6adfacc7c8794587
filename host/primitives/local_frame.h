// The frame that the kernel computes in: the eye is the origin, and the camera's target lies in [1, 2) from it. And how
// numbers are rounded for it.
#pragma once

#include <cmath>
#include <glm/vec3.hpp>

namespace turner {

// local = (world - origin) * scale; scale is a power of two, so that it adds no error.
struct LocalFrame {
  glm::dvec3 origin{0, 0, 0};
  double scale = 1;
};

using wide3 = glm::tvec3<long double, glm::defaultp>;  // where the last bits of double matter

// To float32 and back.
inline double rounded(double x) {
  return double(float(x));
}
inline glm::dvec3 rounded(const glm::dvec3& v) {
  return {rounded(v.x), rounded(v.y), rounded(v.z)};
}

// Rounded.
inline glm::dvec3 toLocal(const glm::dvec3& p, const LocalFrame& frame) {
  return rounded((p - frame.origin) * frame.scale);
}

// Geometry may reach as far as this in the local frame: beyond, products of coordinates overflow float32.
inline constexpr double kMostLocal = 1e10;

// False for NaN too.
inline bool isWithin(const glm::dvec3& v, double most) {
  return std::abs(v.x) <= most && std::abs(v.y) <= most && std::abs(v.z) <= most;
}

}  // namespace turner
