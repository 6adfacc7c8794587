// All that the kernel gets is rounded here, and nowhere else.
#include "geometry/round_scene.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <string>
#include <utility>

#include "base/errors.h"
#include "base/threads.h"

namespace turner {

LocalFrame localFrame(const Camera& camera) {
  const double distance = glm::length(camera.target - camera.eye);
  // ilogb(d) is the k with 2^k <= d < 2^(k+1).
  return {camera.eye, std::ldexp(1.0, -std::ilogb(distance))};
}

Scene roundScene(Scene scene) {
  const Camera camera = scene.camera;
  const LocalFrame frame = localFrame(camera);
  Scene local = std::move(scene);
  local.background = rounded(local.background);
  local.camera.eye = {0, 0, 0};
  local.camera.target = (camera.target - frame.origin) * frame.scale;
  for (Light& light : local.lights) {
    light.position = toLocal(light.position, frame);
    // E / d^2 keeps its value when both are scaled.
    if (light.falloff == Falloff::inverseSquare) light.color *= frame.scale * frame.scale;
    Light::visitValues(light, [](auto& value) { value = rounded(value); });
  }
  for (Material& material : local.materials)
    Material::visitValues(material, [](auto& value) { value = rounded(value); });
  Scene::visitPrimitives(local, [&](const char*, auto& primitives) {
    forAll(primitives.size(), [&](size_t i) { primitives[i] = toLocal(primitives[i], frame); });
  });
  forAll(local.positions.size(), [&](size_t i) { local.positions[i] = toLocal(local.positions[i], frame); });
  forAll(local.normals.size(), [&](size_t i) { local.normals[i] = rounded(glm::normalize(local.normals[i])); });
  return local;
}

void checkReach(const Scene& local) {
  const auto refuse = [](const char* what, size_t index) {
    throw InputError(
        std::string(what) + '[' + std::to_string(index) +
        "] is too far away or too large for a view whose target is so near to its eye: float32 cannot hold "
        "both; move the camera's target farther from the eye, or use --backend reference");
  };
  Scene::visitPrimitives(local, [&](const char* name, const auto& primitives) {
    for (size_t i = 0; i < primitives.size(); ++i)
      if (!isWithinReach(local, primitives[i])) refuse(name, i);
  });
  constexpr double kLight = 1e15;
  for (size_t i = 0; i < local.lights.size(); ++i)
    if (!isWithin(local.lights[i].position, kLight) || !isWithin(local.lights[i].color, 1e30)) refuse("lights", i);
}

}  // namespace turner
