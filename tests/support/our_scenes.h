// The project's own scenes. A new file in scenes/ is found by itself, and held to what all of them are held to.
#pragma once

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "scene/scene_load.h"

namespace turner::test {

// By name.
inline Scene ours(const std::string& name) {
  return loadScene(std::string(TURNER_SCENES_DIR "/") + name + ".json");
}

// The names of all but these, in alphabetical order.
inline std::vector<std::string> ourScenesBut(const std::vector<std::string>& leftOut) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(TURNER_SCENES_DIR)) {
    const std::filesystem::path& path = entry.path();
    const std::string name = path.stem().string();
    if (path.extension() == ".json" && name != "scene.schema" &&
        std::find(leftOut.begin(), leftOut.end(), name) == leftOut.end())
      names.push_back(name);
  }
  std::sort(names.begin(), names.end());
  return names;
}

inline std::vector<std::string> ourScenes() {
  return ourScenesBut({});
}

}  // namespace turner::test
