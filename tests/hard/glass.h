// Scenes of glass, rays that are followed through it, and Snell's law in double.
#pragma once

#include <cmath>
#include <vector>

#include "hard/cases.h"
#include "hard/chain.h"
#include "support/closed_form.h"

namespace turner::hard {

inline constexpr double kIor = 1.5;  // of most glass here; float32 has it exactly

// An eye and a target at a distance of exactly 1, so that local coordinates are those of the world less the eye.
inline Scene sceneSeenFrom(const dvec3& eye, double eta) {
  Scene scene;
  scene.camera = {.eye = eye, .target = eye + dvec3(0, 0, 1)};
  closed_form::addMaterial(scene, closed_form::glass(0, 1, eta));
  return scene;
}

inline TestRay rayThrough(const dvec3& point, const dvec3& direction, double before) {
  return {.origin = vec3(point - before * direction), .direction = vec3(direction)};
}

// How far a ray passes a sphere's centre, in the sphere's radii: the sine of the angle at which it meets the sphere.
inline double impact(const TestRay& ray, const Sphere& sphere) {
  const dvec3 f = dvec3(ray.origin) - sphere.center, d(ray.direction);
  return glm::length(glm::cross(f, d)) / glm::length(d) / std::abs(sphere.radius);
}

// A ray from outside that passes the centre of a ball at this distance.
inline TestRay rayPast(const dvec3& center, double distance, Random& random) {
  const dvec3 d = randomDirection(random);
  return rayThrough(center + distance * anywhereAcross(d, random), d, uniform(random, 1.5, 3));
}

// A body of six parallelograms, their fronts outside; x, y and z are its edges at a corner, right-handed.
inline void addParallelepiped(Scene& scene, const dvec3& corner, const dvec3& x, const dvec3& y, const dvec3& z,
                              uint32_t material) {
  closed_form::addQuad(scene, corner, y, x, material);
  closed_form::addQuad(scene, corner + z, x, y, material);
  closed_form::addQuad(scene, corner, x, z, material);
  closed_form::addQuad(scene, corner + y, z, x, material);
  closed_form::addQuad(scene, corner, z, y, material);
  closed_form::addQuad(scene, corner + x, y, z, material);
}

// Rays that go through glass, or are turned back.
struct Journey {
  TestRay ray;
  int transmitted = 0, reflected = 0;  // hidden walls do not count
  bool ended = false;                  // nothing lies ahead
  Found last{};                        // where it was last transmitted or reflected
};

inline std::vector<Journey> journeysOf(const std::vector<TestRay>& rays) {
  std::vector<Journey> journeys;
  for (const TestRay& ray : rays) journeys.push_back({.ray = ray});
  return journeys;
}

// One step of all that have not ended: through the surface, or on total internal reflection back from it.
inline void advance(Kernels& kernels, std::vector<Journey>& journeys, Tracer tracer) {
  const auto stepOf = [&](const std::vector<Journey*>& some, Next next) {
    std::vector<TestRay> rays;
    for (const Journey* journey : some) rays.push_back(journey->ray);
    return stepFrom(kernels, rays, next, tracer);
  };
  const auto goOn = [](Journey& journey, const Found& found) {
    journey.last = found;
    journey.ray = found.leaving;
  };
  std::vector<Journey*> all, back;
  for (Journey& journey : journeys)
    if (!journey.ended) all.push_back(&journey);
  const std::vector<Found> through = stepOf(all, Next::transmitted);
  for (size_t i = 0; i < all.size(); ++i) {
    all[i]->ended = !through[i].hits();
    if (!through[i].hits()) continue;
    if (!through[i].leaves) {
      back.push_back(all[i]);
      continue;
    }
    all[i]->transmitted += !through[i].hidden;
    goOn(*all[i], through[i]);
  }
  const std::vector<Found> reflected = stepOf(back, Next::reflected);
  for (size_t i = 0; i < back.size(); ++i) {
    ++back[i]->reflected;
    goOn(*back[i], reflected[i]);
  }
}

// Snell's law by the part of the direction along the surface, which changes by the ratio of the indices.
inline dvec3 bent(const dvec3& d, const dvec3& n, double ratio) {
  const dvec3 unit = glm::normalize(d);
  const dvec3 along = ratio * (unit - glm::dot(unit, n) * n);
  return along + std::copysign(std::sqrt(1 - glm::dot(along, along)), glm::dot(unit, n)) * n;
}

// The direction in which it leaves.
inline dvec3 directionBehind(const TestRay& ray, const dvec3& center, double deviation) {
  const dvec3 d = glm::normalize(dvec3(ray.direction)), f = dvec3(ray.origin) - center;
  const dvec3 fromAxis = glm::normalize(f - glm::dot(f, d) * d);
  return std::cos(deviation) * d - std::sin(deviation) * fromAxis;
}

}  // namespace turner::hard
