// Searches the tree, or all primitives, for hits; then puts the hit point back on the surface, as exactly as doubles
// go.
#include "reference/aggregate.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <type_traits>

namespace turner::reference {
namespace {

template <class Primitive>
constexpr bool isTriangle = std::is_same_v<std::decay_t<Primitive>, Triangle>;
template <class List>
constexpr bool isTriangles = isTriangle<typename std::decay_t<List>::value_type>;

}  // namespace

Aggregate::Aggregate(const Scene& itsScene, ReferenceSearch search)
    : scene(itsScene), dielectrics(findNestedDielectrics(itsScene)), bruteForce(search == ReferenceSearch::bruteForce) {
  double largestCoordinate = largestSize(scene.camera.eye);
  std::vector<Box> boxes;
  boxes.reserve(primitiveCount());
  Scene::visitPrimitives(scene, [&](const char*, const auto& primitives) {
    if constexpr (!isTriangles<decltype(primitives)>)
      for (const auto& primitive : primitives) boxes.push_back(boxOf(primitive));
  });
  faceNormals.reserve(scene.triangles.size());
  for (const Triangle& triangle : scene.triangles) {
    const TriangleCorners corners = scene.cornersOf(triangle);
    faceNormals.push_back(faceNormal(corners));
    boxes.emplace_back();
    for (const dvec3& vertex : corners) boxes.back().include(vertex);
  }
  for (const Box& box : boxes)
    largestCoordinate = std::max({largestCoordinate, largestSize(box.low), largestSize(box.high)});
  if (bruteForce) boxes.clear();
  // Rays start within these coordinates. The slack is 512 roundings of the largest: tests of primitives need few.
  tree = BoxTree(boxes, 512 * kRounding * largestCoordinate);
}

const Material& Aggregate::materialOf(uint32_t primitive) const {
  return scene.visitPrimitive(primitive,
                              [&](const auto& p, size_t) -> const Material& { return scene.materials[p.material]; });
}

uint32_t Aggregate::mediumOf(uint32_t primitive) const {
  if (dielectrics.empty() || primitive == kNoPrimitive) return kNoMedium;
  if (isSphere(primitive)) return dielectrics.ofSpheres[primitive];
  return primitive < firstTriangle() ? kNoMedium : dielectrics.ofTriangles[primitive - firstTriangle()];
}

// ---- What a ray hits ----

// Calls visit(primitive) for all that the ray may hit within `limit`; what it returns is the limit from then on.
template <class Visit>
void Aggregate::forCandidates(const Ray& ray, double limit, Visit&& visit) const {
  if (!bruteForce) return tree.traverse(ray.origin, ray.direction, limit, visit);
  for (uint32_t primitive = 0; primitive < primitiveCount(); ++primitive) visit(primitive);
}

double Aggregate::intersect(const Ray& ray, uint32_t primitive) const {
  const bool startsOnIt = primitive == ray.originPrimitive;
  return scene.visitPrimitive(primitive, [&](const auto& p, size_t index) {
    if constexpr (isTriangle<decltype(p)>)
      // A triangle is flat: a ray that starts on it never comes back to it.
      return startsOnIt ? kFarAway : intersectTriangle(ray, scene, p, faceNormals[index]);
    else
      return reference::intersect(ray, p, startsOnIt);
  });
}

// Among coincident primitives the lowest rank is hit: opaque ones, then glass that is no medium, then the media by
// their priority; then the lowest number.
std::pair<int64_t, uint32_t> Aggregate::rank(uint32_t primitive) const {
  if (materialOf(primitive).transmit <= 0) return {-2, primitive};
  const uint32_t medium = mediumOf(primitive);
  return {medium == kNoMedium ? int64_t(-1) : int64_t(kNoMedium) - medium, primitive};
}

// How far along the ray another interface may be that coincides with this one: 48 roundings of float32 to the side, of
// its distance from the eye.
double Aggregate::coincidenceDistance(const Ray& ray, double t, uint32_t primitive) const {
  const dvec3 x = ray.origin + t * ray.direction;
  const dvec3 normal = isSphere(primitive) ? (x - scene.spheres[primitive].center) / scene.spheres[primitive].radius
                                           : faceNormals[primitive - firstTriangle()];
  const double cosine = std::abs(glm::dot(normal, ray.direction));
  return 48 * 0x1p-24 * glm::length(x - scene.camera.eye) / std::max(cosine, 0x1p-10);
}

Hit Aggregate::closestHit(const Ray& ray) const {
  Hit nearest;
  forCandidates(ray, nearest.t, [&](uint32_t primitive) {
    const double t = intersect(ray, primitive);
    if (t < nearest.t || (t == nearest.t && t < kFarAway && rank(primitive) < rank(nearest.primitive)))
      nearest = {t, primitive, {}};
    return nearest.t;
  });
  if (mediumOf(nearest.primitive) == kNoMedium) return nearest;

  // All that coincides with it: interfaces of media, and within a quarter of the distance everything else.
  const double apart = coincidenceDistance(ray, nearest.t, nearest.primitive);
  Hit hit = nearest;
  forCandidates(ray, nearest.t + apart, [&](uint32_t primitive) {
    const double t = intersect(ray, primitive);
    const bool isInterface = mediumOf(primitive) != kNoMedium;
    if (t > nearest.t + (isInterface ? apart : 0.25 * apart)) return nearest.t + apart;
    if (isInterface) hit.interfaces.push_back(primitive);
    if (rank(primitive) < rank(hit.primitive)) hit.t = t, hit.primitive = primitive;
    return nearest.t + apart;
  });
  return hit;
}

bool Aggregate::isOccluded(const Ray& ray, double end) const {
  bool found = false;
  forCandidates(ray, end, [&](uint32_t primitive) {
    found = found || intersect(ray, primitive) < end;
    return found ? -1 : end;
  });
  return found;
}

// ---- The surface there ----

Surface Aggregate::surfaceAt(const Ray& ray, const Hit& hit) const {
  Surface surface = scene.visitPrimitive(hit.primitive, [&](const auto& p, size_t index) {
    if constexpr (isTriangle<decltype(p)>)
      return triangleSurface(ray, hit.t, index);
    else
      return surfaceOf(ray, hit.t, p);
  });
  surface.material = &materialOf(hit.primitive);
  surface.primitive = hit.primitive;
  // A back hit flips both normals; Ns must look at V too.
  const dvec3 V = -ray.direction;
  surface.front = glm::dot(surface.Ng, V) > 0;
  if (!surface.front) {
    surface.Ng = -surface.Ng;
    surface.Ns = -surface.Ns;
  }
  if (glm::dot(surface.Ns, V) <= 0) surface.Ns = surface.Ng;
  return surface;
}

Surface Aggregate::triangleSurface(const Ray& ray, double t, size_t index) const {
  const Triangle& triangle = scene.triangles[index];
  const TriangleCorners corners = scene.cornersOf(triangle);
  Surface surface;
  surface.Ng = surface.Ns = faceNormals[index];
  // Put the point back on the plane.
  surface.point = ray.origin + t * ray.direction;
  surface.point -= glm::dot(surface.point - corners[0], surface.Ng) * surface.Ng;
  // The point, its difference to a vertex, the normal and the product with it: each errs by a few roundings of the
  // coordinates.
  double size = largestSize(surface.point);
  for (const dvec3& vertex : corners) size = std::max(size, largestSize(vertex));
  surface.errorBound = 16 * kRounding * size;

  if (triangle.isSmooth()) {
    const TriangleCorners normals = scene.normalsOf(triangle);
    const dvec3 weight = edgeAreas(ray, scene, triangle);
    dvec3 sum(0);
    for (int k = 0; k < 3; ++k) sum += weight[k] / (weight.x + weight.y + weight.z) * glm::normalize(normals[k]);
    if (glm::dot(sum, sum) > 0) surface.Ns = glm::normalize(sum);
    if (glm::dot(surface.Ng, surface.Ns) < 0) surface.Ng = -surface.Ng;
  }
  return surface;
}

// ---- Media ----

// By the triangle as a whole, whose vertex normals may look to both sides.
bool Aggregate::entersMedium(const Ray& ray, double t, uint32_t primitive) const {
  if (isSphere(primitive)) return surfaceAt(ray, {t, primitive, {}}).front;
  const size_t index = primitive - firstTriangle();
  const Triangle& triangle = scene.triangles[index];
  dvec3 front = faceNormals[index];
  if (triangle.isSmooth()) {
    const TriangleCorners n = scene.normalsOf(triangle);
    if (glm::dot(front, n[0] + n[1] + n[2]) < 0) front = -front;
  }
  return glm::dot(front, ray.direction) < 0;
}

// Counts on the way from the point to infinity how often each medium is left, less how often it is entered. The
// direction is one that meets no edge of a scene but by bad luck.
std::vector<uint32_t> Aggregate::mediaAt(const dvec3& point) const {
  const Ray ray = makeRay(point, glm::normalize(dvec3(0.6180339887, 0.7320508076, 0.4142135624)), kNoPrimitive);
  std::vector<int> leaves(dielectrics.materials.size());
  if (leaves.empty()) return {};
  forCandidates(ray, kFarAway, [&](uint32_t primitive) {
    const uint32_t medium = mediumOf(primitive);
    const double t = medium == kNoMedium ? kFarAway : intersect(ray, primitive);
    // A sphere that the point is not in is entered as often as it is left.
    const bool counts = t < kFarAway && (!isSphere(primitive) || isInside(point, scene.spheres[primitive]));
    if (counts) leaves[medium] += entersMedium(ray, t, primitive) ? -1 : 1;
    return kFarAway;
  });
  std::vector<uint32_t> media;
  for (uint32_t medium = 0; medium < leaves.size(); ++medium)
    if (leaves[medium] > 0) media.push_back(medium);
  return media;
}

}  // namespace turner::reference
