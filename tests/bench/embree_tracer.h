// The peer of the benchmark: the light transport of docs/light_transport.md as an Embree user would write it. Single
// rays (rtcIntersect1, rtcOccluded1), float32, recursive, on all cores.
//
// Comes in: a scene from roundScene, so that both tracers see the same numbers. Goes out: the picture, the count of its
// rays and the time that they took. It must not know how Turner's kernel works. Embree appears in embree_tracer.cpp
// only.
#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "image/image.h"
#include "image/settings.h"
#include "scene/scene.h"

namespace turner::test {

struct EmbreePicture {
  Image image;
  RayCounts rays;
  double traceSeconds = 0;  // from the first thread's start to the last one's end, by the host's clock
};

class EmbreeTracer {
 public:
  // Builds Embree's tree with all cores. Throws RunError when Embree fails.
  explicit EmbreeTracer(const Scene& local);
  ~EmbreeTracer();
  EmbreeTracer(const EmbreeTracer&) = delete;
  EmbreeTracer& operator=(const EmbreeTracer&) = delete;

  double commitSeconds() const;  // of rtcCommitScene alone
  size_t bytes() const;          // of the tree, the triangles' vertices and the spheres

  // One sample in each pixel's centre, no least weight: throws InputError for other settings.
  EmbreePicture render(const RenderSettings& settings) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

// "3.13.5"
std::string embreeVersion();

}  // namespace turner::test
