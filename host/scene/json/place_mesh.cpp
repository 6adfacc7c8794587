// Rotates exactly by multiples of 90 degrees.
#include "scene/json/place_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/mat3x3.hpp>
#include <numbers>
#include <utility>

#include "base/errors.h"
#include "base/reserve.h"
#include "primitives/local_frame.h"
#include "scene/json/unit_box.h"

namespace turner {
namespace {

// Cosine and sine; exact for multiples of 90 degrees, where std::cos of the rounded radians is not.
std::pair<double, double> cosAndSinOfDegrees(double degrees) {
  int quarter = 0;
  const double rest = std::remquo(degrees, 90.0, &quarter) * (std::numbers::pi / 180);
  const double c = std::cos(rest), s = std::sin(rest);
  switch (quarter & 3) {
    case 0:
      return {c, s};
    case 1:
      return {-s, c};
    case 2:
      return {-c, -s};
    default:
      return {s, -c};
  }
}

// Rz * Ry * Rx: about x first.
glm::dmat3 rotationOfDegrees(const glm::dvec3& degrees) {
  const auto [cx, sx] = cosAndSinOfDegrees(degrees.x);
  const auto [cy, sy] = cosAndSinOfDegrees(degrees.y);
  const auto [cz, sz] = cosAndSinOfDegrees(degrees.z);
  // glm takes columns.
  const glm::dmat3 rx(1, 0, 0, 0, cx, sx, 0, -sx, cx);
  const glm::dmat3 ry(cy, 0, -sy, 0, 1, 0, sy, 0, cy);
  const glm::dmat3 rz(cz, sz, 0, -sz, cz, 0, 0, 0, 1);
  return rz * ry * rx;
}

}  // namespace

bool placeMesh(const Mesh& mesh, uint32_t material, const Placement& placement, double largest, Scene& scene) {
  const size_t firstPosition = scene.positions.size(), firstNormal = scene.normals.size();
  if (std::max(firstPosition + mesh.positions.size(), firstNormal + mesh.normals.size()) > kNoNormals)
    throw InputError("the scene's meshes have more vertices than 32-bit indices can name");

  const glm::dmat3 rotation = rotationOfDegrees(placement.degrees);
  reservePrefaulted(scene.positions, mesh.positions.size());
  bool allWithin = true;
  for (const glm::dvec3& position : mesh.positions) {
    scene.positions.push_back(rotation * (placement.scale * position) + placement.translation);
    allWithin &= isWithin(scene.positions.back(), largest);
  }
  if (!allWithin) {
    // A vertex that no face uses may lie anywhere.
    const auto isFaceWithin = [&](const Mesh::Face& face) {
      return std::all_of(face.vertices.begin(), face.vertices.end(),
                         [&](uint32_t vertex) { return isWithin(scene.positions[firstPosition + vertex], largest); });
    };
    if (!std::all_of(mesh.faces.begin(), mesh.faces.end(), isFaceWithin)) {
      scene.positions.resize(firstPosition);
      return false;
    }
  }
  reservePrefaulted(scene.normals, mesh.normals.size());
  for (const glm::dvec3& normal : mesh.normals) scene.normals.push_back(rotation * scaleToUnitBox(normal));

  const auto shifted = [](const std::array<uint32_t, 3>& indices, size_t by) {
    const uint32_t first = uint32_t(by);
    return std::array{first + indices[0], first + indices[1], first + indices[2]};
  };
  reservePrefaulted(scene.triangles, mesh.faces.size());
  for (const Mesh::Face& face : mesh.faces) {
    Triangle triangle{.positions = shifted(face.vertices, firstPosition), .material = material};
    if (face.normals[0] != kNoNormals) triangle.normals = shifted(face.normals, firstNormal);
    scene.triangles.push_back(triangle);
  }
  return true;
}

}  // namespace turner
