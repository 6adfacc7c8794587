// Compares a compiled kernel with what the host will do with it, before any driver sees it.
#pragma once

#include <vector>

#include "kernel/buffer_access.h"
#include "kernel/compile.h"
#include "kernel/shader_sources.h"

namespace turner {

// Checks that the SPIR-V is valid for Vulkan 1.2, that its bindings, blocks, push constants, specialisation constants
// and work-group are those of the host (interface.h), and that it needs no capability beyond those that the device is
// opened with. What the kernel leaves unused may be missing. `sources` are what it was compiled from: a fault is
// reported at its declaration.
// Throws InputError with a line for each fault; of a block only the first wrong member is reported, as the others often
// follow from it.
void checkKernel(const Spirv& kernel, const std::vector<ShaderSource>& sources, BufferAccess access);

}  // namespace turner
