// What an EXR of Turner's says about itself: from which scene, by which options, on which device.
#pragma once

#include <string>

#include "image/exr.h"
#include "image/settings.h"
#include "scene/scene.h"

namespace turner {

// "x0,y0,x1,y1", as --crop takes it.
std::string cropText(const Window& crop);

// The options that the picture depends on, as one would type them; the crop is the data window. `renderer` are the
// options that say who renders.
std::string optionsText(const RenderSettings& settings, const std::string& renderer);

// `device` and `driver` name what rendered it. No dates or timings: the file depends on scene, options and device
// alone.
Provenance makeProvenance(const Scene& scene, const RenderSettings& settings, const std::string& renderer,
                          const std::string& device, const std::string& driver);

}  // namespace turner
