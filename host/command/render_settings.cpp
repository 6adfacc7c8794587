// In: a scene and the options. Out: what its picture depends on, checked.
#include <fmt/format.h>

#include <string_view>

#include "base/errors.h"
#include "base/number.h"
#include "command/command_line.h"

namespace turner {
namespace {

Window parseCrop(const std::string& text, int width, int height) {
  int numbers[4];
  size_t at = 0;
  for (int i = 0; i < 4; ++i) {
    const size_t end = i < 3 ? text.find(',', at) : text.size();
    long long value = 0;
    if (end == std::string::npos ||
        parseInteger(std::string_view(text).substr(at, end - at), value) != NumberFault::none || value < 0 ||
        value > kMaxSize)
      throw InputError(fmt::format("--crop: found '{}'; must be four whole numbers x0,y0,x1,y1", text));
    numbers[i] = int(value);
    at = end + 1;
  }
  const Window crop{numbers[0], numbers[1], numbers[2], numbers[3]};
  if (crop.x0 >= crop.x1 || crop.y0 >= crop.y1 || crop.x1 > width || crop.y1 > height)
    throw InputError(fmt::format(
        "--crop: found {}; must be a part of the {} x {} picture: 0 <= x0 < x1 <= {} and 0 <= y0 < y1 <= {}", text,
        width, height, width, height));
  return crop;
}

}  // namespace

RenderSettings settingsFor(const Scene& scene, const RenderOptions& options) {
  RenderSettings settings;
  settings.width = options.width.value_or(scene.width);
  settings.height = options.height.value_or(scene.height);
  settings.crop = options.crop.empty() ? Window{0, 0, settings.width, settings.height}
                                       : parseCrop(options.crop, settings.width, settings.height);
  settings.samples = options.samples;
  settings.sampler = options.sampler;
  settings.seed = options.seed;
  settings.depth = options.depth.value_or(scene.depth);
  settings.minWeight = options.minWeight;
  constexpr size_t kMaxPixels = size_t(1) << 28;
  if (settings.crop.area() > kMaxPixels)
    throw InputError(
        fmt::format("a picture of {} x {} pixels is too large for one file; render it in parts with --crop "
                    "of at most {} pixels",
                    settings.crop.width(), settings.crop.height(), kMaxPixels));
  return settings;
}

}  // namespace turner
