// Holds a compiled kernel against what the host will do with it, before any driver sees it.
#pragma once

#include <vector>

#include "kernel/buffer_access.h"
#include "kernel/compile.h"
#include "kernel/shader_sources.h"

namespace turner {

// Looks whether the SPIR-V is valid for Vulkan 1.2, whether its bindings, blocks, push constants, specialisation
// constants and work-group are what render.cpp gives it under shaders/layout.h, and whether it needs no more of the
// device than gpu.cpp opens. What the kernel leaves unused may be missing. `sources` are what it was compiled from: a
// fault is told at the place of the declaration.
// Throws InputError with a line for each fault; of a block only its first wrong member is told, as the others often
// follow from it.
void checkKernel(const Spirv& kernel, const std::vector<ShaderSource>& sources, BufferAccess access);

}  // namespace turner
