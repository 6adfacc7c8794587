// The directions of a camera, for packing and for the matrices in an EXR. (The reference has its own.)
#pragma once

#include <glm/vec3.hpp>

#include "scene/scene.h"

namespace turner {

struct CameraBasis {
  glm::dvec3 right, up, forward;  // unit, perpendicular; right = forward x up
  double tanHalfFov;              // of the vertical field of view
};

CameraBasis cameraBasis(const Camera& camera);

}  // namespace turner
