#include "round_scene.h"

#include <cmath>
#include <glm/geometric.hpp>

namespace turner {
namespace {

double rounded(double x) {
  return double(float(x));
}
glm::dvec3 rounded(const glm::dvec3& v) {
  return {rounded(v.x), rounded(v.y), rounded(v.z)};
}

}  // namespace

LocalFrame localFrame(const Camera& camera) {
  const double distance = glm::length(camera.target - camera.eye);
  // ilogb(d) is the k with 2^k <= d < 2^(k+1).
  return {camera.eye, std::ldexp(1.0, -std::ilogb(distance))};
}

Scene roundScene(const Scene& scene) {
  const LocalFrame frame = localFrame(scene.camera);
  const auto toLocal = [&](const glm::dvec3& p) { return rounded((p - frame.origin) * frame.scale); };

  Scene local = scene;
  local.background = rounded(scene.background);
  local.camera.eye = {0, 0, 0};
  local.camera.target = (scene.camera.target - frame.origin) * frame.scale;
  for (Light& light : local.lights) {
    light.position = toLocal(light.position);
    // E / d^2 keeps its value when both are scaled.
    if (light.falloff == Falloff::inverseSquare) light.color *= frame.scale * frame.scale;
    light.color = rounded(light.color);
  }
  for (Material& material : local.materials) {
    material.diffuse = rounded(material.diffuse);
    material.specular = rounded(material.specular);
    for (double* value :
         {&material.shininess, &material.reflect, &material.transmit, &material.ior, &material.localWeight})
      *value = rounded(*value);
  }
  for (Sphere& sphere : local.spheres) {
    sphere.center = toLocal(sphere.center);
    sphere.radius = rounded(sphere.radius * frame.scale);
  }
  for (Triangle& triangle : local.triangles)
    for (glm::dvec3& vertex : triangle.vertices) vertex = toLocal(vertex);
  for (auto& normals : local.normals)
    for (glm::dvec3& normal : normals) normal = rounded(glm::normalize(normal));
  return local;
}

}  // namespace turner
