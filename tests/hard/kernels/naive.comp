// What a float32 ray tracer does that takes its formulas from a textbook: the witness for the prosecution, in tests
// only. The quadratic formula for spheres and cones, Moeller and Trumbore's test for triangles (JGT 2(1), 1997), slabs by IEEE
// division against boxes that fit exactly, a least distance instead of a careful start, GLSL's reflect() and refract().
// It is given and finds the same as step.comp.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "../../../shaders/layout.h"
#include "step.h"
#include "naive.h"

layout(local_size_x_id = kSpecWorkGroup, local_size_y = 1, local_size_z = 1) in;
layout(std430, binding = kBindFrame) readonly buffer FrameBuffer { Frame frame; };
layout(std430, binding = kBindGiven) readonly buffer GivenBuffer { Word4 given[]; };
layout(std430, binding = kBindFound) writeonly buffer FoundBuffer { Word4 found[]; };

#include "../../../shaders/buffer_access.glsl"
#include "../../../shaders/scene.h"

const float kFarAway = 1e38;

// t^2 a + 2 t b + c = 0.
float hitSphere(const vec3 origin, const vec3 direction, const vec3 center, const float radius, const float least) {
  vec3 f = origin - center;
  float a = dot(direction, direction), b = dot(f, direction), c = dot(f, f) - radius * radius;
  float discriminant = b * b - a * c;
  if (discriminant < 0.0) return kFarAway;
  float root = sqrt(discriminant);
  float near = (-b - root) / a, far = (-b + root) / a;
  return near > least ? near : far > least ? far : kFarAway;
}

float hitTriangle(const vec3 origin, const vec3 direction, const vec3 v0, const vec3 v1, const vec3 v2,
                  const float least) {
  vec3 e1 = v1 - v0, e2 = v2 - v0, p = cross(direction, e2);
  float det = dot(e1, p);
  if (det == 0.0) return kFarAway;
  vec3 s = origin - v0, q = cross(s, e1);
  float u = dot(s, p) / det, v = dot(direction, q) / det, t = dot(e2, q) / det;
  return u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > least ? t : kFarAway;
}

// |y|^2 = (radius + growth s)^2, with y across the axis and s along it, from the ray's origin.
float hitCone(const vec3 origin, const vec3 direction, const vec3 base, const vec3 apex, const float baseRadius,
              const float apexRadius, const float least) {
  float span = length(apex - base), growth = (apexRadius - baseRadius) / span;
  vec3 axis = (apex - base) / span, f = origin - base;
  float s0 = dot(f, axis), s1 = dot(direction, axis);
  vec3 y0 = f - s0 * axis, y1 = direction - s1 * axis;
  float r0 = baseRadius + growth * s0, r1 = growth * s1;
  float a = dot(y1, y1) - r1 * r1, b = dot(y0, y1) - r0 * r1, c = dot(y0, y0) - r0 * r0;
  float discriminant = b * b - a * c;
  if (discriminant < 0.0) return kFarAway;
  float root = sqrt(discriminant), first = (-b - root) / a, second = (-b + root) / a;
  float near = min(first, second), far = max(first, second), sNear = s0 + near * s1, sFar = s0 + far * s1;
  if (near > least && sNear >= 0.0 && sNear <= span) return near;
  return far > least && sFar >= 0.0 && sFar <= span ? far : kFarAway;
}

vec3 coneNormal(const vec3 point, const vec3 base, const vec3 apex, const float baseRadius, const float apexRadius) {
  float span = length(apex - base);
  vec3 axis = (apex - base) / span, f = point - base, y = f - dot(f, axis) * axis;
  return normalize(normalize(y) - (apexRadius - baseRadius) / span * axis);
}

bool entersBox(const vec3 origin, const vec3 direction, const vec3 lo, const vec3 hi, const float tMax) {
  vec3 t0 = (lo - origin) / direction, t1 = (hi - origin) / direction;
  vec3 near = min(t0, t1), far = max(t0, t1);
  return max(max(near.x, near.y), max(near.z, 0.0)) <= min(min(far.x, far.y), min(far.z, tMax));
}

