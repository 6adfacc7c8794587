// A word of the test kernels as the host fills and reads it: three floats and an integer.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

namespace turner::hard {

struct Row {
  float x, y, z;
  uint32_t w;
};

inline Row rowOf(const glm::vec3& v, uint32_t w = 0) {
  return {v.x, v.y, v.z, w};
}

}  // namespace turner::hard
