// One step along a path of rays, by the renderer's own functions: a ray's nearest hit (or any hit before a distance)
// through the whole tree, the surface there, and the ray that leaves it. One invocation, one ray.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "../../../shaders/layout.h"
#include "step.h"

layout(local_size_x_id = kSpecWorkGroup, local_size_y = 1, local_size_z = 1) in;
layout(std430, binding = kBindFrame) readonly buffer FrameBuffer { Frame frameInMemory; };
layout(std430, binding = kBindGiven) readonly buffer GivenBuffer { Word4 given[]; };
layout(std430, binding = kBindFound) writeonly buffer FoundBuffer { Word4 found[]; };

Frame frame;
uvec4 nodesVisited, primitivesVisited;

#include "../../../shaders/edited.glsl"
#include "../../../shaders/buffer_access.glsl"
#include "../../../shaders/scene.h"
#include "../../../shaders/float_float.glsl"
#include "../../../shaders/nested_dielectrics.glsl"
#include "../../../shaders/ray.glsl"
#include "../../../shaders/primitives.glsl"
#include "../../../shaders/light_buffer.glsl"
#include "../../../shaders/traverse.glsl"
#include "../../../shaders/shade.glsl"

void main() {
  uint i = gl_GlobalInvocationID.x;
  frame = frameInMemory;
  if (i >= given.length() / kGivenRows) return;
  Word4 origin = given[kGivenRows * i + kGivenOrigin], direction = given[kGivenRows * i + kGivenDirection],
      next = given[kGivenRows * i + kGivenNext];
  uvec4 media = given[kGivenRows * i + kGivenSolids];
  mediaLost = false;
  Ray ray = Ray(xyz(origin), xyz(direction), origin.w);
  RayFactors factors = rayFactors(ray.direction);
  TraversalState traversal = startAtRoot();
  float end = uintBitsToFloat(direction.w);  // a shadow ray's; 0: the nearest hit is wanted
  if (end > 0.0) traversal.tMax = end;
  int budget = int(BUDGET);
  if (end > 0.0)
    traverse(ray, factors, true, true, 0u, 1.0, traversal, budget);
  else
    traverse(ray, factors, false, true, 0u, 1.0, traversal, budget);
  float t = traversal.tMax;
  if (end == 0.0 && lacksCoincident(traversal)) {
    traversal = startCoincident(traversal);
    traverse(ray, factors, false, true, 0u, 1.0, traversal, budget);
    t = traversal.hitT;
  }

  Surface surface = Surface(vec3(0), vec3(0), vec3(0), false, false, 0.0, 0u);
  Ray leaving = Ray(vec3(0), vec3(0), kRefNone);
  bool leaves = false, hidden = false;
  if (traversal.hit != kRefNone && end == 0.0) {
    surface = surfaceAt(ray, factors, t, traversal.hit);
    if (next.w == kNextDirection) {
      leaving = leaveSurface(surface, traversal.hit, xyz(next), dot(xyz(next), surface.Ng) > 0.0);
      leaves = true;
    }
    if (next.w == kNextLight) {
      leaving = leaveToLight(surface, traversal.hit, xyz(next));
      leaves = facesLight(surface, Light(xyz(next), 0u, vec3(1), 0u));
    }
    if (next.w == kNextReflected) {
      leaving = leaveSurface(surface, traversal.hit, reflection(surface, ray.direction), true);
      leaves = true;
    }
    if (next.w == kNextTransmitted) {
      vec3 T = ray.direction;
      Material material = materialAt(surface.material);
      vec2 etaRatio = etaBehind(surface, material.eta);
      if (NESTED_DIELECTRICS) {
        Crossing crossing = crossInterfaces(media, traversal.coincident, material, surface.front);
        hidden = crossing.hidden;
        etaRatio = crossing.etaRatio;
        media = crossing.beyond;
      }
      leaves = hidden || transmission(surface, ray.direction, etaRatio, T);
      leaving = leaveSurface(surface, traversal.hit, T, false);
    }
  }
  uint flags = (isFinished(traversal) && !mediaLost ? 0u : kFoundUnfinished) | (hidden ? kFoundHidden : 0u) |
               (surface.front ? kFoundFront : 0u) | (leaves ? kFoundLeaves : 0u);
  uint row = kFoundRows * i;
  found[row + kFoundHit] = Word4(floatBitsToUint(t), traversal.hit, traversal.rank, flags);
  found[row + kFoundPoint] = packWord(surface.point, floatBitsToUint(surface.errorBound));
  found[row + kFoundNg] = packWord(surface.Ng, surface.material);
  found[row + kFoundNs] = packWord(surface.Ns, 0u);
  found[row + kFoundLeavingOrigin] = packWord(leaving.origin, leaving.originPrimitive);
  found[row + kFoundLeavingDirection] = packWord(leaving.direction, 0u);
  found[row + kFoundSolids] = media;
}
