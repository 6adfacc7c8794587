// Wavefront OBJ meshes: v, vn and f. Materials, groups and texture coordinates are passed over.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace turner {

struct Mesh {
  struct Face {
    std::array<uint32_t, 3> vertices;  // indices into positions
    std::array<uint32_t, 3> normals;   // indices into Mesh::normals; all UINT32_MAX where the face has none
  };
  std::vector<glm::dvec3> positions;
  std::vector<glm::dvec3> normals;
  std::vector<Face> faces;  // polygons are triangulated, in file order
};

// Throws InputError with all faults, each at its line and column of `path`.
Mesh parseObj(const std::string& path, std::string_view text);

}  // namespace turner
