// The scene that the kernel sees, still as doubles: moved so that the eye is the origin, scaled by a power of two so
// that the target lies in [1, 2) from it, then rounded to float32. Lies below both pack and reference.
#pragma once

#include <glm/vec3.hpp>

#include "scene/scene.h"

namespace turner {

// local = (world - origin) * scale; scale is a power of two, so that it adds no error.
struct LocalFrame {
  glm::dvec3 origin{0, 0, 0};
  double scale = 1;
};

// Depends on the camera alone: not on crop, tiles or size.
LocalFrame localFrame(const Camera& camera);

// Throws InputError naming the first primitive or light that is too far away, or too large, for float32: more than 1e10
// (lights: 1e15) times the distance from eye to target, where products of coordinates overflow. `local` comes from
// roundScene.
void checkReach(const Scene& local);

// Every number of the result has the value that the kernel computes with. The camera's target and up are not rounded:
// the kernel takes the image plane as unevaluated sums of two floats. Inverse-square lights are scaled along. A sphere
// that the eye is near has a center of two floats each, and a radius (plus radiusRest) with which the eye's power is
// that of the exact sphere.
Scene roundScene(Scene scene);

// The power of the eye with respect to a sphere of a scene from roundScene, |center|^2 - radius^2: about twice the
// radius times the eye's height over it.
long double eyePower(const Sphere& local);

// Whether the sphere is so many radii away from the eye that float32 is short of digits for where rays pass it.
bool isFarFromEye(const Sphere& local);

// Whether the eye is so near to the surface, compared with the radius, that the kernel needs its power: float32 rounds
// center and radius by more than the height's last bits.
bool isNearEye(const Sphere& local);

}  // namespace turner
