// What one light sends from a surface toward the eye, by the renderer's own functions or by the textbook's. One
// invocation, one light and surface; no scene.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "../../../shaders/layout.h"
#include "formulas.h"

layout(local_size_x_id = kSpecWorkGroup, local_size_y = 1, local_size_z = 1) in;
layout(constant_id = kSpecNaive) const bool NAIVE = false;
layout(std430, binding = kBindLitGiven) readonly buffer GivenBuffer { Word4 given[]; };
layout(std430, binding = kBindLitFound) writeonly buffer FoundBuffer { Word4 found[]; };

#include "../../../shaders/buffer_access.glsl"
#include "../../../shaders/scene.h"
#include "../../../shaders/edited.glsl"
#include "../../../shaders/float_float.glsl"
#include "../../../shaders/nested_dielectrics.glsl"
#include "../../../shaders/ray.glsl"
#include "../../../shaders/primitives.glsl"
#include "../../../shaders/shade.glsl"

// Blinn (1977) as it is written on paper.
vec3 textbookReflected(const Surface surface, const vec3 V, const Light light, const Material material) {
  vec3 toward = light.position - surface.point, E = light.color;
  vec3 L = normalize(toward), H = normalize(L + V);
  if (light.falloff != 0u) E /= dot(toward, toward);
  float highlight = pow(max(dot(surface.Ns, H), 0.0), material.shininess);
  return E * (material.diffuse + material.specular * highlight) * max(dot(surface.Ns, L), 0.0);
}

void main() {
  uint i = gl_GlobalInvocationID.x, row = kLitRows * i;
  if (i >= given.length() / kLitRows) return;
  Word4 point = given[row + kLitPoint], normal = given[row + kLitNormal], lightWord = given[row + kLitLight],
        diffuse = given[row + kLitDiffuse], specular = given[row + kLitSpecular];
  vec3 Ns = xyz(normal), V = xyz(given[row + kLitView]);
  Light light = Light(xyz(lightWord), lightWord.w, xyz(given[row + kLitColor]), 0u);
  Surface surface = Surface(xyz(point), Ns, Ns, true, true, 0.0, 0u);
  Material material = Material(xyz(diffuse), uintBitsToFloat(diffuse.w), xyz(specular), uintBitsToFloat(specular.w),
                               uintBitsToFloat(point.w), 0.0, 1.0, 0u);
  float q = uintBitsToFloat(normal.w), n = uintBitsToFloat(point.w), power = 0.0;
  vec3 radiance = vec3(0);
  if (NAIVE) {
    radiance = textbookReflected(surface, V, light, material);
    power = pow(1.0 - q, n);
  } else {
    if (facesLight(surface, light)) radiance = lightReflected(surface, V, light, material);
    power = powOneMinus(q, n);
  }
  found[kLitFoundRows * i + kLitRadiance] = Word4(floatBitsToUint(radiance), floatBitsToUint(power));
}
