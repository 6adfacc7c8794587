#include "support/bumpy_spheres.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <glm/geometric.hpp>

#include "base/errors.h"

namespace turner::test {
namespace {

using glm::dvec3;

enum MaterialNumber : uint32_t { kFloor, kClay, kMoss, kStraw, kSlate, kMirror };

struct Ball {
  dvec3 center;
  double radius;
  uint32_t material;
};

constexpr std::array<Ball, 5> kBalls = {{{{0, 1.1, -0.5}, 1, kMirror},
                                         {{-2.1, 0.9, 0.2}, 0.8, kClay},
                                         {{2.1, 0.95, 0}, 0.85, kMoss},
                                         {{-0.9, 0.6, 1.6}, 0.5, kStraw},
                                         {{1, 0.55, 1.7}, 0.45, kSlate}}};

// A number in [0, 1) for a point of the integer lattice: rounds of multiply and shift, each of which can be undone.
double latticeValue(int x, int y, int z, uint32_t seed) {
  uint32_t h = seed;
  for (const int word : {x, y, z}) {
    h = (h ^ uint32_t(word)) * 0x9E3779B1u;
    h = (h ^ (h >> 15)) * 0x85EBCA77u;
    h ^= h >> 13;
  }
  return double(h) * 0x1p-32;
}

// The lattice's values, interpolated smoothly between its points.
double valueNoise(const dvec3& p, uint32_t seed) {
  const dvec3 cell(std::floor(p.x), std::floor(p.y), std::floor(p.z));
  const dvec3 f = p - cell, s = f * f * (3.0 - 2.0 * f);
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int i = corner & 1, j = corner >> 1 & 1, k = corner >> 2;
    const double weight = (i ? s.x : 1 - s.x) * (j ? s.y : 1 - s.y) * (k ? s.z : 1 - s.z);
    sum += weight * latticeValue(int(cell.x) + i, int(cell.y) + j, int(cell.z) + k, seed);
  }
  return sum;
}

// A cube of n x n cells to a side, blown up to a sphere. The point of a lattice place depends on its three integers
// alone, so that the sides meet without a gap.
void addBall(BumpyMesh& mesh, const Ball& ball, int n, uint32_t seed) {
  const auto coordinate = [n](int i) {
    const double t = double(2 * i - n) / n;
    return t * (0.8 + 0.2 * t * t);  // evens out the cells, which the projection would shrink toward the edges
  };
  const auto point = [&](int i, int j, int k) {
    const dvec3 d = glm::normalize(dvec3(coordinate(i), coordinate(j), coordinate(k)));
    const double bumps = 0.12 * valueNoise(4.0 * d, seed) + 0.03 * valueNoise(13.0 * d, seed + 1);
    return ball.center + ball.radius * (0.9 + bumps) * d;
  };
  for (int side = 0; side < 6; ++side) {
    const int axis = side / 2;
    const bool upper = side % 2 == 1;
    const uint32_t first = uint32_t(mesh.positions.size());
    for (int v = 0; v <= n; ++v)
      for (int u = 0; u <= n; ++u) {
        std::array<int, 3> place{};
        place[axis] = upper ? n : 0;
        place[(axis + 1) % 3] = u;
        place[(axis + 2) % 3] = v;
        mesh.positions.push_back(point(place[0], place[1], place[2]));
      }
    const uint32_t row = uint32_t(n) + 1;
    for (uint32_t v = 0; v < uint32_t(n); ++v)
      for (uint32_t u = 0; u < uint32_t(n); ++u) {
        const uint32_t a = first + v * row + u, b = a + 1, c = a + row, d = c + 1;
        if (upper) {
          mesh.faces.push_back({{a, b, d}, ball.material});
          mesh.faces.push_back({{a, d, c}, ball.material});
        } else {
          mesh.faces.push_back({{a, d, b}, ball.material});
          mesh.faces.push_back({{a, c, d}, ball.material});
        }
      }
  }
}

}  // namespace

BumpyMesh bumpyMesh(size_t triangles) {
  const int n = std::max(1, int(std::lround(std::sqrt(double(triangles) / double(12 * kBalls.size())))));
  BumpyMesh mesh;
  mesh.positions.reserve(6 * kBalls.size() * size_t(n + 1) * size_t(n + 1) + 4);
  mesh.faces.reserve(12 * kBalls.size() * size_t(n) * size_t(n) + 2);
  uint32_t seed = 1;
  for (const Ball& ball : kBalls) {
    addBall(mesh, ball, n, seed);
    seed += 2;
  }
  const uint32_t first = uint32_t(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), {{-8, 0, 5}, {8, 0, 5}, {8, 0, -9}, {-8, 0, -9}});
  mesh.faces.push_back({{first, first + 1, first + 2}, kFloor});
  mesh.faces.push_back({{first, first + 2, first + 3}, kFloor});
  return mesh;
}

Scene bumpySpheres(size_t triangles) {
  Scene scene;
  scene.name = fmt::format("bumpy-{}", triangles);
  scene.background = {0.4, 0.5, 0.65};
  scene.camera = {.eye = {0, 2.6, 8}, .target = {0, 0.75, 0}, .fov = 32};
  scene.lights = {{.position = {-4, 8, 6}}};
  scene.materials = {{.name = "floor", .diffuse = {0.6, 0.58, 0.54}},
                     {.name = "clay", .diffuse = {0.72, 0.3, 0.18}},
                     {.name = "moss", .diffuse = {0.3, 0.46, 0.16}},
                     {.name = "straw", .diffuse = {0.86, 0.68, 0.3}},
                     {.name = "slate", .diffuse = {0.2, 0.26, 0.36}},
                     {.name = "mirror", .diffuse = {0.2, 0.2, 0.2}, .reflect = 0.8, .localWeight = 0.2}};
  BumpyMesh mesh = bumpyMesh(triangles);
  scene.positions = std::move(mesh.positions);
  scene.triangles.reserve(mesh.faces.size());
  for (const auto& [v, material] : mesh.faces) scene.triangles.push_back({.positions = v, .material = material});
  return scene;
}

void writeBumpyObj(const std::string& path, size_t triangles) {
  const BumpyMesh mesh = bumpyMesh(triangles);
  std::ofstream file(path, std::ios::binary);
  std::string text;
  const auto flushAt = [&](size_t bytes) {
    if (text.size() < bytes) return;
    file << text;
    text.clear();
  };
  for (const dvec3& p : mesh.positions) {
    fmt::format_to(std::back_inserter(text), "v {:.9g} {:.9g} {:.9g}\n", p.x, p.y, p.z);
    flushAt(1 << 20);
  }
  for (const auto& [v, material] : mesh.faces) {
    fmt::format_to(std::back_inserter(text), "f {} {} {}\n", v[0] + 1, v[1] + 1, v[2] + 1);
    flushAt(1 << 20);
  }
  flushAt(0);
  file.close();
  if (!file) throw RunError("cannot write '" + path + "'");
}

}  // namespace turner::test
