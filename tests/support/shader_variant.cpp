#include "support/shader_variant.h"

#include <fmt/format.h>

#include "base/errors.h"
#include "base/output_file.h"
#include "base/text_file.h"

namespace turner::test {
namespace {

namespace fs = std::filesystem;

void replaceOnce(const fs::path& shaders, const Replacement& replacement) {
  const std::string path = (shaders / replacement.file).string();
  std::string text = readTextFile(path);
  size_t count = 0, place = 0;
  for (size_t at = 0; (at = text.find(replacement.from, at)) != std::string::npos; at += replacement.from.size()) {
    ++count;
    place = at;
  }
  if (count != 1)
    throw RunError(fmt::format("the snippet '{}' stands {} times in {}, not once; it must follow the shader",
                               replacement.name, count, replacement.file));
  text.replace(place, replacement.from.size(), replacement.to);
  writeWholeFile(path, text);
}

}  // namespace

ShaderVariant::ShaderVariant(std::span<const Replacement> replacements) {
  const fs::path shaders = folder_.path / "shaders", kernels = folder_.path / "tests/hard/kernels";
  fs::create_directories(kernels);
  fs::copy(TURNER_SHADERS_DIR, shaders, fs::copy_options::recursive);
  fs::copy(TURNER_TESTS_DIR "/hard/kernels", kernels, fs::copy_options::recursive);
  for (const Replacement& replacement : replacements) replaceOnce(shaders, replacement);
}

}  // namespace turner::test
