// Both kernels are compiled alike and compared, word by word: comments and names do not count.
#include "kernel/edits/edited_kernel.h"

#include <string>
#include <utility>

#include "kernel/edits/kept_globals.h"
#include "kernel/edits/shipped_shaders.h"
#include "kernel/kernel_check.h"
#include "kernel/layout_text.h"

namespace turner {
namespace {

std::string editedPreamble(const std::vector<ShaderSource>& sources, BufferAccess access) {
  return accessPreamble(access) + "#define EDITED\n" + keptGlobalsPreamble(shippedShaders(), sources);
}

Kernel compileUnedited(const std::vector<ShaderSource>& sources, BufferAccess access) {
  return {compileGlsl(sources, accessPreamble(access)), {}, {}};
}

}  // namespace

Kernel compileKernel(const std::vector<ShaderSource>& sources, BufferAccess access, KernelForm form) {
  const bool asNeeded = form == KernelForm::asNeeded;
  if (asNeeded && areShipped(sources)) return compileUnedited(sources, access);
  ParameterisedSources parameterised = readParameters(sources);
  Kernel kernel{compileGlsl(parameterised.sources, editedPreamble(sources, access)), {}, {}};
  kernel.edited = true;
  checkGlobals(kernel.words, shippedShaders(), sources);
  if (asNeeded) {
    if (kernel.words == compileGlsl(shippedShaders(), editedPreamble(shippedShaders(), access)).words)
      return compileUnedited(sources, access);
    checkLayout(sources);
    checkKernel(kernel, sources, access);
  }
  kernel.parameters = std::move(parameterised.parameters);
  kernel.warnings += geometryWarnings(shippedShaders(), sources);
  kernel.uses = featuresUsed(shippedShaders(), sources);
  return kernel;
}

}  // namespace turner
