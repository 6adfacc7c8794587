// One step along a path of rays, by the renderer's own functions: a ray's nearest hit (or any hit before a distance)
// through the whole tree, the surface there, and the ray that leaves it. One invocation, one ray.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "../../../shaders/layout.h"
#include "../../../shaders/features.glsl"
#include "step.h"

layout(local_size_x_id = kSpecWorkGroup, local_size_y = 1, local_size_z = 1) in;
layout(std430, binding = kBindFrame) readonly buffer FrameBuffer { Frame frameInMemory; };
layout(std430, binding = kBindGiven) readonly buffer GivenBuffer { Row given[]; };
layout(std430, binding = kBindFound) writeonly buffer FoundBuffer { Row found[]; };

vec3 xyz(const Row row) { return uintBitsToFloat(row.xyz); }

Frame frame;
uint root;
Row nodesVisited, primitivesVisited;

#include "../../../shaders/fetch.glsl"
#include "../../../shaders/numerics.glsl"
#include "../../../shaders/solids.glsl"
#include "../../../shaders/intersect.glsl"
#include "../../../shaders/cube.glsl"
#include "../../../shaders/traverse.glsl"
#include "../../../shaders/shade.glsl"

Row packRow(const vec3 v, const uint w) { return Row(floatBitsToUint(v), w); }

void main() {
  uint i = gl_GlobalInvocationID.x;
  frame = frameInMemory;
  root = frame.centreHi.w;
  if (i >= given.length() / kGivenRows) return;
  Row origin = given[kGivenRows * i + kGivenOrigin], direction = given[kGivenRows * i + kGivenDirection],
      next = given[kGivenRows * i + kGivenNext];
  uvec4 solids = given[kGivenRows * i + kGivenSolids];
  solidsLost = false;
  Ray ray = Ray(xyz(origin), xyz(direction), origin.w);
  RayFactors factors = rayFactors(ray.direction);
  Walk walk = walkFromRoot();
  float end = uintBitsToFloat(direction.w);  // a shadow ray's; 0: the nearest hit is wanted
  if (end > 0.0) walk.tMax = end;
  int budget = int(BUDGET);
  if (end > 0.0)
    continueWalk(ray, factors, true, true, 0u, 1.0, walk, budget);
  else
    continueWalk(ray, factors, false, true, 0u, 1.0, walk, budget);
  float t = walk.tMax;
  if (end == 0.0 && lacksPlace(walk)) {
    walk = walkThroughPlace(walk);
    continueWalk(ray, factors, false, true, 0u, 1.0, walk, budget);
    t = walk.hitT;
  }

  Surface surface = Surface(vec3(0), vec3(0), vec3(0), false, false, 0.0, 0u);
  Ray leaving = Ray(vec3(0), vec3(0), kRefNone);
  bool leaves = false, hidden = false;
  if (walk.hit != kRefNone && end == 0.0) {
    surface = surfaceAt(ray, factors, t, walk.hit);
    if (next.w == kNextDirection) {
      leaving = leaveSurface(surface, walk.hit, xyz(next), dot(xyz(next), surface.Ng) > 0.0);
      leaves = true;
    }
    if (next.w == kNextLight) {
      leaving = leaveToLight(surface, walk.hit, xyz(next));
      leaves = facesLight(surface, xyz(next));
    }
    if (next.w == kNextReflected) {
      leaving = leaveSurface(surface, walk.hit, reflection(surface, ray.direction), true);
      leaves = true;
    }
    if (next.w == kNextTransmitted) {
      vec3 T = ray.direction;
      MaterialRows material = materialRows(surface.material);
      vec2 n = indexBehind(surface, indexOfRefraction(material));
      if (SOLIDS) {
        Crossing crossing = crossWalls(solids, walk.place, material, surface.front);
        hidden = crossing.hidden;
        n = crossing.n;
        solids = crossing.beyond;
      }
      leaves = hidden || transmission(surface, ray.direction, n, T);
      leaving = leaveSurface(surface, walk.hit, T, false);
    }
  }
  uint flags = (isOver(walk) && !solidsLost ? 0u : kFoundUnfinished) | (hidden ? kFoundHidden : 0u) |
               (surface.front ? kFoundFront : 0u) | (leaves ? kFoundLeaves : 0u);
  uint row = kFoundRows * i;
  found[row + kFoundHit] = Row(floatBitsToUint(t), walk.hit, walk.order, flags);
  found[row + kFoundPoint] = packRow(surface.point, floatBitsToUint(surface.margin));
  found[row + kFoundNg] = packRow(surface.Ng, surface.material);
  found[row + kFoundNs] = packRow(surface.Ns, 0u);
  found[row + kFoundLeavingOrigin] = packRow(leaving.origin, leaving.leaving);
  found[row + kFoundLeavingDirection] = packRow(leaving.direction, 0u);
  found[row + kFoundSolids] = solids;
}
