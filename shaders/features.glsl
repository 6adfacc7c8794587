// What the scene needs of a kernel (Features in host/shader/pack.h); the rest is compiled out.
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
layout(constant_id = kSpecNearestNodes) const bool NEAREST_NODES = true;
layout(constant_id = kSpecShadowNodes) const bool SHADOW_NODES = true;
layout(constant_id = kSpecBudget) const uint BUDGET = 1u;
layout(constant_id = kSpecFresh) const bool FRESH = true;
