// The texts come from CMake, in the order of their names.
#include "kernel/edits/shipped_shaders.h"

#include <algorithm>
#include <string>

#include "shipped_shaders_texts.h"

namespace turner {
namespace {

constexpr char kKernel[] = "whitted.comp";

std::vector<ShaderSource> read() {
  std::vector<ShaderSource> sources;
  for (const ShippedText& shipped : kShippedTexts) {
    const bool isKernel = shipped.name == std::string(kKernel);
    ShaderSource source{isKernel ? "" : shipped.name, std::string("shipped/") + shipped.name, shipped.text};
    if (isKernel)
      sources.insert(sources.begin(), std::move(source));
    else
      sources.push_back(std::move(source));
  }
  return sources;
}

}  // namespace

const std::vector<ShaderSource>& shippedShaders() {
  static const std::vector<ShaderSource> sources = read();
  return sources;
}

bool areShipped(const std::vector<ShaderSource>& sources) {
  return std::all_of(sources.begin(), sources.end(), [](const ShaderSource& source) {
    const ShaderSource* const shipped = findSource(shippedShaders(), source.name);
    return shipped && shipped->text == source.text;
  });
}

}  // namespace turner
