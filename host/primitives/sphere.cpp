// Center and radius are rounded one by one, unless the eye is near: then its power decides.
#include "primitives/sphere.h"

#include <cmath>
#include <glm/geometric.hpp>

#include "primitives/features.h"
#include "primitives/words.h"

namespace turner {
namespace {

long double eyePower(const wide3& center, long double radius) {
  const long double distance = glm::length(center);
  return (distance - radius) * (distance + radius);
}

}  // namespace

Bounds boundsOf(const Sphere& sphere) {
  return {sphere.center - std::abs(sphere.radius), sphere.center + std::abs(sphere.radius)};
}

Sphere toLocal(const Sphere& world, const LocalFrame& frame) {
  const wide3 center = (wide3(world.center) - wide3(frame.origin)) * (long double)(frame.scale);
  Sphere local = world;
  local.center = rounded(glm::dvec3(center));
  local.radius = rounded(world.radius * frame.scale);
  if (!isNearEye(local)) return local;
  const auto power = eyePower(center, std::abs(world.radius) * frame.scale);
  const auto twoFloats = [](long double x) { return rounded(double(x)) + rounded(double(x - float(x))); };
  Sphere exact = local;
  exact.center = {twoFloats(center.x), twoFloats(center.y), twoFloats(center.z)};
  const long double squared = glm::dot(wide3(exact.center), wide3(exact.center)) - power;
  if (!(squared > 0)) return local;
  const long double radius = std::copysign(std::sqrt(squared), (long double)(world.radius));
  exact.radius = double(radius);
  exact.radiusRest = double(radius - exact.radius);
  // At the limit the answer may have changed, and the kernel is told by this scene alone.
  return isNearEye(exact) ? exact : local;
}

bool isWithinReach(const Sphere& local) {
  return isWithin(local.center, kMostLocal) && std::abs(local.radius) <= kMostLocal;
}

long double eyePower(const Sphere& local) {
  return eyePower(wide3(local.center), std::abs((long double)(local.radius) + local.radiusRest));
}

bool isNearEye(const Sphere& local) {
  return std::abs(eyePower(local)) <= 0.5L * (long double)(local.radius) * local.radius;
}

bool isFarFromEye(const Sphere& local) {
  // A ray passes within |center| 2^-24 of where it should: here within 2^-14 of the radius.
  return glm::length(local.center) > 1024 * std::abs(local.radius);
}

void addFeatures(const Sphere& local, Features& features) {
  features.spheres = true;
  features.nearSpheres |= isNearEye(local);
  features.farSpheres |= isFarFromEye(local);
}

uint32_t referenceType(const Sphere&) {
  return 0;
}

gpu::Sphere packed(const Sphere& local, uint32_t rank) {
  return {toVec3(local.center), float(local.radius), rank, local.material, 0, 0};
}

gpu::Sphere packNearSphere(const Sphere& local, uint32_t rank, uint32_t restAt) {
  gpu::Sphere near = packed(local, rank);
  near.material |= gpu::kNearEye;
  near.nearSphere = restAt;
  near.eyePower = float(eyePower(local));
  return near;
}

gpu::NearSphere nearSphereOf(const Sphere& local) {
  const long double power = eyePower(local);
  return {toVec3Rest(local.center), float(power - float(power))};
}

}  // namespace turner
