// In: a scene. Out: its packed form for a device. One step for all callers that render.
#pragma once

#include "gpu/pack_scene.h"

namespace turner {

// Scene -> rounded -> primitives -> tree -> packed. Values are freed step by step: large scenes need the memory. Throws
// InputError where the scene does not fit float32 or the kernel.
PackedScene prepareScene(Scene scene, const RenderSettings& settings);

}  // namespace turner
