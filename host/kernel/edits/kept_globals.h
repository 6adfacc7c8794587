// The global variables of an edit. The work of an invocation may be cut into several dispatches, and what it has in
// registers is lost between them but for what the kernel keeps (shaders/resume.glsl): those of an edit are kept with
// it.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "kernel/shader_sources.h"

namespace turner {

// Lines for the compiler's preamble: EDIT_STATE(KEEP), a KEEP(word, four scalars) for each word of them, as resume.glsl
// keeps its own. Kept are variables of bool, int, uint, float and their vectors, declared outside of functions in what
// was edited. Throws InputError at the first for which there is no room, and at an array or a structure, which is not
// kept.
std::string keptGlobalsPreamble(const std::vector<ShaderSource>& shipped, const std::vector<ShaderSource>& edited);

// Throws InputError at a global variable in what became of the edit that the preamble does not know: a macro has
// declared it.
void checkGlobals(std::span<const uint32_t> words, const std::vector<ShaderSource>& shipped,
                  const std::vector<ShaderSource>& edited);

}  // namespace turner
