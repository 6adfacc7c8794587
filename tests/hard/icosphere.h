// A closed convex mesh, and rays from inside that must hit it.
#pragma once

#include <array>
#include <glm/geometric.hpp>
#include <map>
#include <vector>

#include "hard/cases.h"
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
    scene.addTriangle({centre + radius * corners[a], centre + radius * corners[b], centre + radius * corners[c]});
  scene.camera = {.eye = centre, .target = centre + dvec3(0, 0, radius)};
  return scene;
}

// A ray from inside a closed mesh, aimed at a vertex, an edge or anywhere.
struct Aimed {
  Query query;
  size_t triangle;  // that has the aim
};

// A point of a triangle: a vertex, one on an edge, or one inside.
inline dvec3 aimAt(const TriangleCorners& v, int kind, Random& random) {
  const size_t corner = random() % 3;
  if (kind == 0) return v[corner];
  if (kind == 1) return v[corner] + uniform(random, 0, 1) * (v[(corner + 1) % 3] - v[corner]);
  const double s = std::sqrt(uniform(random, 0, 1)), u = uniform(random, 0, 1);
  return (1 - s) * v[0] + s * (1 - u) * v[1] + s * u * v[2];
}

inline Aimed aimedRay(const Scene& local, Random& random, const dvec3& centre, double radius) {
  Aimed aimed;
  aimed.triangle = random() % local.triangles.size();
  const dvec3 target = aimAt(local.cornersOf(aimed.triangle), int(random() % 3), random);
  aimed.query.ray.origin = vec3(centre + uniform(random, 0, 0.7) * radius * randomDirection(random));
  aimed.query.ray.direction = vec3(glm::normalize(target - dvec3(aimed.query.ray.origin)));
  return aimed;
}

}  // namespace turner::hard
