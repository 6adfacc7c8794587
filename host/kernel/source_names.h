// Source locations of names in GLSL, for messages to the user.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "kernel/shader_sources.h"

namespace turner {

SourceLocation locationAt(const ShaderSource& source, size_t offset);

// "path:line:column: error: "
std::string faultAt(const SourceLocation& location);

// The first of these names that occurs in a declaration with a layout; if none does, the first that occurs anywhere; if
// none does, the beginning of the shader.
SourceLocation findDeclaration(const std::vector<ShaderSource>& sources, const std::vector<std::string>& names);

// The declaration of a member, between the braces behind the name of its structure or block; false if there is none.
bool findMember(const std::vector<ShaderSource>& sources, const std::string& structure, const std::string& member,
                SourceLocation& location);

}  // namespace turner
