// Runs the shader's formulas for light at a surface over many inputs, without a scene, and the textbook's beside them.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <vector>

#include "hard/kernels.h"

namespace turner::hard {

// A light and a surface, in the float32 that the kernel gets; symbols as in shaders/shade.glsl.
struct Lit {
  glm::vec3 point{0};
  glm::vec3 N{0, 0, 1};  // both Ng and Ns
  glm::vec3 V{0, 0, 1};
  glm::vec3 light{0, 0, 1};
  bool fallsOff = false;  // inverse square
  glm::vec3 E{1};
  glm::vec3 diffuse{0}, specular{0};
  float shininess = 1;
  float q = 0;  // of the power (1 - q)^shininess
};

struct Reflected {
  glm::vec3 radiance;  // toward the eye; 0 where the light does not face the surface
  float power;
};

class Formulas {
 public:
  // On the device that TURNER_DEVICE names, else the best one.
  Formulas();
  ~Formulas();
  std::vector<Reflected> evaluate(std::span<const Lit> lits, Tracer tracer = Tracer::turner) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace turner::hard
