// Vectors and structures of layout.h made of double vectors.
#pragma once

#include <cstring>
#include <glm/vec3.hpp>
#include <vector>

#include "layout.h"

namespace turner {

inline gpu::vec3 toVec3(const glm::dvec3& v) {
  return {float(v.x), float(v.y), float(v.z)};
}

// What a float leaves of a double: the low half of an unevaluated sum.
inline gpu::vec3 toVec3Rest(const glm::dvec3& v) {
  return toVec3(v - glm::dvec3(float(v.x), float(v.y), float(v.z)));
}

// Appends a structure of layout.h as the words that the kernel reads.
template <class Structure>
void append(std::vector<gpu::Word4>& words, const Structure& structure) {
  static_assert(sizeof structure % sizeof(gpu::Word4) == 0);
  const size_t at = words.size();
  words.resize(at + sizeof structure / sizeof(gpu::Word4));
  std::memcpy(&words[at], &structure, sizeof structure);
}

}  // namespace turner
