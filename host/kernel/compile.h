// Compiles GLSL to SPIR-V at run time, or finds that it was compiled before. The compiler glslang appears in
// compile.cpp only.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "kernel/shader_sources.h"

namespace turner {

struct Spirv {
  std::vector<uint32_t> words;
  std::vector<std::string> files;                   // read on the way: the shader first, then its includes in order
  std::string warnings;                             // the compiler's, a line "file:line: warning: ..." for each
  bool edited = false;                              // it keeps kEditWords more of state (layout.h)
  double glslangSeconds = 0, optimiserSeconds = 0;  // 0 where it was compiled before
};

// Compiles a compute shader for Vulkan 1.2; #include "..." is looked for beside the including file. `preamble` is read
// before its first line, which it does not move: "#define NAME value" lines.
// What compiles is kept in the user's cache folder (spirv_cache.h) and found there as long as no file has changed.
// Throws InputError with the compiler's first error as "file:line: error: ...".
Spirv compileGlsl(const std::string& path, const std::string& preamble = {});
// The same of sources that were read before; files that are missing there are looked for on the disk.
Spirv compileGlsl(const std::vector<ShaderSource>& sources, const std::string& preamble = {});

}  // namespace turner
