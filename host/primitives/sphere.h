// A sphere: its bounds, its rounding for the kernel, and its packed form. The kernel's part is shaders/sphere.glsl.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "base/bounds.h"
#include "primitives/cube_face.h"
#include "primitives/local_frame.h"

namespace turner {

struct Features;

namespace gpu {
struct Sphere;
struct NearSphere;
}  // namespace gpu

struct Sphere {
  glm::dvec3 center{0, 0, 0};
  double radius = 1;  // negative (NFF only): the surface faces inward, Ng = (p - center) / radius
  uint32_t material = 0;
  double radiusRest = 0;  // the radius is the unevaluated sum of both: only toLocal needs that
};

Bounds boundsOf(const Sphere& sphere);

// Rounded to what the kernel computes with. Where the eye is near the surface: a center of two floats each, and a
// radius (plus radiusRest) with which the eye's power is that of the exact sphere.
Sphere toLocal(const Sphere& world, const LocalFrame& frame);

// Whether float32 can hold it; of a local sphere, as all below.
bool isWithinReach(const Sphere& local);

// The power of the eye, |center|^2 - radius^2: about twice the radius times the eye's height over the sphere.
long double eyePower(const Sphere& local);

// Whether the sphere is so many radii away from the eye that float32 is short of digits for where rays pass it.
bool isFarFromEye(const Sphere& local);

// Whether the eye is so near to the surface, compared with the radius, that the kernel needs its power: float32 rounds
// center and radius by more than the height's last bits.
bool isNearEye(const Sphere& local);

uint32_t referenceType(const Sphere&);  // type bits of a reference of the kernel
gpu::Sphere packed(const Sphere& local, uint32_t rank);

// Notes what such a primitive needs of the kernel.
void addFeatures(const Sphere& local, Features& features);

// The same of one that the eye is near; its NearSphere is at this word among the materials.
gpu::Sphere packNearSphere(const Sphere& local, uint32_t rank, uint32_t restAt);
gpu::NearSphere nearSphereOf(const Sphere& local);

// From its padded box to its own picture on a face of a cube of directions: the box's is all there is.
inline void narrow(const Sphere&, const CubeFace&, const Box&, Projection&, OuterEdges&) {}

}  // namespace turner
