// The text of a shader and of what it includes, read once, so that what is looked up in the cache is what is compiled.
// Knows how an include is written, nothing else of GLSL.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace turner {

struct ShaderSource {
  std::string name;                 // relative to the shader's folder; empty for the shader itself
  std::string path;                 // the shader's folder and the name, as an includer joins them
  std::optional<std::string> text;  // none where the file cannot be read, which is no fault if nothing needs it
};

// Lines and columns (in bytes) count from 1.
struct SourceLocation {
  std::string path;
  int line = 1, column = 1;
};

// The shader first, then what its lines #include "name", and what these include, each name once. Includes that the
// preprocessor would skip are listed too; those in an unusual spelling (a comment or a broken line inside the
// directive, an absolute path) are not. Throws InputError if the shader itself cannot be read.
std::vector<ShaderSource> readShaderSources(const std::string& path);

// The one of this name, or null.
const ShaderSource* findSource(const std::vector<ShaderSource>& sources, const std::string& name);

}  // namespace turner
