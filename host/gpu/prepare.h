// From a scene to what a device gets of it, in one step for all who render.
#pragma once

#include "gpu/pack_scene.h"

namespace turner {

// Scene -> rounded -> shapes -> tree -> packed. Of a large scene no step's value is kept beyond the next. Throws
// InputError where the scene does not fit float32 or the kernel.
PackedScene prepareScene(Scene scene, const RenderSettings& settings);

}  // namespace turner
