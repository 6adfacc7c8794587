// Compares an edited layout.h with the one that this program was built with. Reads it as text: a changed number would
// pass every compiler, and the host would go on with the old one.
#pragma once

#include <vector>

#include "kernel/shader_sources.h"

namespace turner {

// The end of a message about a difference between the sources and the program.
inline constexpr char kLayoutRemedy[] =
    " in the running turner, which was built with its own layout.h and cannot follow; build turner with this file, or "
    "take the change back";

// The sources may add constants and structures, and omit some. Throws InputError with a line for each of the host's
// constants that has another value in one of them, by declaration or by #define, and for each of its structures that
// has other members.
void checkLayout(const std::vector<ShaderSource>& sources);

}  // namespace turner
