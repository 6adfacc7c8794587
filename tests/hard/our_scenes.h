// The project's own scenes, at any size.
#pragma once

#include <string>

#include "scene/scene_load.h"
#include "support/shader_harness.h"

namespace turner::hard {

inline Scene ours(const std::string& name) {
  return loadScene(std::string(TURNER_SCENES_DIR "/") + name + ".json");
}

inline RenderSettings settingsOfHeight(const Scene& scene, int height) {
  return test::settingsOf(scene, height * scene.width / scene.height, height);
}

}  // namespace turner::hard
