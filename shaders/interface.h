// The kernel's interface, a line for each specialisation constant and each binding. Read by C++ and GLSL as often as
// they need it: whoever includes it first defines the macros that it wants expanded, the others expand to nothing.
// clang-format off
//
//   TURNER_CONSTANT(Name, id, type, NAME, value)         what settings and device decide; value: where none is given
//   TURNER_FEATURE(Name, id, type, NAME, value, member)  what a scene needs; member: of Features (host/primitives/features.h)
//   TURNER_BLOCK(Name, id, access, Type, variable, extent, what)   a storage buffer with a block of Type
//   TURNER_ARRAY(Name, id, variable, what)               a part of the scene, in words of 16 bytes (buffer_access.glsl)
//
// Ids and bindings are named kSpec<Name> and kBind<Name> (layout.h). Constants that no scene and no setting needs are
// compiled out: the driver compiles the kernel for the values at hand.
#ifndef TURNER_CONSTANT
#define TURNER_CONSTANT(Name, id, type, NAME, value)
#endif
#ifndef TURNER_FEATURE
#define TURNER_FEATURE(Name, id, type, NAME, value, member)
#endif
#ifndef TURNER_BLOCK
#define TURNER_BLOCK(Name, id, access, Type, variable, extent, what)
#endif
#ifndef TURNER_ARRAY
#define TURNER_ARRAY(Name, id, variable, what)
#endif

// --- specialisation constants; id 0 is the size of a work-group, kSpecWorkGroup ---
TURNER_CONSTANT(Depth, 1, uint, DEPTH, 5u)      // levels of the ray tree
TURNER_CONSTANT(Samples, 2, uint, SAMPLES, 1u)  // n of the n x n grid in each pixel
TURNER_FEATURE(Lights, 3, uint, LIGHTS, 1u, lights)
TURNER_FEATURE(Spheres, 4, bool, SPHERES, true, spheres)
TURNER_FEATURE(Triangles, 5, bool, TRIANGLES, true, triangles)
TURNER_FEATURE(SmoothNormals, 6, bool, SMOOTH_NORMALS, true, smoothNormals)
TURNER_FEATURE(Highlights, 7, bool, HIGHLIGHTS, true, highlights)
TURNER_FEATURE(Reflection, 8, bool, REFLECTION, true, reflection)
TURNER_FEATURE(Refraction, 9, bool, REFRACTION, true, refraction)
TURNER_FEATURE(Falloff, 10, bool, FALLOFF, true, falloff)                    // a light with inverse-square fall-off
TURNER_CONSTANT(Sampler, 11, uint, SAMPLER, kGrid)                           // kGrid, kJitter or kSobol
TURNER_CONSTANT(Counters, 12, bool, COUNTERS, false)                         // count rays, nodes and primitives
TURNER_FEATURE(NearestNodes, 13, bool, NEAREST_NODES, true, nearestNodes)    // nearest hits need nodes, not cell lists alone
TURNER_FEATURE(ShadowNodes, 14, bool, SHADOW_NODES, true, shadowNodes)       // shadow rays do
TURNER_CONSTANT(Budget, 15, uint, BUDGET, 1u)                                // iterations of an invocation's loops in one dispatch
TURNER_CONSTANT(Fresh, 16, bool, FRESH, true)                                // the first pass over a tile: nothing to resume
TURNER_FEATURE(NearSpheres, 17, bool, NEAR_SPHERES, true, nearSpheres)       // a sphere whose surface the eye is near, compared with its radius
TURNER_FEATURE(FarSpheres, 18, bool, FAR_SPHERES, true, farSpheres)          // a sphere many radii away from the eye
TURNER_FEATURE(NestedDielectrics, 19, bool, NESTED_DIELECTRICS, true, dielectrics)  // solids of glass that overlap or touch
// The prime factors of n in ascending order, a byte each from the lowest on, in two words, as sobol needs them; else 0.
TURNER_CONSTANT(RadicesLow, 20, uint, RADICES_LOW, 0u)
TURNER_CONSTANT(RadicesHigh, 21, uint, RADICES_HIGH, 0u)
TURNER_FEATURE(Cones, 22, bool, CONES, true, cones)
TURNER_FEATURE(SlopedCones, 23, bool, SLOPED_CONES, true, slopedCones)       // a cone that is no cylinder
TURNER_FEATURE(SteepCones, 24, bool, STEEP_CONES, true, steepCones)          // one that is flatter than 45 degrees
TURNER_FEATURE(FarCones, 25, bool, FAR_CONES, true, farCones)                // a cone many radii away from the eye
TURNER_CONSTANT(LoopsAtHead, 26, bool, LOOPS_AT_HEAD, false)                 // the device needs loops that end at their head

// --- bindings of descriptor set 0 ---
TURNER_BLOCK(Frame, 0, readonly, Frame, frameInMemory, , "the frame")
TURNER_BLOCK(State, 1, , Word4, state, [], "the state of the invocations")
TURNER_BLOCK(Pixels, 2, , Word4, pixels, [], "the pixels")  // of the tile, row by row: RGB; w: path state
TURNER_BLOCK(Status, 3, , Status, status, , "the status")
TURNER_ARRAY(Nodes, 4, nodes, "the nodes")
TURNER_ARRAY(Primitives, 5, primitives, "the primitives")
TURNER_ARRAY(VertexNormals, 6, vertexNormals, "the vertex normals")
TURNER_ARRAY(Materials, 7, materials, "the materials")
TURNER_ARRAY(Lights, 8, lights, "the lights")
TURNER_ARRAY(LightBuffers, 9, lightBuffers, "the light buffers")

#undef TURNER_CONSTANT
#undef TURNER_FEATURE
#undef TURNER_BLOCK
#undef TURNER_ARRAY
// clang-format on
