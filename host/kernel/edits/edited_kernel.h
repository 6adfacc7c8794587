// Kernels of the program's own sources and of edited ones. An edited kernel is compiled with EDITED defined: it checks
// what the other may take for granted (shaders/edited.glsl).
#pragma once

#include <vector>

#include "kernel/buffer_access.h"
#include "kernel/compile.h"
#include "kernel/edits/feature_use.h"
#include "kernel/edits/parameters.h"
#include "kernel/shader_sources.h"

namespace turner {

enum class KernelForm {
  asNeeded,  // edited if the sources compile to something else than the program's own
  edited,    // in any case, so that the kernels of several versions can be compared
};

struct Kernel : Spirv {
  std::vector<FeatureUse> uses;       // of an edited one, where it was edited
  std::vector<Parameter> parameters;  // with their defaults
};

// Throws InputError with the compiler's first error, or with what is wrong with the declarations of parameters; for
// KernelForm::asNeeded also with what checkLayout() and checkKernel() have against an edited kernel.
Kernel compileKernel(const std::vector<ShaderSource>& sources, BufferAccess access, KernelForm form);

}  // namespace turner
