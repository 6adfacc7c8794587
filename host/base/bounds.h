// Axis-aligned boxes in float32, as acceleration structures see primitives.
#pragma once

#include <glm/vec3.hpp>

namespace turner {

struct Box {
  glm::vec3 lo{0}, hi{0};
};

}  // namespace turner
