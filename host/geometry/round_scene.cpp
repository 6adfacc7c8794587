// All that the kernel gets is rounded here, and nowhere else.
#include "geometry/round_scene.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <string>
#include <utility>

#include "base/errors.h"
#include "base/threads.h"

namespace turner {
namespace {

double rounded(double x) {
  return double(float(x));
}
glm::dvec3 rounded(const glm::dvec3& v) {
  return {rounded(v.x), rounded(v.y), rounded(v.z)};
}

using wide3 = glm::tvec3<long double, glm::defaultp>;

long double eyePower(const wide3& center, long double radius) {
  const long double distance = glm::length(center);
  return (distance - radius) * (distance + radius);
}

// The sphere rounded, with a radius that gives the eye the power that it has in the exact scene.
Sphere rounded(const Sphere& world, const LocalFrame& frame) {
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

}  // namespace

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

LocalFrame localFrame(const Camera& camera) {
  const double distance = glm::length(camera.target - camera.eye);
  // ilogb(d) is the k with 2^k <= d < 2^(k+1).
  return {camera.eye, std::ldexp(1.0, -std::ilogb(distance))};
}

Scene roundScene(Scene scene) {
  const Camera camera = scene.camera;
  const LocalFrame frame = localFrame(camera);
  const auto toLocal = [&](const glm::dvec3& p) { return rounded((p - frame.origin) * frame.scale); };

  Scene local = std::move(scene);
  local.background = rounded(local.background);
  local.camera.eye = {0, 0, 0};
  local.camera.target = (camera.target - frame.origin) * frame.scale;
  for (Light& light : local.lights) {
    light.position = toLocal(light.position);
    // E / d^2 keeps its value when both are scaled.
    if (light.falloff == Falloff::inverseSquare) light.color *= frame.scale * frame.scale;
    Light::visitValues(light, [](auto& value) { value = rounded(value); });
  }
  for (Material& material : local.materials)
    Material::visitValues(material, [](auto& value) { value = rounded(value); });
  forAll(local.spheres.size(), [&](size_t i) { local.spheres[i] = rounded(local.spheres[i], frame); });
  forAll(local.triangles.size(), [&](size_t i) {
    for (glm::dvec3& vertex : local.triangles[i].vertices) vertex = toLocal(vertex);
  });
  forAll(local.normals.size(), [&](size_t i) {
    for (glm::dvec3& normal : local.normals[i]) normal = rounded(glm::normalize(normal));
  });
  return local;
}

void checkReach(const Scene& local) {
  // In the local frame the target is at a distance of 1 to 2. Written so that NaN fails too.
  const auto within = [](const glm::dvec3& v, double most) {
    return std::abs(v.x) <= most && std::abs(v.y) <= most && std::abs(v.z) <= most;
  };
  const auto refuse = [](const char* what, size_t index) {
    throw InputError(
        std::string(what) + '[' + std::to_string(index) +
        "] is too far away or too large for a view whose target is so near to its eye: float32 cannot hold "
        "both; move the camera's target farther from the eye, or use --backend reference");
  };
  constexpr double kGeometry = 1e10, kLight = 1e15;
  for (size_t i = 0; i < local.spheres.size(); ++i)
    if (!within(local.spheres[i].center, kGeometry) || !(std::abs(local.spheres[i].radius) <= kGeometry))
      refuse("spheres", i);
  for (size_t i = 0; i < local.triangles.size(); ++i)
    for (const glm::dvec3& vertex : local.triangles[i].vertices)
      if (!within(vertex, kGeometry)) refuse("triangles", i);
  for (size_t i = 0; i < local.lights.size(); ++i)
    if (!within(local.lights[i].position, kLight) || !within(local.lights[i].color, 1e30)) refuse("lights", i);
}

}  // namespace turner
