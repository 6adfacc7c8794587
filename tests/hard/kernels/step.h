// What step.comp and naive.comp are given and what they find, in rows of layout.h. Read by C++ and GLSL, after
// layout.h.
#ifndef TURNER_HARD_STEP_H
#define TURNER_HARD_STEP_H

#ifdef __cplusplus
namespace turner::gpu {
#define TURNER_CONST inline constexpr uint
#else
#define TURNER_CONST const uint
#endif

TURNER_CONST kBindGiven = 1u, kBindFound = 2u;

// A ray, and what is to become of it.
TURNER_CONST kGivenOrigin = 0u;     // w: the primitive it leaves, as the kernel names it, or kRefNone
TURNER_CONST kGivenDirection = 1u;  // w (float): 0: the nearest hit is wanted; else any hit before this distance
TURNER_CONST kGivenNext = 2u;       // w: which ray leaves the surface
TURNER_CONST kGivenSolids = 3u;     // that it is in (nested_dielectrics.glsl)
TURNER_CONST kGivenRows = 4u;

TURNER_CONST kNextNone = 0u;
TURNER_CONST kNextDirection = 1u;  // one in direction xyz, above the surface or through it
TURNER_CONST kNextLight = 2u;      // one to the light at xyz, if it faces the surface
TURNER_CONST kNextReflected = 3u;
TURNER_CONST kNextTransmitted = 4u;

TURNER_CONST kFoundHit = 0u;    // t (float), primitive as the kernel names it or kRefNone, id, flags
TURNER_CONST kFoundPoint = 1u;  // w: the surface's error bound (float)
TURNER_CONST kFoundNg = 2u;     // w: material
TURNER_CONST kFoundNs = 3u;
TURNER_CONST kFoundLeavingOrigin = 4u;  // w: the primitive it leaves
TURNER_CONST kFoundLeavingDirection = 5u;
TURNER_CONST kFoundSolids = 6u;  // that it is in
TURNER_CONST kFoundRows = 7u;

TURNER_CONST kFoundUnfinished = 1u;  // the budget of iterations did not suffice
TURNER_CONST kFoundFront = 2u;       // the hit is on the front
TURNER_CONST kFoundLeaves = 4u;      // there is a ray that leaves
TURNER_CONST kFoundHidden = 8u;  // the hit is on an interface that is hidden in other glass: the ray goes straight on

#ifdef __cplusplus
}  // namespace turner::gpu
#endif
#undef TURNER_CONST
#endif
