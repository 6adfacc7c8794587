// A Whitted tracer in double precision by brute force, of which each step can be replaced: the twin of an edited
// kernel. Knows the light transport and the scene, and nothing of kernel or reference.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "image/image.h"
#include "image/settings.h"
#include "scene/scene.h"

namespace turner::test {

struct TwinRay {
  glm::dvec3 origin{0}, direction{0, 0, 1};
  std::optional<size_t> leaving;  // the primitive that it starts on
};

struct TwinHit {
  double t = 0;
  size_t primitive = 0;  // id: spheres, then triangles
  glm::dvec3 point{0}, Ng{0}, N{0};
  bool front = true;
  Material material;
};

// What an edit needs to know of where it is in the tree of rays.
struct TwinPath {
  uint32_t x = 0, y = 0;  // pixel
  uint32_t level = 1;
};

class Twin {
 public:
  // `local`: the result of roundScene, of spheres and triangles without overlapping glass. One sample in each pixel.
  Twin(const Scene& local, const RenderSettings& settings) : scene(local), settings_(settings) {}
  virtual ~Twin() = default;

  // The colour of a point of the picture, in pixels from its corner; the pixel that it belongs to is told apart, so
  // that the random numbers stay while the point is moved.
  glm::dvec3 at(int x, int y, const glm::dvec2& point) const;

 protected:
  // From the eye through a point of the picture.
  TwinRay cameraRay(const glm::dvec2& point) const;
  glm::dvec2 middle() const { return 0.5 * glm::dvec2(settings_.width, settings_.height); }
  std::optional<TwinHit> nearest(const TwinRay& ray) const;
  bool isBlocked(const TwinRay& ray, double end) const;
  // Starts on the hit's surface.
  TwinRay leave(const TwinHit& hit, const glm::dvec3& direction) const { return {hit.point, direction, hit.primitive}; }

  // --- what an edit replaces ---
  virtual TwinRay eyeRay(const glm::dvec2& point, const TwinPath& path) const;
  virtual Material materialOf(const TwinHit& hit, const TwinPath& path) const;
  virtual std::vector<Light> lightsOf(const TwinHit& hit, const TwinPath& path) const;
  // How much of a light arrives: 0 or 1.
  virtual double visibility(const TwinHit& hit, const Light& light, const TwinPath& path) const;
  virtual glm::dvec3 reflected(const TwinHit& hit, const glm::dvec3& direction, const TwinPath& path) const;
  // In place of a hit: another ray to follow.
  virtual std::optional<TwinRay> passOn(const TwinHit& hit, const TwinRay& ray, const TwinPath& path) const;
  virtual bool goesDeeper(uint32_t level) const { return level < uint32_t(settings_.depth); }
  glm::dvec3 lit(const TwinHit& hit, const glm::dvec3& V, const Light& light) const;

  const Scene& scene;

 private:
  glm::dvec3 radiance(const TwinRay& ray, TwinPath path) const;
  RenderSettings settings_;
};

// pcg4d (Jarzynski and Olano, JCGT 9(3), 2020), as the kernel's hash4().
std::array<uint32_t, 4> twinHash(std::array<uint32_t, 4> v);
// Three numbers from 0 to 1, as vec3(hash4(...).xyz >> 8u) / 16777216.0 has them.
glm::dvec3 twinRandom(uint32_t x, uint32_t y, uint32_t z, uint32_t w);

// The share of pixels of the kernel's picture that lie off the twin's edges, and the p99 of their errors: an edge is
// where the twin itself changes by more than `edge` within a 512th of a pixel.
struct TwinComparison {
  double offEdges = 0, p99 = 0, max = 0;
};
TwinComparison compareWithTwin(const Image& picture, const Twin& twin, double edge = 2e-3);

}  // namespace turner::test
