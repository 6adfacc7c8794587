// Every good version in a folder of its own, so that one can go back: DIR/0007/ with shaders/, scene/ (its file),
// picture.exr and figures.json.
#pragma once

#include <string>
#include <vector>

#include "kernel/shader_sources.h"

namespace turner::watch {

// The highest number among the versions in a folder, 0 where there is none. Makes the folder. Throws InputError where
// that cannot be.
int lastKeptVersion(const std::string& folder);

struct KeptVersion {
  std::vector<ShaderSource> sources;
  std::string sceneName, sceneText;  // of its file
  std::string picture;               // bytes of an EXR
  std::string figures;               // JSON
  std::string parameters;            // JSON, as --params takes it; empty: there are none
};

// The version's folder appears whole or not at all. Returns its path. Throws RunError.
std::string keepVersion(const std::string& folder, int number, const KeptVersion& version);

// For figures that come later.
void keepFigures(const std::string& versionFolder, const std::string& figures);

}  // namespace turner::watch
