// Whitted's camera: forward to the target, right = forward x up.
#include "image/camera_basis.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

namespace turner {

CameraBasis cameraBasis(const Camera& camera) {
  CameraBasis basis;
  basis.forward = glm::normalize(camera.target - camera.eye);
  basis.right = glm::normalize(glm::cross(basis.forward, camera.up));
  basis.up = glm::cross(basis.right, basis.forward);
  basis.tanHalfFov = std::tan(camera.fov * std::numbers::pi / 360);
  return basis;
}

}  // namespace turner
