// Rotates exactly by multiples of 90 degrees.
#include "scene/json/place_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/mat3x3.hpp>
#include <numbers>
#include <utility>

#include "base/reserve.h"
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
  const glm::dmat3 rotation = rotationOfDegrees(placement.degrees);
  const auto place = [&](const glm::dvec3& position) {
    return rotation * (placement.scale * position) + placement.translation;
  };
  for (const glm::dvec3& position : mesh.positions) {
    const glm::dvec3 placed = place(position);
    for (int k = 0; k < 3; ++k)
      if (!(std::abs(placed[k]) <= largest)) return false;
  }

  const auto isSmooth = [](const Mesh::Face& face) { return face.normals[0] != UINT32_MAX; };
  reservePrefaulted(scene.triangles, mesh.faces.size());
  reservePrefaulted(scene.normals, size_t(std::count_if(mesh.faces.begin(), mesh.faces.end(), isSmooth)));
  for (const Mesh::Face& face : mesh.faces) {
    Triangle triangle{};
    triangle.material = material;
    triangle.normals = kNoNormals;
    // Placed for each triangle anew, though triangles share vertices: placed copies would take memory and more time.
    for (size_t i = 0; i < 3; ++i) triangle.vertices[i] = place(mesh.positions[face.vertices[i]]);
    if (isSmooth(face)) {
      triangle.normals = static_cast<uint32_t>(scene.normals.size());
      std::array<glm::dvec3, 3>& normals = scene.normals.emplace_back();
      for (size_t i = 0; i < 3; ++i) normals[i] = rotation * scaleToUnitBox(mesh.normals[face.normals[i]]);
    }
    scene.triangles.push_back(triangle);
  }
  return true;
}

}  // namespace turner
