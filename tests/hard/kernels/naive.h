// The rows of naive.comp's tree and primitives. Read by C++ and GLSL, after layout.h.
#ifndef TURNER_HARD_NAIVE_H
#define TURNER_HARD_NAIVE_H

#ifdef __cplusplus
namespace turner::gpu {
#define TURNER_CONST inline constexpr uint
#else
#define TURNER_CONST const uint
#endif

// The root is node 0; the children of a node are neighbours.
TURNER_CONST kNaiveLo = 0u;  // w: first child, or of a leaf its first primitive
TURNER_CONST kNaiveHi = 1u;  // w: primitives of a leaf; 0: not a leaf
TURNER_CONST kNaiveNodeRows = 2u;
// Primitives, leaf by leaf: centre, v0 or base, w: id | v1 or apex, w: 0 for spheres, 1 for triangles, 2 for cones |
// radius, v2, or radii of base and apex, w: material
TURNER_CONST kNaivePrimitiveRows = 3u;

#ifdef __cplusplus
}  // namespace turner::gpu
#endif
#undef TURNER_CONST
#endif
