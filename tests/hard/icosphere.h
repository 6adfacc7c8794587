// A closed convex mesh.
#pragma once

#include <array>
#include <glm/geometric.hpp>
#include <map>
#include <vector>

#include "hard/vectors.h"
#include "scene/scene.h"

namespace turner::hard {

// An icosahedron whose faces are cut into four, again and again, with corners on the sphere.
inline Scene icosphere(int levels, double radius, const dvec3& centre) {
  const double g = (1 + std::sqrt(5.0)) / 2;
  std::vector<dvec3> corners;
  for (const double a : {-1.0, 1.0})
    for (const double b : {-g, g})
      for (const dvec3& v : {dvec3(0, a, b), dvec3(a, b, 0), dvec3(b, 0, a)}) corners.push_back(glm::normalize(v));
  std::vector<std::array<uint32_t, 3>> faces;
  const double edge = 2 / std::sqrt(1 + g * g);
  const auto areNeighbours = [&](uint32_t i, uint32_t j) {
    return std::abs(glm::length(corners[i] - corners[j]) - edge) < 1e-6;
  };
  for (uint32_t i = 0; i < 12; ++i)
    for (uint32_t j = i + 1; j < 12; ++j)
      for (uint32_t k = j + 1; k < 12; ++k) {
        if (!areNeighbours(i, j) || !areNeighbours(j, k) || !areNeighbours(i, k)) continue;
        const bool counterClockwise = glm::dot(corners[i], glm::cross(corners[j], corners[k])) > 0;
        faces.push_back({i, counterClockwise ? j : k, counterClockwise ? k : j});
      }
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
    const auto middle = [&](uint32_t i, uint32_t j) {
      const auto [place, isNew] = middles.try_emplace(std::minmax(i, j), uint32_t(corners.size()));
      if (isNew) corners.push_back(glm::normalize(corners[i] + corners[j]));
      return place->second;
    };
    std::vector<std::array<uint32_t, 3>> finer;
    for (const auto& [a, b, c] : faces) {
      const uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    faces = std::move(finer);
  }
  Scene scene;
  scene.materials = {Material{}};
  for (const auto& [a, b, c] : faces)
    scene.triangles.push_back(
        {{centre + radius * corners[a], centre + radius * corners[b], centre + radius * corners[c]}});
  scene.camera = {.eye = centre, .target = centre + dvec3(0, 0, radius)};
  return scene;
}

}  // namespace turner::hard
