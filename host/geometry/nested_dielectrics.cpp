// Finds the solids of glass, keeps those that touch something, and sorts them by priority.
#include "geometry/nested_dielectrics.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <numbers>
#include <type_traits>
#include <vector>

#include "geometry/nested_dielectrics/closed_surfaces.h"
#include "geometry/nested_dielectrics/contacts.h"
#include "geometry/nested_dielectrics/solids.h"

namespace turner {

bool hasGlass(const Scene& scene) {
  return std::any_of(scene.materials.begin(), scene.materials.end(), [](const Material& m) { return m.transmit > 0; });
}

double facing(const Scene& scene, const Triangle& triangle) {
  if (!triangle.isSmooth()) return 1;
  const auto [a, b, c] = scene.cornersOf(triangle);
  const TriangleCorners n = scene.normalsOf(triangle);
  return glm::dot(glm::cross(b - a, c - a), n[0] + n[1] + n[2]) < 0 ? -1 : 1;
}

namespace {

using glm::dvec3;
using nested_dielectrics::Solid, nested_dielectrics::Surface;

// How often a surface goes around a point: 1 or -1 inside, 0 outside.
double windingNumber(const Scene& scene, const Surface& surface, const dvec3& p) {
  if (surface.sphere != kNoMedium) {
    const Sphere& sphere = scene.spheres[surface.sphere];
    const long double radius = (long double)(sphere.radius) + sphere.radiusRest;
    const double sign = sphere.radius < 0 ? -1 : 1;
    return glm::length(wide3(p) - wide3(sphere.center)) < std::abs(radius) ? sign : 0;
  }
  // Solid angles: Van Oosterom and Strackee, IEEE Transactions on Biomedical Engineering 30(2), 1983.
  double angle = 0;
  for (const uint32_t i : surface.triangles) {
    const TriangleCorners v = scene.cornersOf(i);
    const dvec3 a = v[0] - p, b = v[1] - p, c = v[2] - p;
    const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
    angle += facing(scene, scene.triangles[i]) * 2 *
             std::atan2(glm::dot(a, glm::cross(b, c)),
                        la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb);
  }
  return angle / (4 * std::numbers::pi);
}

// What a material is but for its name, as float32 has it.
std::vector<float> valuesOf(const Material& material) {
  std::vector<float> values;
  const auto put = [&](double value) { values.push_back(float(value)); };
  Material::visitValues(material, [&](const auto& value) {
    if constexpr (std::is_same_v<std::decay_t<decltype(value)>, double>)
      put(value);
    else
      put(value.x), put(value.y), put(value.z);
  });
  return values;
}

}  // namespace

NestedDielectrics findNestedDielectrics(const Scene& scene) {
  const std::vector<Surface> surfaces = nested_dielectrics::closedSurfaces(scene);
  const std::vector<Solid> solids = solidsOf(surfaces);
  std::vector<bool> marked(solids.size());
  markMeeting(scene, solids, marked);
  markOnOpaque(scene, solids, marked);
  std::vector<uint32_t> order;
  for (uint32_t k = 0; k < solids.size(); ++k)
    if (marked[k]) order.push_back(k);
  NestedDielectrics result;
  if (order.empty()) return result;

  // Volumes that differ by rounding are the same: the exact and the rounded scene are to agree.
  const auto volumeClass = [&](uint32_t k) { return std::lround(1024 * std::log2(solids[k].outer().volume)); };
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
    const long va = volumeClass(a), vb = volumeClass(b);
    return va != vb ? va > vb : solids[a].outer().firstId < solids[b].outer().firstId;
  });
  result.ofSpheres.assign(scene.spheres.size(), kNoMedium);
  result.ofTriangles.assign(scene.triangles.size(), kNoMedium);
  std::map<std::vector<float>, uint32_t> glasses;
  for (uint32_t rank = 0; rank < order.size(); ++rank) {
    const Solid& solid = solids[order[rank]];
    result.materials.push_back(solid.outer().material);
    result.glasses.push_back(
        glasses.try_emplace(valuesOf(scene.materials[solid.outer().material]), uint32_t(glasses.size())).first->second);
    forPrimitives(scene, solid, [&](uint32_t id, const Bounds&) {
      if (id < scene.spheres.size())
        result.ofSpheres[id] = rank;
      else
        result.ofTriangles[id - scene.spheres.size()] = rank;
    });
    double winding = 0;
    for (const Surface* surface : solid.surfaces) winding += windingNumber(scene, *surface, scene.camera.eye);
    if (winding > 0.5) result.aroundEye.push_back(rank);
  }
  return result;
}

}  // namespace turner
