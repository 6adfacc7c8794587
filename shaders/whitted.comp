// Whitted's ray tracer (An Improved Illumination Model for Shaded Display, 1980) as a compute kernel. One invocation owns
// one pixel: for each of its samples it follows the tree of rays depth-first, one ray in registers, the others waiting on
// a stack, and adds what each hit sends toward the eye, weighted by the product of the mirrors and glasses on the way.
//
// Every turn of the main loop follows one ray to its nearest hit, and shadow rays from there to the lights. When its
// budget of iterations is spent the invocation saves where it stands and goes on in the next dispatch, so that no dispatch
// runs long (docs/kernel.md).
#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.h"
#include "features.glsl"

layout(local_size_x_id = kSpecWorkGroup, local_size_y = 1, local_size_z = 1) in;
layout(push_constant) uniform PushConstants { Tile tile; };
layout(std430, binding = kBindFrame) readonly buffer FrameBuffer { Frame frameInMemory; };
layout(std430, binding = kBindState) buffer StateBuffer { Row state[]; };
layout(std430, binding = kBindPixels) buffer PixelBuffer { Row pixels[]; };  // of the tile, row by row: RGB; w: phase
layout(std430, binding = kBindStatus) buffer StatusBuffer { Status status; };

vec3 xyz(const Row row) { return uintBitsToFloat(row.xyz); }

// What is the same for all invocations, loaded once: inside a branch or loop lavapipe 22.3 would load it lane by lane.
Frame frame;
uint root;  // of the tree

// What is counted, by the kind of ray.
const uint kEye = 0u, kReflected = 1u, kRefracted = 2u, kShadow = 3u;
Row raysSpawned, nodesVisited, primitivesVisited;

#include "buffer_access.glsl"
#include "float_float.glsl"
#include "camera.glsl"
#include "nested_dielectrics.glsl"
#include "intersect.glsl"
#include "light_buffer.glsl"
#include "traverse.glsl"
#include "shade.glsl"
#include "state.glsl"

// Where an invocation stands.
const uint kNextSample = 0u;    // no ray in hand and none waiting; zero, so that cleared state is a fresh pixel
const uint kTrace = 1u;         // the ray in hand looks for its nearest hit
const uint kNextLight = 2u;     // the hit is known; next is a light
const uint kTraceShadow = 3u;   // a shadow ray of the hit is on its way to that light
const uint kNextRay = 4u;       // the ray in hand is done with
const uint kDone = kPixelDone;  // the pixel is finished

// The even bits of an index: half of a Morton code.
uint evenBits(uint i) {
  i &= 0x55555555u;
  i = (i | (i >> 1u)) & 0x33333333u;
  i = (i | (i >> 2u)) & 0x0f0f0f0fu;
  i = (i | (i >> 4u)) & 0x00ff00ffu;
  return (i | (i >> 8u)) & 0x0000ffffu;
}

// a / b for a < 2^22, by way of float: lavapipe divides integers lane by lane.
uint quotient(const uint a, const uint b) { return uint(int((float(int(a)) + 0.5) / float(int(b)))); }

// The slot of this invocation. A CPU device gives each of its threads one contiguous share of the work-groups; dealing
// the groups out in turn gives every thread a part of the sky and a part of the ground.
uint invocationSlot() {
  uint group = gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x;
  if (group >= tile.groups) return tile.slots;  // the grid's last row may be longer than the work
  uint threads = frame.downLo.w;
  uint share = quotient(tile.groups, threads), turn = quotient(group, max(share, 1u));
  uint dealt = group < share * threads ? (group - turn * share) * threads + turn : group;
  return (tile.firstGroup + dealt) * gl_WorkGroupSize.x + gl_LocalInvocationIndex;
}

// The pixel of a slot, within the tile: blocks of 8x8 row by row, Morton order inside, so that the lanes of a SIMD unit
// see a compact piece of the picture.
uvec2 slotPixel(const uint slot) {
  uint blocksInRow = (tile.width + 7u) / 8u;
  uint block = slot / 64u, inside = slot % 64u;
  uint y = quotient(block, blocksInRow), x = block - y * blocksInRow;
  return uvec2(8u * x + evenBits(inside), 8u * y + evenBits(inside >> 1u));
}

// Begins a sample with its eye ray.
void beginSample(const uvec2 pixel) {
  ray = Ray(vec3(0), eyeDirection(pixel, sampleIndex), kRefNone);
  rayKind = kEye;
  weight = 1.0;
  level = 1u;
  if (NESTED_DIELECTRICS) media = frame.media, hiddenInterfaces = 0u;
  RayFactors factors = rayFactors(ray.direction);
  traversal = startInCellList(cellList(kEyeBuffer, directionFace(ray.direction, factors.axis), factors.shear.xy), kNoHit);
  phase = kTrace;
  if (COUNTERS) ++raysSpawned[kEye];
}

