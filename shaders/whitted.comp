// Whitted's ray tracer (An Improved Illumination Model for Shaded Display, 1980) as a compute kernel. One invocation owns
// one pixel: for each of its samples it follows the tree of rays depth-first, one ray in registers, the others waiting on
// a stack, and adds what each hit sends toward the eye, weighted by the product of the mirrors and glasses on the way.
//
// Every turn of the main loop traces one ray: an eye or secondary ray to its nearest hit, or a shadow ray from that hit
// to one light. After kSegments turns the invocation saves where it stands and goes on in the next dispatch, so that no
// dispatch runs long (docs/kernel.md).
#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.h"

// What the scene needs; the rest is compiled out.
layout(local_size_x_id = kSpecWorkGroup, local_size_y = 1, local_size_z = 1) in;
layout(constant_id = kSpecDepth) const uint DEPTH = 5u;
layout(constant_id = kSpecSamples) const uint SAMPLES = 1u;
layout(constant_id = kSpecLights) const uint LIGHTS = 1u;
layout(constant_id = kSpecSpheres) const bool SPHERES = true;
layout(constant_id = kSpecTriangles) const bool TRIANGLES = true;
layout(constant_id = kSpecSmoothNormals) const bool SMOOTH_NORMALS = true;
layout(constant_id = kSpecHighlights) const bool HIGHLIGHTS = true;
layout(constant_id = kSpecReflection) const bool REFLECTION = true;
layout(constant_id = kSpecRefraction) const bool REFRACTION = true;
layout(constant_id = kSpecFalloff) const bool FALLOFF = true;
layout(constant_id = kSpecJitter) const bool JITTER = false;
layout(constant_id = kSpecCounters) const bool COUNTERS = false;
layout(constant_id = kSpecSegments) const uint SEGMENTS = kSegments;
layout(constant_id = kSpecSteps) const uint STEPS = kSteps;

layout(push_constant) uniform PushConstants { Tile tile; };
layout(std430, binding = kBindFrame) readonly buffer FrameBuffer { Frame frame; };
layout(std430, binding = kBindNodes) readonly buffer NodeBuffer { Node nodes[]; };
layout(std430, binding = kBindSpheres) readonly buffer SphereBuffer { Sphere spheres[]; };
layout(std430, binding = kBindTriangles) readonly buffer TriangleBuffer { Triangle triangles[]; };
layout(std430, binding = kBindVertexNormals) readonly buffer VertexNormalsBuffer { VertexNormals vertexNormals[]; };
layout(std430, binding = kBindMaterials) readonly buffer MaterialBuffer { Material materials[]; };
layout(std430, binding = kBindLights) readonly buffer LightBuffer { Light lights[]; };
layout(std430, binding = kBindState) buffer StateBuffer { Row state[]; };
layout(std430, binding = kBindPixels) writeonly buffer PixelBuffer { float pixels[]; };  // RGB of the tile, row by row
layout(std430, binding = kBindStatus) buffer StatusBuffer { Status status; };

vec3 xyz(Row row) { return uintBitsToFloat(row.xyz); }

#include "numerics.glsl"
#include "camera.glsl"
#include "intersect.glsl"
#include "traverse.glsl"
#include "shade.glsl"
#include "state.glsl"

// Where an invocation stands.
const uint kNextSample = 0u;  // no ray in hand and none waiting; zero, so that cleared state is a fresh pixel
const uint kTrace = 1u;       // the ray in hand looks for its nearest hit
const uint kShadow = 2u;      // a shadow ray of its hit looks for anything in the way of one light
const uint kNextLight = 3u;   // the hit is known, its next light is not
const uint kNextRay = 4u;     // the ray in hand is done with
const uint kDone = 5u;        // the pixel is finished

// The even bits of an index: half of a Morton code.
uint evenBits(uint i) {
  i &= 0x55555555u;
  i = (i | (i >> 1u)) & 0x33333333u;
  i = (i | (i >> 2u)) & 0x0f0f0f0fu;
  i = (i | (i >> 4u)) & 0x00ff00ffu;
  return (i | (i >> 8u)) & 0x0000ffffu;
}

// The slot of this invocation. A CPU device gives each of its threads one contiguous share of the work-groups; dealing
// the groups out in turn gives every thread a part of the sky and a part of the ground.
uint invocationSlot() {
  uint group = gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x;
  if (group >= tile.groups) return tile.slots;  // the grid's last row may be longer than the work
  uint threads = frame.downLo.w;
  uint share = tile.groups / threads;
  uint dealt = group < share * threads ? (group % share) * threads + group / share : group;
  return (tile.firstGroup + dealt) * gl_WorkGroupSize.x + gl_LocalInvocationIndex;
}

// The pixel of a slot, within the tile: blocks of 8x8 row by row, Morton order inside, so that the lanes of a SIMD unit
// see a compact piece of the picture.
uvec2 slotPixel(uint slot) {
  uint blocksInRow = (tile.width + 7u) / 8u;
  uint block = slot / 64u, inside = slot % 64u;
  return uvec2(8u * (block % blocksInRow) + evenBits(inside), 8u * (block / blocksInRow) + evenBits(inside >> 1u));
}

