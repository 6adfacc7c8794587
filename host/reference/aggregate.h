// The scene as rays see it: which primitive is hit first, whether anything is hit at all, and the surface at a hit.
// Comes in: a scene and rays. Goes out: hits and surfaces. Knows nothing of light.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "geometry/nested_dielectrics.h"
#include "reference/box_tree.h"
#include "reference/intersect.h"
#include "reference/precision.h"
#include "reference/reference.h"
#include "scene/scene.h"

namespace turner::reference {

// The nearest primitive on a ray.
struct Hit {
  double t = kFarAway;
  uint32_t primitive = kNoPrimitive;
  std::vector<uint32_t> interfaces;  // of nested dielectrics: the primitives that coincide with this hit
};

class Aggregate {
 public:
  // `itsScene` outlives it.
  Aggregate(const Scene& itsScene, ReferenceSearch search);

  // The nearest hit; among coincident primitives that of the lowest rank.
  Hit closestHit(const Ray& ray) const;

  // Whether anything lies on the ray nearer than `end`.
  bool isOccluded(const Ray& ray, double end) const;

  Surface surfaceAt(const Ray& ray, const Hit& hit) const;

  // The medium, an index into `dielectrics`, that the primitive is an interface of, or kNoMedium.
  uint32_t mediumOf(uint32_t primitive) const;

  // Whether the ray, which hits an interface of a medium at t, enters the medium there.
  bool entersMedium(const Ray& ray, double t, uint32_t primitive) const;

  // The media that the point is in, ascending.
  std::vector<uint32_t> mediaAt(const dvec3& point) const;

  const Scene& scene;
  const NestedDielectrics dielectrics;

 private:
  bool isSphere(uint32_t primitive) const { return primitive < scene.spheres.size(); }
  size_t primitiveCount() const { return scene.primitiveCount(); }
  size_t firstTriangle() const { return scene.primitiveCount() - scene.triangles.size(); }
  const Material& materialOf(uint32_t primitive) const;

  double intersect(const Ray& ray, uint32_t primitive) const;
  double coincidenceDistance(const Ray& ray, double t, uint32_t primitive) const;
  std::pair<int64_t, uint32_t> rank(uint32_t primitive) const;
  template <class Visit>
  void forCandidates(const Ray& ray, double limit, Visit&& visit) const;

  Surface triangleSurface(const Ray& ray, double t, size_t index) const;

  bool bruteForce;
  std::vector<dvec3> faceNormals;
  BoxTree tree{{}, 0};
};

}  // namespace turner::reference
