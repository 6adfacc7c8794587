// The shader's path from a scene to a picture, for tests: one device and one compiled kernel for the whole program.
// Without a Vulkan device these throw, and the test fails.
#pragma once

#include <cstdlib>
#include <map>
#include <memory>
#include <string>

#include "accel/bvh.h"
#include "geometry/round_scene.h"
#include "gpu/devices.h"
#include "gpu/pack_scene.h"
#include "gpu/renderer.h"
#include "image/settings.h"
#include "kernel/compile.h"

namespace turner::test {

inline std::string wantedDevice() {
  const char* wanted = std::getenv("TURNER_DEVICE");
  return wanted ? wanted : "";
}

// Empty until the first use. endRenderer() empties it again before the program ends: by its exit a validation layer may
// have lost its own statics, and would abort.
inline std::unique_ptr<ShaderRenderer>& rendererSlot() {
  static std::unique_ptr<ShaderRenderer> slot;
  return slot;
}

inline void endRenderer() {
  rendererSlot().reset();
}

inline ShaderRenderer& renderer() {
  std::unique_ptr<ShaderRenderer>& slot = rendererSlot();
  if (!slot) slot = std::make_unique<ShaderRenderer>(chooseDevice(listDevices(), wantedDevice()));
  return *slot;
}

inline Spirv compileKernel(BufferAccess access) {
  return compileGlsl(TURNER_SHADERS_DIR "/whitted.comp", accessPreamble(access));
}

// For the scene that was uploaded last.
inline const Spirv& kernel() {
  static std::map<BufferAccess, Spirv> kernels;
  const auto [kernel, isNew] = kernels.try_emplace(renderer().access());
  if (isNew) kernel->second = compileKernel(kernel->first);
  return kernel->second;
}

inline PackedScene packed(const Scene& scene, const RenderSettings& settings,
                          TraversalStart start = TraversalStart::lists) {
  const PreparedGeometry prepared = prepareGeometry(roundScene(scene));
  return packScene(prepared, buildBvh(prepared.boxes, prepared.typeStarts()), settings, start);
}

inline Image renderShader(const Scene& scene, const RenderSettings& settings, const Dispatching& dispatching = {}) {
  renderer().upload(packed(scene, settings));
  return renderer().render(kernel(), settings, {}, dispatching).image;
}

inline RayCounts countShaderRays(const Scene& scene, const RenderSettings& settings,
                                 const Dispatching& dispatching = {}) {
  renderer().upload(packed(scene, settings));
  return renderer().countVisits(kernel(), settings, {}, dispatching).rays;
}

inline RenderSettings settingsOf(const Scene& scene, int width, int height, int samples = 1) {
  RenderSettings settings;
  settings.width = width;
  settings.height = height;
  settings.crop = {0, 0, width, height};
  settings.samples = samples;
  settings.depth = scene.depth;
  return settings;
}

// Of the scene's own shape.
inline RenderSettings settingsOfHeight(const Scene& scene, int height) {
  return settingsOf(scene, height * scene.width / scene.height, height);
}

}  // namespace turner::test
