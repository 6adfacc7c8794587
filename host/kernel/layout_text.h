// Compares an edited layout.h or interface.h with the one that this program was built with. Reads it as text: a changed
// number would pass every compiler, and the host would go on with the old one.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "kernel/shader_sources.h"

namespace turner {

// The end of a message about a difference between the sources and the program.
inline constexpr char kLayoutRemedy[] =
    " in the running turner, which was built with its own layout.h and cannot follow; build turner with this file, or "
    "take the change back";

// A member of a structure of layout.h.
struct LayoutMember {
  std::string name, type;  // as GLSL spells it: "uint", "float", "vec3", "uvec4"
  uint32_t offset = 0;     // bytes
  uint32_t length = 0;     // of an array, else 0
  uint32_t size = 0;       // bytes, of all elements
};

// The members of a structure that this program was built with, in order: read from the text, without gaps, as layout.h
// keeps every structure. Empty where there is no such structure.
std::vector<LayoutMember> layoutMembers(const std::string& structure);

// The sources may add constants and structures, and omit some. Throws InputError with a line for each of the host's
// constants that has another value in one of them, by declaration or by #define, and for each of its structures that
// has other members.
void checkLayout(const std::vector<ShaderSource>& sources);

}  // namespace turner
