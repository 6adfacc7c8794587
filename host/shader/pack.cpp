// Numbers both kinds of primitives in the order of the leaves, and writes their rows.
#include "shader/pack.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <optional>
#include <tuple>
#include <utility>

#include "errors.h"
#include "picture/camera_basis.h"

namespace turner {
namespace {

using gpu::Row;
using gpu::uint;

Row row(const glm::dvec3& v, uint w = 0) {
  return {float(v.x), float(v.y), float(v.z), w};
}
Row row(const glm::dvec3& v, double w) {
  return row(v, std::bit_cast<uint>(float(w)));
}

// What a float leaves of a double: the low half of an unevaluated sum.
Row rowRest(const glm::dvec3& v, uint w = 0) {
  return row(v - glm::dvec3(float(v.x), float(v.y), float(v.z)), w);
}

glm::vec3 roundedDown(const glm::dvec3& v) {
  const auto down = [](double x) {
    const float f = float(x);
    return double(f) > x ? std::nextafterf(f, -INFINITY) : f;
  };
  return {down(v.x), down(v.y), down(v.z)};
}

glm::vec3 roundedUp(const glm::dvec3& v) {
  return -roundedDown(-v);
}

uint reference(const BvhChild& child, uint sphereCount) {
  if (child.count == 0) return child.first;
  const bool triangles = child.first >= sphereCount;
  return gpu::kRefLeaf | (triangles ? gpu::kRefTriangle : 0) | ((child.count - 1) << gpu::kRefCountShift) |
         (triangles ? child.first - sphereCount : child.first);
}

struct Plane {
  glm::dvec3 normal;  // unit, on the counter-clockwise side
  double offset;      // N.x of its points
};

// Nothing where the triangle has no area. The same for all orders of the same vertices but for the sign: coincident
// triangles are hit at equal distances then, and the lowest id wins.
std::optional<Plane> planeOf(std::array<glm::dvec3, 3> v) {
  const auto less = [](const glm::dvec3& a, const glm::dvec3& b) {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
  };
  double sign = 1;
  for (const auto& [i, j] : {std::pair<size_t, size_t>{0, 1}, {1, 2}, {0, 1}}) {
    if (!less(v[j], v[i])) continue;
    std::swap(v[i], v[j]);
    sign = -sign;
  }
  const glm::dvec3 cross = glm::cross(v[1] - v[0], v[2] - v[0]);
  const double length = glm::length(cross);
  if (length == 0) return {};
  const glm::dvec3 normal = cross / length;
  return Plane{sign * normal, sign * glm::dot(normal, v[0])};
}

gpu::Triangle packTriangle(const Triangle& triangle, uint id) {
  const auto& [a, b, c] = triangle.vertices;
  const std::optional<Plane> plane = planeOf(triangle.vertices);
  // One that rounding has made flat has no plane: as a point it is never hit.
  if (!plane) return {row(a, id), row(a, triangle.material), row(a, triangle.normals), {}};
  return {row(a, id), row(b, triangle.material), row(c, triangle.normals), row(plane->normal, plane->offset)};
}

Features featuresOf(const Scene& scene) {
  Features features;
  features.lights = uint32_t(scene.lights.size());
  features.spheres = !scene.spheres.empty();
  features.triangles = !scene.triangles.empty();
  for (const Light& light : scene.lights) features.falloff |= light.falloff != Falloff::none;

  std::vector<bool> used(scene.materials.size());
  for (const Sphere& sphere : scene.spheres) used[sphere.material] = true;
  for (const Triangle& triangle : scene.triangles) {
    used[triangle.material] = true;
    features.smoothNormals |= triangle.normals != kNoNormals;
  }
  for (size_t i = 0; i < used.size(); ++i) {
    if (!used[i]) continue;
    const Material& material = scene.materials[i];
    features.highlights |= material.localWeight > 0 && material.specular != glm::dvec3(0);
    features.reflection |= material.reflect > 0;
    features.refraction |= material.transmit > 0;
  }
  return features;
}

}  // namespace

size_t PackedScene::bytes() const {
  return nodes.size() * sizeof(gpu::Node) + spheres.size() * sizeof(gpu::Sphere) +
         triangles.size() * sizeof(gpu::Triangle) + vertexNormals.size() * sizeof(gpu::VertexNormals);
}

std::vector<Box> primitiveBoxes(const Scene& local) {
  struct Bounds {
    glm::dvec3 lo, hi;
  };
  std::vector<Bounds> exact;
  exact.reserve(local.spheres.size() + local.triangles.size());
  for (const Sphere& sphere : local.spheres)
    exact.push_back({sphere.center - std::abs(sphere.radius), sphere.center + std::abs(sphere.radius)});
  for (const Triangle& triangle : local.triangles) {
    const auto& [a, b, c] = triangle.vertices;
    exact.push_back({glm::min(a, glm::min(b, c)), glm::max(a, glm::max(b, c))});
  }

  Bounds scene{glm::dvec3(INFINITY), glm::dvec3(-INFINITY)};
  for (const Bounds& bounds : exact) scene = {glm::min(scene.lo, bounds.lo), glm::max(scene.hi, bounds.hi)};
  const glm::dvec3 size = scene.hi - scene.lo;
  const double extent = exact.empty() ? 0 : std::max({size.x, size.y, size.z});

  // A primitive test moves vertices by up to a rounding of their distance to the ray's origin, which is up to the
  // scene's extent; the slab test moves planes by a rounding of their coordinates. Four roundings of each cover both.
  std::vector<Box> boxes;
  boxes.reserve(exact.size());
  for (const Bounds& bounds : exact) {
    const glm::dvec3 pad = 0x1p-22 * (glm::max(glm::abs(bounds.lo), glm::abs(bounds.hi)) + extent);
    boxes.push_back({roundedDown(bounds.lo - pad), roundedUp(bounds.hi + pad)});
  }
  return boxes;
}

PackedScene packScene(const Scene& local, const Bvh& bvh) {
  const size_t most = gpu::kMaxPrimitivesOfAKind;
  if (local.spheres.size() > most || local.triangles.size() > most)
    throw InputError("the scene has more than " + std::to_string(most) + " spheres or triangles");
  if (bvh.depth > int(gpu::kMaxTreeDepth))
    throw RunError("the tree is " + std::to_string(bvh.depth) + " nodes deep, more than the kernel's stack holds");

  PackedScene packed;
  packed.features = featuresOf(local);
  packed.view = {local.camera, local.background};
  packed.treeDepth = bvh.depth;

  // Leaves name runs of one kind: number both kinds by themselves, each in the order of the leaves.
  const uint sphereCount = uint(local.spheres.size());
  std::vector<uint> place(bvh.order.size());  // of an entry of `order` among its kind
  packed.spheres.reserve(local.spheres.size());
  packed.triangles.reserve(local.triangles.size());
  for (size_t i = 0; i < bvh.order.size(); ++i) {
    const uint id = bvh.order[i];
    if (id < sphereCount) {
      place[i] = uint(packed.spheres.size());
      const Sphere& sphere = local.spheres[id];
      packed.spheres.push_back(
          {row(sphere.center, sphere.radius), {std::bit_cast<float>(id), std::bit_cast<float>(sphere.material), 0, 0}});
    } else {
      place[i] = sphereCount + uint(packed.triangles.size());
      const Triangle& triangle = local.triangles[id - sphereCount];
      packed.triangles.push_back(packTriangle(triangle, id));
    }
  }
  const auto packedReference = [&](BvhChild child) {
    if (child.count > 0) child.first = place[child.first];
    return reference(child, sphereCount);
  };
  packed.nodes.reserve(bvh.nodes.size());
  for (const Bvh::Node& node : bvh.nodes) {
    const auto& [a, b] = node.children;
    packed.nodes.push_back(
        {row(a.box.lo, packedReference(a)), row(a.box.hi, packedReference(b)), row(b.box.lo), row(b.box.hi)});
  }
  if (!bvh.order.empty()) packed.view.root = packedReference(bvh.root);

  for (const auto& [a, b, c] : local.normals) packed.vertexNormals.push_back({row(a), row(b), row(c)});
  for (const Material& material : local.materials)
    packed.materials.push_back({row(material.diffuse, material.reflect), row(material.specular, material.transmit),
                                row({material.shininess, material.ior, material.localWeight})});
  for (const Light& light : local.lights)
    packed.lights.push_back({row(light.position, uint(light.falloff == Falloff::inverseSquare)), row(light.color)});
  return packed;
}

gpu::Frame packFrame(const View& view, const RenderSettings& settings, uint32_t deviceThreads) {
  const CameraBasis basis = cameraBasis(view.camera);
  const double pixel = 2 * basis.tanHalfFov / settings.height;
  const glm::dvec3 perRight = pixel * basis.right, perDown = -pixel * basis.up;

  gpu::Frame frame;
  frame.centreHi = row(basis.forward, view.root);
  frame.centreLo = rowRest(basis.forward, uint(settings.width));
  frame.rightHi = row(perRight, uint(settings.height));
  frame.rightLo = rowRest(perRight, settings.seed);
  frame.downHi = row(perDown, settings.weightLimit());
  frame.downLo = rowRest(perDown, deviceThreads);
  frame.background = row(view.background, gpu::kCanaryLength);
  return frame;
}

}  // namespace turner
