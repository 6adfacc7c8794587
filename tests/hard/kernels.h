// Runs the shader's own functions over many rays: each ray goes through the whole tree and back by the includes of
// shaders/, and can be followed from surface to surface. Beside it the same for a naive float32 tracer.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "accel/bvh.h"
#include "gpu/devices.h"
#include "layout.h"
#include "scene/scene.h"

namespace turner::hard {

inline constexpr uint32_t kNothing = UINT32_MAX;

// A ray, in the float32 that the kernel gets.
struct TestRay {
  glm::vec3 origin{0};
  glm::vec3 direction{0, 0, 1};
  uint32_t leaving = kNothing;               // what Found::leaving says; kNothing: it starts in the open
  std::array<uint32_t, 4> dielectrics = {};  // that it is in, as the kernel has them
};

// What becomes of a ray at its nearest hit.
enum class Next : uint32_t { none, direction, light, reflected, transmitted };

struct Query {
  TestRay ray;
  float end = 0;  // > 0: any hit nearer than this is looked for, not the nearest
  Next next = Next::none;
  glm::vec3 target{0};  // the direction in which the next ray goes, or the light that it goes to
};

struct Found {
  float t;      // > 1e37: nothing is hit. Without meaning where any hit was looked for
  uint32_t id;  // of the primitive; kNothing: none is hit
  bool front;   // the hit is on the front
  glm::vec3 point;
  float margin;  // how far along Ng the next ray starts
  glm::vec3 Ng, Ns;
  uint32_t material;
  bool hidden;      // transmitted where nothing is seen of the wall
  bool leaves;      // there is a next ray: no total internal reflection, the light faces the surface
  TestRay leaving;  // it
  bool hits() const { return id != kNothing; }
};

// Which tracer: the shader's functions, or textbook formulas (kernels/naive.comp).
enum class Tracer { turner, naive };

class Kernels {
 public:
  // Opens the device that TURNER_DEVICE names, else the best one, and compiles both kernels. Throws without a device.
  Kernels();
  // On this device, and by the sources in `folder`, which has shaders/ and tests/hard/kernels/.
  Kernels(const DeviceInfo& device, const std::string& folder);
  ~Kernels();

  std::string deviceName() const;

  // The scene that rays are traced in from now on, as the renderer makes it: `world` is moved so that its camera's eye
  // is the origin, scaled and rounded. `bvh` replaces the renderer's tree.
  void setScene(const Scene& world);
  // The same with a tree of the test's.
  using BuildTree = std::function<Bvh(std::span<const Box>, const KindStarts&, const BvhLimits&)>;
  void setScene(const Scene& world, const BuildTree& build);
  // What the kernel has: the result of roundScene.
  const Scene& local() const;
  // The solids that its eye is in, as a ray has them.
  std::array<uint32_t, 4> mediaAroundEye() const;
  // For the naive tracer: hits at this distance or nearer do not count.
  void setLeastDistance(float least);

  // Traces all queries. Throws RunError where one does not come to its end.
  std::vector<Found> trace(std::span<const Query> queries, Tracer tracer = Tracer::turner);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace turner::hard
