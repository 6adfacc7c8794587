// The scene that the kernel sees, still as doubles: moved so that the eye is the origin, scaled by a power of two so
// that the target lies in [1, 2) from it, then rounded to float32. Lies below both pack and reference.
#pragma once

#include "primitives/local_frame.h"
#include "scene/scene.h"

namespace turner {

// Depends on the camera alone: not on crop, tiles or size.
LocalFrame localFrame(const Camera& camera);

// Throws InputError naming the first primitive or light that is too far away, or too large, for float32: more than 1e10
// (lights: 1e15) times the distance from eye to target, where products of coordinates overflow. `local` comes from
// roundScene.
void checkReach(const Scene& local);

// Every number of the result has the value that the kernel computes with. The camera's target and up are not rounded:
// the kernel takes the image plane as unevaluated sums of two floats. Inverse-square lights are scaled along. How a
// primitive is rounded is told by the toLocal of its type.
Scene roundScene(Scene scene);

}  // namespace turner
