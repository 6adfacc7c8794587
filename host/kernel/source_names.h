// The places of names in GLSL sources: enough to tell a user where something stands.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "kernel/shader_sources.h"

namespace turner {

SourceLocation locationAt(const ShaderSource& source, size_t offset);

// "path:line:column: error: "
std::string faultAt(const SourceLocation& location);

// Where the first of these names that stands in a declaration with a layout stands; failing that, where the first
// stands that stands anywhere; failing that, the beginning of the shader.
SourceLocation findDeclaration(const std::vector<ShaderSource>& sources, const std::vector<std::string>& names);

// Where a member is declared between the braces behind the structure's or the block's name; false if nowhere.
bool findMember(const std::vector<ShaderSource>& sources, const std::string& structure, const std::string& member,
                SourceLocation& location);

}  // namespace turner
