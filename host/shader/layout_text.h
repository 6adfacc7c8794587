// Holds an edited layout.h against the one that this program was built with. Reads it as text: a changed number would
// pass every compiler, and the host would go on with the old one.
#pragma once

#include <vector>

#include "shader/shader_sources.h"

namespace turner {

// A layout.h may add constants and structures, and leave some away. Throws InputError with a line for each constant of
// the host's that has another value, and for each of its structures that has other members, in the sources that are
// named layout.h.
void checkLayout(const std::vector<ShaderSource>& sources);

}  // namespace turner
