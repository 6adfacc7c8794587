// What one light sends from a surface toward the eye, by the renderer's own functions or by the textbook's. One
// invocation, one light and surface; no scene.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "../../../shaders/layout.h"
#include "../../../shaders/features.glsl"
#include "formulas.h"

layout(local_size_x_id = kSpecWorkGroup, local_size_y = 1, local_size_z = 1) in;
layout(constant_id = kSpecNaive) const bool NAIVE = false;
layout(std430, binding = kBindLitGiven) readonly buffer GivenBuffer { Row given[]; };
layout(std430, binding = kBindLitFound) writeonly buffer FoundBuffer { Row found[]; };

vec3 xyz(const Row row) { return uintBitsToFloat(row.xyz); }

#include "../../../shaders/buffer_access.glsl"
#include "../../../shaders/float_float.glsl"
#include "../../../shaders/nested_dielectrics.glsl"
#include "../../../shaders/intersect.glsl"
#include "../../../shaders/shade.glsl"

// Blinn (1977) as it is written on paper.
vec3 textbookReflected(const Surface surface, const vec3 V, const Row lightPosition, vec3 E,
                       const MaterialData material) {
  vec3 toward = xyz(lightPosition) - surface.point;
  vec3 L = normalize(toward), H = normalize(L + V);
  if (lightPosition.w != 0u) E /= dot(toward, toward);
  float highlight = pow(max(dot(surface.Ns, H), 0.0), shininess(material));
  return E * (xyz(material.diffuse) + xyz(material.specular) * highlight) * max(dot(surface.Ns, L), 0.0);
}

void main() {
  uint i = gl_GlobalInvocationID.x, row = kLitRows * i;
  if (i >= given.length() / kLitRows) return;
  Row point = given[row + kLitPoint], normal = given[row + kLitNormal], light = given[row + kLitLight];
  vec3 Ns = xyz(normal), V = xyz(given[row + kLitView]), E = xyz(given[row + kLitColor]);
  Surface surface = Surface(xyz(point), Ns, Ns, true, true, 0.0, 0u);
  MaterialData material =
      MaterialData(given[row + kLitDiffuse], given[row + kLitSpecular], Row(point.w, 0u, floatBitsToUint(1.0), 0u));
  float q = uintBitsToFloat(normal.w), n = uintBitsToFloat(point.w), power = 0.0;
  vec3 radiance = vec3(0);
  if (NAIVE) {
    radiance = textbookReflected(surface, V, light, E, material);
    power = pow(1.0 - q, n);
  } else {
    if (facesLight(surface, xyz(light))) radiance = lightReflected(surface, V, light, E, material);
    power = powOneMinus(q, n);
  }
  found[kLitFoundRows * i + kLitRadiance] = Row(floatBitsToUint(radiance), floatBitsToUint(power));
}