// The nearest hit of the ray in hand, or as much of the way there as the budget allows.
void findNearestHit(const RayFactors factors, inout int budget) {
  traverse(ray, factors, false, NEAREST_NODES, rayKind, abs(along(ray.direction, factors.axis)), traversal, budget);
  if (!isFinished(traversal)) return;
  if (lacksCoincident(traversal)) {
    traversal = startCoincident(traversal);
    return;
  }
  hitT = NESTED_DIELECTRICS && traversal.coincidence > 0.0 ? traversal.hitT : traversal.tMax;
  hitPrimitive = traversal.hit;
  hitInterfaces = traversal.coincident;
  light = 0u;
  phase = kNextLight;
  // A miss sees the background.
  if (hitPrimitive == kRefNone) {
    compensatedAdd(sum, compensation, weight * xyz(frame.background));
    phase = kNextRay;
  }
}

// One light, if it faces the surface: a shadow ray to it, and its light if nothing hides it.
void addLight(const Surface surface, const MaterialData material, inout int budget) {
  Row position = ROW(lights, kLightRows * light + kLightPosition);
  Row color = ROW(lights, kLightRows * light + kLightColor);
  Ray shadowRay = leaveToLight(surface, hitPrimitive, xyz(position));
  RayFactors factors = rayFactors(shadowRay.direction);
  bool faces = facesLight(surface, xyz(position));
  if (phase == kNextLight && faces) {
    // Seen from the light, the ray comes through the opposite face. The light's own end is open: what stands exactly at
    // the light does not block it.
    uint face = directionFace(-shadowRay.direction, factors.axis);
    traversal = startInCellList(cellList(kEyeBuffer + 1u + light, face, factors.shear.xy), 1.0 - 1.0 / 1048576.0);
    phase = kTraceShadow;
    if (COUNTERS) ++raysSpawned[kShadow];
  }
  if (phase == kTraceShadow)
    traverse(shadowRay, factors, true, SHADOW_NODES, kShadow, abs(along(shadowRay.direction, factors.axis)), traversal,
                 budget);
  if (phase == kNextLight || isFinished(traversal)) {
    if (phase == kTraceShadow && traversal.hit == kRefNone)
      compensatedAdd(sum, compensation,
                     weight * localWeight(material) *
                         lightReflected(surface, -ray.direction, position, xyz(color), material));
    ++light;
    phase = kNextLight;
  }
}

// Of an interface that is hidden in other glass nothing is seen: the ray goes straight on.
void passHiddenInterface(const Surface surface, const Crossing crossing) {
  ray = leaveSurface(surface, hitPrimitive, ray.direction, false);
  media = crossing.beyond;
  ++hiddenInterfaces;
  traversal = startAtRoot();
  phase = kTrace;
  // Every such ray comes to an end, whatever the geometry.
  if (hiddenInterfaces >= kMaxHiddenInterfaces) {
    mediaLost = true;
    phase = kNextRay;
  }
}

// All lights are done: spawns what is reflected and transmitted. One ray goes on, the other waits.
void spawnRays(const Surface surface, const MaterialData material, const Crossing crossing, const uint slot) {
  phase = kNextRay;
  float r = reflectance(material), t = transmittance(material);
  vec3 T = vec3(0);
  bool passes = REFRACTION && t > 0.0 && transmission(surface, ray.direction, crossing.n, T);
  // On total internal reflection the share of T goes to R.
  if (!passes) r += REFRACTION ? t : 0.0;
  float reflectedWeight = weight * r, transmittedWeight = weight * t;
  // A share of 0 spawns nothing. The factors tell: far down the tree the product may underflow.
  float minWeight = uintBitsToFloat(frame.downHi.w);
  bool deeper = level < DEPTH;
  bool reflects = (REFLECTION || REFRACTION) && deeper && r > 0.0 && reflectedWeight >= minWeight;
  bool transmits = REFRACTION && deeper && passes && transmittedWeight >= minWeight;
  if (COUNTERS && reflects) ++raysSpawned[kReflected];
  if (COUNTERS && transmits) ++raysSpawned[kRefracted];

  Ray through = leaveSurface(surface, hitPrimitive, T, false);
  if (reflects) {
    if (transmits) pushRay(slot, through, transmittedWeight, crossing.beyond);
    ray = leaveSurface(surface, hitPrimitive, reflection(surface, ray.direction), true);
    rayKind = kReflected;
    weight = reflectedWeight;
  } else if (transmits) {
    ray = through;
    rayKind = kRefracted;
    weight = transmittedWeight;
    if (NESTED_DIELECTRICS) media = crossing.beyond;
  }
  if (reflects || transmits) {
    ++level;
    hiddenInterfaces = 0u;
    traversal = startAtRoot();
    phase = kTrace;
  }
}

