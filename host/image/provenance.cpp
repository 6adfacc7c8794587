// Attribute names begin with turner:, the matrices are OpenEXR's standard attributes.
#include "image/provenance.h"

#include <fmt/format.h>

#include "image/camera_basis.h"

namespace turner {
namespace {

// To OpenEXR's camera space: left-handed, x right, y up, z forward.
glm::dmat4 worldToCamera(const Camera& camera) {
  const CameraBasis basis = cameraBasis(camera);
  glm::dmat4 matrix(1);
  const glm::dvec3 rows[3] = {basis.right, basis.up, basis.forward};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) matrix[column][row] = rows[row][column];
    const glm::dvec3 moved = rows[row] * camera.eye;
    matrix[3][row] = -(moved.x + moved.y + moved.z);
  }
  return matrix;
}

// To (0,0) at the top left corner of the full picture and (1,1) at its bottom right, after division by w. The depth
// there is 1/z, so that the matrix can be inverted.
glm::dmat4 cameraToNdc(const Camera& camera, int width, int height) {
  const double halfHeight = cameraBasis(camera).tanHalfFov;
  const double halfWidth = halfHeight * width / height;
  glm::dmat4 matrix(0);
  matrix[0][0] = 0.5 / halfWidth;
  matrix[2][0] = 0.5;
  matrix[1][1] = -0.5 / halfHeight;
  matrix[2][1] = 0.5;
  matrix[3][2] = 1;
  matrix[2][3] = 1;
  return matrix;
}

}  // namespace

std::string cropText(const Window& crop) {
  return fmt::format("{},{},{},{}", crop.x0, crop.y0, crop.x1, crop.y1);
}

std::string optionsText(const RenderSettings& settings, const std::string& renderer) {
  return fmt::format("--width {} --height {} --samples {} --depth {} --sampler {} --seed {} --min-weight {} {}",
                     settings.width, settings.height, settings.samples, settings.depth, samplerName(settings.sampler),
                     settings.seed, settings.minWeight, renderer);
}

Provenance makeProvenance(const Scene& scene, const RenderSettings& settings, const std::string& renderer,
                          const std::string& device, const std::string& driver) {
  Provenance provenance;
  const auto add = [&](const std::string& key, const std::string& value) {
    provenance.strings.emplace_back("turner:" + key, value);
  };
  add("version", TURNER_VERSION);
  add("scene", scene.name);
  for (size_t i = 0; i < scene.sources.size(); ++i)
    add(i == 0 ? "sceneSha256" : fmt::format("mesh{}Sha256", i),
        i == 0 ? scene.sources[i].sha256 : scene.sources[i].sha256 + "  " + scene.sources[i].path);
  add("options", optionsText(settings, renderer));
  add("device", device);
  add("driver", driver);
  provenance.worldToCamera = worldToCamera(scene.camera);
  provenance.worldToNdc = cameraToNdc(scene.camera, settings.width, settings.height) * *provenance.worldToCamera;
  return provenance;
}

}  // namespace turner
