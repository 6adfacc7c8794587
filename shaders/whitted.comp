// Whitted's ray tracer (An Improved Illumination Model for Shaded Display, CACM 23(6), 1980) as a compute kernel. One
// invocation owns one pixel: for each of its samples it follows the tree of rays depth-first, one ray in registers, the
// others waiting on a stack, and adds what each hit sends toward the eye, weighted by the product of the mirrors and
// glasses on the way. followRay() is the paper's page: nearest hit, local illumination, reflected and transmitted ray.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.h"

layout(local_size_x_id = kSpecWorkGroup, local_size_y = 1, local_size_z = 1) in;
layout(push_constant) uniform PushConstants { Tile tile; };
#define TURNER_BLOCK(Name, id, access, Type, variable, extent, what) \
  layout(std430, binding = id) access buffer Name##Buffer { Type variable extent; };
#include "interface.h"

// What is the same for all invocations, loaded once: inside a branch or loop lavapipe 22.3 would load it lane by lane.
Frame frame;

// What is counted, by the kind of ray.
const uint kEye = 0u, kReflected = 1u, kRefracted = 2u, kShadow = 3u;
uvec4 raysSpawned, nodesVisited, primitivesVisited;

#include "edited.glsl"
#include "buffer_access.glsl"
#include "scene.h"
#include "float_float.glsl"
#include "sampling.glsl"
#include "camera.glsl"
#include "nested_dielectrics.glsl"
#include "ray.glsl"
#include "world.glsl"
#include "primitives.glsl"
#include "light_buffer.glsl"
#include "tiles.glsl"
#include "edited_rays.glsl"
#include "traverse.glsl"
#include "shade.glsl"
#include "resume.glsl"
#include "rays.glsl"
#include "hidden_interfaces.glsl"
#include "canary.glsl"

// The nearest hit of the ray in hand, or as much of the way there as the budget allows.
void findNearestHit(const RayFactors factors, inout int budget) {
  traverse(currentRay, factors, false, NEAREST_NODES, rayKind, abs(along(currentRay.direction, factors.axis)), traversal, budget);
  if (!isFinished(traversal)) return;
  if (lacksCoincident(traversal)) {
    traversal = startCoincident(traversal);
    return;
  }
  hitT = NESTED_DIELECTRICS && traversal.coincidence > 0.0 ? traversal.hitT : traversal.tMax;
  hitPrimitive = traversal.hit;
  hitInterfaces = traversal.coincident;
  lightIndex = 0u;
  phase = kNextLight;
  // A miss sees the background.
  if (hitPrimitive == kRefNone) {
    compensatedAdd(sum, compensation, weight * frame.background);
    phase = kNextRay;
  }
}

// Local illumination by one light, if it faces the surface: a shadow ray to it, and its light if nothing hides it.
void addLight(const Surface surface, const Material material, inout int budget) {
  Light light = lightAt(lightIndex);
  Ray shadowRay = leaveToLight(surface, hitPrimitive, light.position);
  RayFactors factors = rayFactors(shadowRay.direction);
  bool faces = facesLight(surface, light);
  if (phase == kNextLight && faces) {
    traversal = startShadowRay(shadowRay, factors, lightIndex);
    phase = kTraceShadow;
    if (COUNTERS) ++raysSpawned[kShadow];
  }
  if (phase == kTraceShadow)
    traverse(shadowRay, factors, true, SHADOW_NODES, kShadow, abs(along(shadowRay.direction, factors.axis)), traversal,
             budget);
  if (phase == kNextLight || isFinished(traversal)) {
    if (phase == kTraceShadow && traversal.hit == kRefNone)
      compensatedAdd(sum, compensation,
                     weight * material.localWeight * lightReflected(surface, -currentRay.direction, light, material));
    ++lightIndex;
    phase = kNextLight;
  }
}