uint stack[128];

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= given.length() / kGivenRows) return;
  vec3 origin = xyz(given[kGivenRows * i + kGivenOrigin]);
  Word4 directionRow = given[kGivenRows * i + kGivenDirection], next = given[kGivenRows * i + kGivenNext];
  vec3 direction = xyz(directionRow);
  float end = uintBitsToFloat(directionRow.w), least = frame.background.x;
  float tMax = end > 0.0 ? end : kFarAway;
  uint hit = kRefNone, top = 0u, node = frame.root, budget = BUDGET;
  while (node != kRefNone && budget > 0u) {
    --budget;
    Word4 lo = WORD4(nodes, kNaiveNodeRows * node + kNaiveLo), hi = WORD4(nodes, kNaiveNodeRows * node + kNaiveHi);
    bool enters = entersBox(origin, direction, xyz(lo), xyz(hi), tMax);
    node = kRefNone;
    if (enters && hi.w > 0u) {
      for (uint k = lo.w; k < lo.w + hi.w; ++k) {
        Word4 p0 = WORD4(primitives, kNaivePrimitiveRows * k), p1 = WORD4(primitives, kNaivePrimitiveRows * k + 1u),
            p2 = WORD4(primitives, kNaivePrimitiveRows * k + 2u);
        float t = p1.w == 0u   ? hitSphere(origin, direction, xyz(p0), uintBitsToFloat(p2.x), least)
                  : p1.w == 1u ? hitTriangle(origin, direction, xyz(p0), xyz(p1), xyz(p2), least)
                               : hitCone(origin, direction, xyz(p0), xyz(p1), uintBitsToFloat(p2.x),
                                         uintBitsToFloat(p2.y), least);
        if (t < tMax) {
          tMax = t;
          hit = k;
        }
      }
    }
    if (enters && hi.w == 0u) {
      stack[top++] = lo.w + 1u;
      node = lo.w;
    } else if (top > 0u) {
      node = stack[--top];
    }
  }

  vec3 point = vec3(0), Ng = vec3(0), leaving = vec3(0);
  bool front = false, leaves = false;
  uint id = kRefNone, material = 0u;
  if (hit != kRefNone) {
    Word4 p0 = WORD4(primitives, kNaivePrimitiveRows * hit), p1 = WORD4(primitives, kNaivePrimitiveRows * hit + 1u),
        p2 = WORD4(primitives, kNaivePrimitiveRows * hit + 2u);
    id = p0.w;
    material = p2.w;
    point = origin + tMax * direction;
    Ng = p1.w == 0u   ? normalize(point - xyz(p0))
         : p1.w == 1u ? normalize(cross(xyz(p1) - xyz(p0), xyz(p2) - xyz(p0)))
                      : coneNormal(point, xyz(p0), xyz(p1), uintBitsToFloat(p2.x), uintBitsToFloat(p2.y));
    front = dot(Ng, direction) < 0.0;
    if (!front) Ng = -Ng;
    leaves = true;
    if (next.w == kNextNone) leaves = false;
    if (next.w == kNextDirection) leaving = xyz(next);
    if (next.w == kNextLight) {
      leaving = xyz(next) - point;
      leaves = dot(Ng, leaving) > 0.0;
    }
    if (next.w == kNextReflected) leaving = reflect(direction, Ng);
    if (next.w == kNextTransmitted) {
      float eta = materialAt(material).eta;
      leaving = refract(normalize(direction), Ng, front ? 1.0 / eta : eta);
      leaves = leaving != vec3(0);
    }
  }
  uint row = kFoundRows * i;
  found[row + kFoundHit] = Word4(floatBitsToUint(tMax), hit, id, (budget > 0u ? 0u : kFoundUnfinished) |
                                                                   (front ? kFoundFront : 0u) | (leaves ? kFoundLeaves : 0u));
  found[row + kFoundPoint] = packWord(point, 0u);
  found[row + kFoundNg] = packWord(Ng, material);
  found[row + kFoundNs] = packWord(Ng, 0u);
  found[row + kFoundLeavingOrigin] = packWord(point, kRefNone);
  found[row + kFoundLeavingDirection] = packWord(leaving, 0u);
  found[row + kFoundSolids] = Word4(0u);
}
