// Which features of the kernel an edit of its sources is about, so that they are compiled in, whatever the scene needs.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "kernel/shader_sources.h"

namespace turner {

// A feature that the sources use where they were edited.
struct FeatureUse {
  uint32_t constant;        // its id, gpu::kSpec<Name>
  SourceLocation location;  // the first such place
};

// Of those that any scene can have: highlights, mirrors, glass, fall-off. A feature is used where an edited statement
// names it or what belongs to it, and where conditions that name it lead there; each is told once. What an edit does by
// way of data, the kernel finds out itself (shaders/edited.glsl).
std::vector<FeatureUse> featuresUsed(const std::vector<ShaderSource>& shipped, const std::vector<ShaderSource>& edited);

// Warnings, a line for each: where the edit changes how the geometry, the tree or the lists are read. Those were built
// for what is in the buffers; what is moved in the shader is not found where it went.
std::string geometryWarnings(const std::vector<ShaderSource>& shipped, const std::vector<ShaderSource>& edited);

}  // namespace turner
