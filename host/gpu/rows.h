// Rows of layout.h made of double vectors.
#pragma once

#include <bit>
#include <glm/vec3.hpp>

#include "layout.h"

namespace turner {

inline gpu::Row row(const glm::dvec3& v, gpu::uint w = 0) {
  return {float(v.x), float(v.y), float(v.z), w};
}
inline gpu::Row row(const glm::dvec3& v, double w) {
  return row(v, std::bit_cast<gpu::uint>(float(w)));
}

// What a float leaves of a double: the low half of an unevaluated sum.
inline gpu::Row rowRest(const glm::dvec3& v, gpu::uint w = 0) {
  return row(v - glm::dvec3(float(v.x), float(v.y), float(v.z)), w);
}

}  // namespace turner
