// Meshes of a JSON scene: scaled, turned and moved to where they belong.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "scene/obj/mesh_obj.h"
#include "scene/scene.h"

namespace turner {

// First scaled, then turned about x, y and z in this order, then moved.
struct Placement {
  double scale = 1;
  glm::dvec3 degrees{0}, translation{0};
};

// Appends the mesh to the scene, each position and normal once; false, and nothing is appended, if a coordinate would
// be larger than `largest`. Throws InputError if there would be more vertices than indices for them.
bool placeMesh(const Mesh& mesh, uint32_t material, const Placement& placement, double largest, Scene& scene);

}  // namespace turner