void main() {
  uint slot = invocationSlot();
  uvec2 inTile = slotPixel(slot);
  bool mine = slot < tile.slots && inTile.x < tile.width && inTile.y < tile.height;
  slot = min(slot, tile.slots - 1u);
  uvec2 pixel = uvec2(tile.x0, tile.y0) + inTile;
  float minWeight = uintBitsToFloat(frame.downHi.w);

  // Take up the work where the last dispatch left it.
  takeUpWork(slot);
  if (!mine) phase = kDone;
  bool finishedBefore = phase == kDone;
  if (finishedBefore) walk = Walk(kRefNone, 0u, 0.0, kRefNone);
  loadNodeStack(slot, walk.top);

  uint samplesFinished = 0u;
  for (uint segment = 0u; segment < SEGMENTS && phase != kDone; ++segment) {
    // Begin the next sample with its eye ray.
    if (phase == kNextSample) {
      ray = Ray(vec3(0), eyeDirection(pixel, sampleIndex), kRefNone);
      weight = 1.0;
      level = 1u;
      phase = kTrace;
      traced = ray;
      walk = beginWalk(kNoHit);
      if (COUNTERS) ++counts.x;
    }

    continueWalk(traced, phase == kShadow, walk);
    if (walk.next != kRefNone) continue;  // out of steps: the walk goes on in the next turn

    // The nearest hit of an eye or secondary ray: its lights come first. A miss sees the background.
    if (phase == kTrace) {
      hitT = walk.tMax;
      hitPrimitive = walk.hit;
      light = 0u;
      phase = kNextLight;
      if (hitPrimitive == kRefNone) {
        compensatedAdd(sum, compensation, weight * xyz(frame.background));
        phase = kNextRay;
      }
    }

    if (phase == kShadow || phase == kNextLight) {
      Surface surface = surfaceAt(ray, hitT, hitPrimitive);
      Row diffuse = materials[surface.material].diffuse, specular = materials[surface.material].specular;
      Row other = materials[surface.material].other;
      float localWeight = uintBitsToFloat(other.z);

      // The light at the end of a shadow ray that nothing blocked.
      if (phase == kShadow) {
        if (walk.hit == kRefNone)
          compensatedAdd(sum, compensation, weight * localWeight * lightReflected(surface, -ray.direction, light));
        ++light;
        phase = kNextLight;
      }

      // The next light that faces the surface gets a shadow ray.
      vec3 local = max(xyz(diffuse), HIGHLIGHTS ? xyz(specular) : vec3(0));
      if (localWeight * largest(local) <= 0.0) light = LIGHTS;
      for (uint tries = 0u; tries < kLightTries && light < LIGHTS; ++tries) {
        if (facesLight(surface, light)) {
          traced = leaveSurface(surface, hitPrimitive, vec3(0), true);
          traced.direction = xyz(lights[light].position) - traced.origin;
          // The light's own end is open: what stands exactly at the light does not block it.
          walk = beginWalk(1.0 - 1.0 / 1048576.0);
          phase = kShadow;
          if (COUNTERS) ++counts.w;
          break;
        }
        ++light;
      }

      // All lights are done: spawn what is reflected and transmitted.
      if (phase == kNextLight && light >= LIGHTS) {
        phase = kNextRay;
        float r = uintBitsToFloat(diffuse.w), t = uintBitsToFloat(specular.w);
        vec3 T = vec3(0);
        bool passes = REFRACTION && t > 0.0 && transmission(surface, ray.direction, uintBitsToFloat(other.y), T);
        // On total internal reflection the share of T goes to R.
        if (!passes) r += REFRACTION ? t : 0.0;
        float reflectedWeight = weight * r, transmittedWeight = weight * t;
        // A share of 0 spawns nothing. The factors tell: far down the tree the product may underflow.
        bool deeper = level < DEPTH;
        bool reflects = (REFLECTION || REFRACTION) && deeper && r > 0.0 && reflectedWeight >= minWeight;
        bool transmits = REFRACTION && deeper && passes && transmittedWeight >= minWeight;
        if (COUNTERS) counts.yz += uvec2(reflects ? 1u : 0u, transmits ? 1u : 0u);

        Ray through = leaveSurface(surface, hitPrimitive, T, false);
        if (reflects) {
          if (transmits) pushRay(slot, through, transmittedWeight);
          ray = leaveSurface(surface, hitPrimitive, reflection(surface, ray.direction), true);
          weight = reflectedWeight;
        } else if (transmits) {
          ray = through;
          weight = transmittedWeight;
        }
        if (reflects || transmits) {
          ++level;
          traced = ray;
          walk = beginWalk(kNoHit);
          phase = kTrace;
        }
      }
    }

    // Go on with the deepest ray that waits; without one the sample is complete.
    if (phase == kNextRay) {
      if (anyPending()) {
        popRay(slot);
        traced = ray;
        walk = beginWalk(kNoHit);
        phase = kTrace;
      } else {
        ++sampleIndex;
        ++samplesFinished;
        phase = sampleIndex < SAMPLES * SAMPLES ? kNextSample : kDone;
      }
    }
  }

  if (!finishedBefore) {
    putWorkAway(slot);
    if (phase == kDone) {
      vec3 mean = sum / float(SAMPLES * SAMPLES);
      uint at = 3u * (inTile.y * tile.width + inTile.x);
      pixels[at] = mean.x;
      pixels[at + 1u] = mean.y;
      pixels[at + 2u] = mean.z;
    } else {
      saveNodeStack(slot, walk.top);
      atomicAdd(status.unfinished, 1u);
    }
    atomicAdd(status.samplesFinished, samplesFinished);
  }

  // The canary: a loop that must run kCanaryLength times. If it does not, a loop limiter has fired above, and the
  // picture is not to be trusted.
  uint sung = 0u;
  for (uint i = 0u; i < frame.background.w; ++i) ++sung;
  if (sung != kCanaryLength) atomicAdd(status.limiter, 1u);
}