// All lights are done: spawns the reflected and the transmitted ray. One goes on, the other waits.
void spawnRays(const Surface surface, const Material material, const Crossing crossing) {
  phase = kNextRay;
  float r = material.reflectance, t = material.transmittance;
  vec3 T = vec3(0);
  bool passes = REFRACTION && t > 0.0 && transmission(surface, currentRay.direction, crossing.etaRatio, T);
  // On total internal reflection the share of T goes to R.
  if (!passes) r += REFRACTION ? t : 0.0;
  float reflectedWeight = weight * r, transmittedWeight = weight * t;
  // A share of 0 spawns nothing. The factors tell: far down the tree the product may underflow.
  bool deeper = level < DEPTH;
  LACKS(Reflection, !(REFLECTION || REFRACTION) && deeper && r > 0.0 && reflectedWeight >= frame.minWeight);
  LACKS(Refraction, !REFRACTION && deeper && t > 0.0);
  bool reflects = (REFLECTION || REFRACTION) && deeper && r > 0.0 && reflectedWeight >= frame.minWeight;
  bool transmits = REFRACTION && deeper && passes && transmittedWeight >= frame.minWeight;
  if (COUNTERS && reflects) ++raysSpawned[kReflected];
  if (COUNTERS && transmits) ++raysSpawned[kRefracted];

  Ray through = leaveSurface(surface, hitPrimitive, T, false);
  if (reflects) {
    if (transmits) pushRay(through, transmittedWeight, crossing.beyond);
    currentRay = leaveSurface(surface, hitPrimitive, reflection(surface, currentRay.direction), true);
    rayKind = kReflected;
    weight = reflectedWeight;
  } else if (transmits) {
    currentRay = through;
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
void followRay(inout int budget) {
  // Cost of this iteration: one turn, plus the empty turns of the loops below (see idleTurns).
  budget -= 2 + idleTurns(NEAREST_NODES) + idleTurns(SHADOW_NODES) + (NESTED_DIELECTRICS ? int(2u * kMaxInterfaces) : 0);
  if (SAMPLES > 1u && phase == kNextSample) beginSample();
#ifdef EDITED
  currentRay = trueStart(currentRay);
#endif

  RayFactors factors = rayFactors(currentRay.direction);
  if (phase == kTrace) findNearestHit(factors, budget);

  if (phase == kNextLight || phase == kTraceShadow) {
    Surface surface = surfaceAt(currentRay, factors, hitT, hitPrimitive);
#ifdef EDITED
    here = surface;
#endif
    Material material = materialAt(surface.material);
    Crossing crossing = Crossing(uvec4(0u), false, vec2(1, 0));
    if (NESTED_DIELECTRICS) {
      crossing = crossInterfaces(media, hitInterfaces, material, surface.front);
    } else if (REFRACTION) {
      crossing.etaRatio = etaBehind(surface, material.eta);
    }
    if (phase == kNextLight && (reflectsNoLight(material) || crossing.hidden)) lightIndex = LIGHTS;
    if (lightIndex < LIGHTS && budget > 0) {
      do {
        if (LOOPS_AT_HEAD && (lightIndex >= LIGHTS || budget <= 0)) break;
        budget -= 1 + idleTurns(SHADOW_NODES);
        addLight(surface, material, budget);
      } while (LOOPS_AT_HEAD || (lightIndex < LIGHTS && budget > 0));
    }
    if (phase == kNextLight && lightIndex >= LIGHTS) {
      if (crossing.hidden)
        passHiddenInterface(surface, crossing);
      else
        spawnRays(surface, material, crossing);
    }
  }

  // Go on with the deepest ray that waits; without one the sample is complete.
  if (phase == kNextRay) {
    if (REFRACTION && anyPending()) {
      popRay();
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
  findPixel();
  if (FRESH) {
    beginWork();
    phase = kDone;
    if (isMine) beginSample();
  } else {
    resumeWork();
    RESUME_EDIT();
  }
  bool finishedBefore = phase == kDone;

  int budget = int(BUDGET);
  if (phase != kDone) {
    do {
      if (LOOPS_AT_HEAD && (phase == kDone || budget <= 0)) break;
      followRay(budget);
    } while (LOOPS_AT_HEAD || (phase != kDone && budget > 0));
  }

  if (COUNTERS && hasSlot && (FRESH || !finishedBefore)) saveCounts();
  if (NESTED_DIELECTRICS && mediaLost) atomicAdd(status.mediaLost, 1u);
  if (!finishedBefore) {
    LACKS(Budget, phase != kDone && isAsKept());
    pixels[pixelAt] = packWord(sum / float(SAMPLES * SAMPLES), phase);
    if (phase != kDone) {
      suspendWork();
      SUSPEND_EDIT();
    }
  }
  TELL_LACKS();
  singCanary();
}
