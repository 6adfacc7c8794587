// Wavefront OBJ meshes: v, vn and f. Materials, groups and texture coordinates are passed over. What only shades, or
// belongs to no face, never refuses a file.
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
    std::array<uint32_t, 3> normals;   // indices into Mesh::normals; all UINT32_MAX where the face is flat
  };
  std::vector<glm::dvec3> positions;
  std::vector<glm::dvec3> normals;  // 0 0 0 where the file's has no direction; no face has it
  std::vector<Face> faces;          // polygons are triangulated, in file order
  std::vector<std::string> notes;   // as Scene::notes
};

// Throws InputError with all faults, each at its line and column of `path`.
Mesh parseObj(const std::string& path, std::string_view bytes);

}  // namespace turner
