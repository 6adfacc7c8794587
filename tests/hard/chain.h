// Rays that are followed from surface to surface, and how far they end up from where they should.
#pragma once

#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "hard/cases.h"
#include "hard/vectors.h"

namespace turner::hard {

inline constexpr float kUsualEpsilon = 1e-4f;  // the naive tracer's, where it follows rays

// The largest of some values. A NaN among them is what remains.
struct Worst {
  double value = 0;
  void add(double next) {
    if (!std::isnan(value) && !(next <= value)) value = next;
  }
};

// One figure of both tracers.
template <class T>
struct Both {
  T turner{}, naive{};
  T& of(Tracer tracer) { return tracer == Tracer::turner ? turner : naive; }
};

inline constexpr Tracer kTracers[] = {Tracer::turner, Tracer::naive};

// The angle between two directions of any length, to the last digits also where it is small.
inline double angleBetween(const dvec3& a, const dvec3& b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

inline bool isFinite(const vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// What each ray meets, and the ray that goes on from there.
inline std::vector<Found> stepFrom(Kernels& kernels, const std::vector<TestRay>& rays, Next next, Tracer tracer) {
  std::vector<Query> queries;
  queries.reserve(rays.size());
  for (const TestRay& ray : rays) queries.push_back({.ray = ray, .next = next});
  return kernels.trace(queries, tracer);
}

}  // namespace turner::hard
