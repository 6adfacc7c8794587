// Meshes of any size that look alike: five bumpy spheres, tessellated, on a floor of two triangles. Time against size
// can be read off them, since all rays see the same shapes. Made by integer hashes and by arithmetic that IEEE rounds
// exactly: the same mesh everywhere.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace turner::test {

struct BumpyMesh {
  struct Face {
    std::array<uint32_t, 3> vertices;  // indices into positions, counter-clockwise from outside
    uint32_t material = 0;             // index into the materials of bumpySpheres
  };
  std::vector<glm::dvec3> positions;
  std::vector<Face> faces;
};

// As near to this number of triangles as the tessellation comes: five spheres of 12 n^2, and the floor's two.
BumpyMesh bumpyMesh(size_t triangles);

// The mesh with one light, one of its spheres a mirror and the rest matte.
Scene bumpySpheres(size_t triangles);

// The mesh as Wavefront OBJ; throws RunError when the file cannot be written.
void writeBumpyObj(const std::string& path, size_t triangles);

}  // namespace turner::test
