// The kernel's sources that this program was built with, compiled in: what a user's are compared with, whatever became
// of the files.
#pragma once

#include <vector>

#include "kernel/shader_sources.h"

namespace turner {

// As readShaderSources() reads them. Their paths name no files.
const std::vector<ShaderSource>& shippedShaders();

// Whether the sources are these, to the byte.
bool areShipped(const std::vector<ShaderSource>& sources);

}  // namespace turner
