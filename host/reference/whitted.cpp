// The witness's page of T. Whitted, "An improved illumination model for shaded display", Communications of the ACM
// 23(6), 1980: shaders/whitted.comp and shade.glsl have functions of the same names, and no formula here is taken from
// them.
//
// Symbols, all unit vectors, at a point that a ray hits:
//   V  toward where the ray came from       Ng  normal of the surface, on V's side
//   L  toward a light                       Ns  normal that shades, reflects and refracts
//   H  halfway between L and V              R, T  directions of the reflected and the transmitted ray
// Of a material: k_d diffuse, k_s specular, n shininess, r reflect, t transmit, eta index of refraction, w_local the
// weight of what the lights send. docs/light_transport.md has the whole sum.
#include "reference/whitted.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <string>
#include <utility>

#include "base/errors.h"

namespace turner::reference {
namespace {

// The ray that leaves the surface in this direction. It starts off the surface by the error bound, on the side that it
// goes to, so that coincident surfaces (coplanar neighbours, copies) are left too.
Ray leaveSurface(const Surface& surface, const dvec3& direction) {
  const double offset = std::copysign(surface.errorBound, glm::dot(surface.Ng, direction));
  return makeRay(surface.point + offset * surface.Ng, direction, surface.primitive);
}

// Whether a surface sends nothing of any light toward the eye by itself.
bool reflectsNoLight(const Material& material) {
  return material.localWeight * std::max(largest(material.diffuse), largest(material.specular)) <= 0;
}

// E (k_d + k_s max(0, N.H)^n) N.L of a light that is not in shadow.
dvec3 lightReflected(const Surface& surface, const dvec3& V, const dvec3& L, const dvec3& E) {
  const Material& material = *surface.material;
  dvec3 brdf = material.diffuse;
  if (largest(material.specular) > 0) {
    // Blinn, "Models of light reflection for computer synthesized pictures", SIGGRAPH 1977.
    const dvec3 halfway = L + V;
    const double length = glm::length(halfway);
    const double cosH = length > 0 ? std::max(0.0, glm::dot(surface.Ns, halfway) / length) : 0;
    if (length > 0) brdf += std::pow(cosH, material.shininess) * material.specular;
  }
  return glm::dot(surface.Ns, L) * E * brdf;
}

dvec3 mirrored(const dvec3& V, const dvec3& N) {
  return glm::normalize(2 * glm::dot(N, V) * N - V);
}

// R: about Ns, or about Ng where that would lead below the surface.
dvec3 reflection(const Surface& surface, const dvec3& V) {
  const dvec3 R = mirrored(V, surface.Ns);
  return glm::dot(R, surface.Ng) > 0 ? R : mirrored(V, surface.Ng);
}

// Snell's law: sin V = etaRatio sin T, with etaRatio = eta behind the surface / eta before it, on V's side. False on
// total internal reflection.
bool refracted(const dvec3& V, const dvec3& N, double etaRatio, dvec3& T) {
  const double cosV = glm::dot(N, V);
  const double squaredCosT = 1 - (1 - cosV * cosV) / (etaRatio * etaRatio);
  if (squaredCosT <= 0) return false;
  T = glm::normalize((cosV / etaRatio - std::sqrt(squaredCosT)) * N - V / etaRatio);
  return true;
}

// T: about Ns, or about Ng where that would not lead through the surface. False on total internal reflection.
bool transmission(const Surface& surface, const dvec3& V, double etaRatio, dvec3& T) {
  bool passes = refracted(V, surface.Ns, etaRatio, T);
  if (passes && glm::dot(T, surface.Ng) >= 0) passes = refracted(V, surface.Ng, etaRatio, T);
  return passes;
}

}  // namespace

Whitted::Whitted(const Aggregate& itsAggregate, const RenderSettings& itsSettings, std::stop_token itsStop)
    : aggregate(itsAggregate),
      scene(itsAggregate.scene),
      settings(itsSettings),
      stop(std::move(itsStop)),
      eyeMedia(itsAggregate.mediaAt(scene.camera.eye)) {}

dvec3 Whitted::eyeRadiance(const dvec3& direction) {
  ++counts.eye;
  return radiance(makeRay(scene.camera.eye, direction, kNoPrimitive), eyeMedia, 1, 1);
}

// What comes back along a ray in these media, which is of this level of its tree and counts in the pixel with this
// weight: what its nearest hit that is not hidden sends.
dvec3 Whitted::radiance(Ray ray, Media media, int level, double weight) {
  constexpr int kMostHiddenInterfaces = 65536;
  for (int hidden = 0; hidden < kMostHiddenInterfaces; ++hidden) {
    if (stop.stop_requested()) return dvec3(0);
    const Hit hit = aggregate.closestHit(ray);
    if (hit.primitive == kNoPrimitive) return scene.background;
    const Surface surface = aggregate.surfaceAt(ray, hit);
    const Crossing crossing = crossInterfaces(aggregate, ray, hit, surface, media);
    if (!crossing.hidden) return shade(ray, surface, media, crossing, level, weight);
    // Nothing is seen of a hidden interface: the ray goes straight on.
    ray = leaveSurface(surface, ray.direction);
    media = crossing.beyond;
  }
  throw RunError("a ray passed more than " + std::to_string(kMostHiddenInterfaces) + " walls hidden in other glass");
}

// What a surface sends back along the ray that hit it: local illumination, and r and t times what comes along R and T.
dvec3 Whitted::shade(const Ray& ray, const Surface& surface, const Media& media, const Crossing& crossing, int level,
                     double weight) {
  const Material& material = *surface.material;
  const dvec3 V = -ray.direction;
  dvec3 sum = material.localWeight * localIllumination(surface, V);
  if (material.reflect <= 0 && material.transmit <= 0) return sum;

  dvec3 T;
  const bool passes = material.transmit > 0 && transmission(surface, V, crossing.etaRatio, T);
  // On total internal reflection the share of T goes to R.
  const double r = passes ? material.reflect : material.reflect + material.transmit, t = material.transmit;
  sum += r * childRadiance(surface, reflection(surface, V), media, level + 1, weight * r, counts.reflected);
  if (passes) sum += t * childRadiance(surface, T, crossing.beyond, level + 1, weight * t, counts.refracted);
  return sum;
}

// The sum over the lights that nothing hides. Those that are no higher than the start of the shadow ray lie on the
// surface or behind it.
dvec3 Whitted::localIllumination(const Surface& surface, const dvec3& V) {
  dvec3 sum(0);
  if (reflectsNoLight(*surface.material)) return sum;
  const dvec3 start = surface.point + surface.errorBound * surface.Ng;
  for (const Light& light : scene.lights) {
    const dvec3 toLight = light.position - start;
    const double squaredDistance = glm::dot(toLight, toLight);
    if (!(squaredDistance > 0) || glm::dot(surface.Ng, toLight) <= 0) continue;
    const double distance = std::sqrt(squaredDistance);
    const dvec3 L = toLight / distance;
    if (glm::dot(surface.Ns, L) <= 0) continue;

    // A surface that the light lies on does not block it: hence less by 512 roundings, which is what its distance may
    // err by even where the ray meets it at a grazing angle.
    ++counts.shadow;
    const double end = distance - 512 * kRounding * std::max(largestSize(start), largestSize(light.position));
    if (aggregate.isOccluded(makeRay(start, L, surface.primitive), end)) continue;
    const dvec3 E = light.falloff == Falloff::inverseSquare ? light.color / squaredDistance : light.color;
    sum += lightReflected(surface, V, L, E);
  }
  return sum;
}

// Spawns a ray unless it is too deep in its tree or counts too little.
dvec3 Whitted::childRadiance(const Surface& surface, const dvec3& direction, const Media& media, int level,
                             double weight, uint64_t& count) {
  if (level > settings.depth || weight <= 0 || weight < settings.weightLimit()) return dvec3(0);
  ++count;
  return radiance(leaveSurface(surface, direction), media, level, weight);
}

}  // namespace turner::reference
