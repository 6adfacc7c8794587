// Whitted's ray tracer, recursive and in double precision: what light comes back along a ray.
// Comes in: the scene and an eye ray. Goes out: radiance, and the count of the rays of its tree. Knows nothing of
// pixels and cores.
#pragma once

#include <stop_token>

#include "image/settings.h"
#include "reference/aggregate.h"
#include "reference/nested_dielectrics.h"
#include "scene/scene.h"

namespace turner::reference {

class Whitted {
 public:
  // The aggregate and the settings outlive it. When `itsStop` is requested all radiance is 0.
  Whitted(const Aggregate& itsAggregate, const RenderSettings& itsSettings, std::stop_token itsStop);

  // What the eye sees in this direction, a unit vector. Throws RunError where a ray does not find out of nested glass.
  dvec3 eyeRadiance(const dvec3& direction);

  RayCounts counts;  // of all rays so far

 private:
  dvec3 radiance(Ray ray, Media media, int level, double weight);
  dvec3 shade(const Ray& ray, const Surface& surface, const Media& media, const Crossing& crossing, int level,
              double weight);
  dvec3 localIllumination(const Surface& surface, const dvec3& V);
  dvec3 childRadiance(const Surface& surface, const dvec3& direction, const Media& media, int level, double weight,
                      uint64_t& count);

  const Aggregate& aggregate;
  const Scene& scene;
  const RenderSettings& settings;
  std::stop_token stop;
  Media eyeMedia;  // that the eye is in
};

}  // namespace turner::reference