// Follows one ray to its nearest hit, from there to the lights, and spawns the next: one step down the tree of rays.
void followRay(const uint slot, const uvec2 pixel, inout int budget) {
  // This turn, and those that no lane takes: of the traversal below, of the loop over lights and of the traversal in it.
  budget -= 2 + idleTurns(NEAREST_NODES) + idleTurns(SHADOW_NODES) + (NESTED_DIELECTRICS ? int(2u * kMaxInterfaces) : 0);
  if (SAMPLES > 1u && phase == kNextSample) beginSample(pixel);

  RayFactors factors = rayFactors(ray.direction);
  if (phase == kTrace) findNearestHit(factors, budget);

  if (phase == kNextLight || phase == kTraceShadow) {
    Surface surface = surfaceAt(ray, factors, hitT, hitPrimitive);
    MaterialData material = materialData(surface.material);
    Crossing crossing = Crossing(uvec4(0u), false, vec2(1, 0));
    if (NESTED_DIELECTRICS) {
      crossing = crossInterfaces(media, hitInterfaces, material, surface.front);
    } else if (REFRACTION) {
      crossing.n = indexBehind(surface, indexOfRefraction(material));
    }
    if (phase == kNextLight && (reflectsNoLight(material) || crossing.hidden)) light = LIGHTS;
    if (light < LIGHTS && budget > 0) {
      do {
        budget -= 1 + idleTurns(SHADOW_NODES);
        addLight(surface, material, budget);
      } while (light < LIGHTS && budget > 0);
    }
    if (phase == kNextLight && light >= LIGHTS) {
      if (crossing.hidden)
        passHiddenInterface(surface, crossing);
      else
        spawnRays(surface, material, crossing, slot);
    }
  }

  // Go on with the deepest ray that waits; without one the sample is complete.
  if (phase == kNextRay) {
    if (REFRACTION && anyPending()) {
      popRay(slot);
      traversal = startAtRoot();
      phase = kTrace;
    } else {
      ++sampleIndex;
      phase = sampleIndex < SAMPLES * SAMPLES ? kNextSample : kDone;
    }
  }
}

void main() {
  frame = frameInMemory;
  mediaLost = false;
  root = frame.centreHi.w;
  uint slot = invocationSlot();
  uvec2 inTile = slotPixel(slot);
  bool exists = slot < tile.slots;  // some slots have no pixel: the tile's last blocks reach beyond it
  bool mine = exists && inTile.x < tile.width && inTile.y < tile.height;
  slot = min(slot, tile.slots - 1u);
  uvec2 pixel = uvec2(tile.x0, tile.y0) + tile.stride * inTile;

  // Take up the work where the last dispatch left it.
  uint at = inTile.y * tile.width + inTile.x;
  if (FRESH) {
    beginWork();
    phase = kDone;
    if (mine) beginSample(pixel);
  } else {
    takeUpWork(slot);
    phase = mine ? pixels[at].w : kDone;
    if (phase == kDone) traversal.next = kRefNone, traversal.top = 0u;
    if (NEAREST_NODES || SHADOW_NODES) loadNodeStack(slot, traversal.top);
  }
  bool finishedBefore = phase == kDone;

  int budget = int(BUDGET);
  if (phase != kDone) {
    do {
      followRay(slot, pixel, budget);
    } while (phase != kDone && budget > 0);
  }

  if (COUNTERS && exists && (FRESH || !finishedBefore)) putCountsAway(slot);
  if (NESTED_DIELECTRICS && mediaLost) atomicAdd(status.mediaLost, 1u);
  if (!finishedBefore) {
    pixels[at] = packRow(sum / float(SAMPLES * SAMPLES), phase);
    if (phase != kDone) {
      putWorkAway(slot);
      if (NEAREST_NODES || SHADOW_NODES) saveNodeStack(slot, traversal.top);
      atomicAdd(status.unfinished, 1u);
      atomicAdd(status.samplesWaiting, SAMPLES * SAMPLES - sampleIndex);
    }
  }

  // The canary: a loop that must run kCanaryLength times. If it does not, a loop limiter has fired above, and the
  // picture is not to be trusted.
  uint sung = 0u;
  for (uint i = 0u; i < frame.background.w; ++i) ++sung;
  if (sung != kCanaryLength) atomicAdd(status.limiter, 1u);
}
