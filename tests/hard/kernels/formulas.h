// What formulas.comp is given and what it finds, in rows of layout.h. Read by C++ and GLSL, after layout.h.
#ifndef TURNER_HARD_FORMULAS_H
#define TURNER_HARD_FORMULAS_H

#ifdef __cplusplus
namespace turner::gpu {
#define TURNER_CONST inline constexpr uint
#else
#define TURNER_CONST const uint
#endif

TURNER_CONST kBindLitGiven = 1u, kBindLitFound = 2u;
TURNER_CONST kSpecNaive = 40u;  // a boolean, beyond the kernel's ids: textbook formulas

// A light and a surface.
TURNER_CONST kLitPoint = 0u;     // w: shininess (float)
TURNER_CONST kLitNormal = 1u;    // w: q of (1 - q)^shininess (float)
TURNER_CONST kLitView = 2u;      // V
TURNER_CONST kLitLight = 3u;     // w: 1: falls off with the distance's square
TURNER_CONST kLitColor = 4u;     // E
TURNER_CONST kLitDiffuse = 5u;   // k_d
TURNER_CONST kLitSpecular = 6u;  // k_s
TURNER_CONST kLitRows = 7u;

TURNER_CONST kLitRadiance = 0u;  // w: (1 - q)^shininess (float)
TURNER_CONST kLitFoundRows = 1u;

#ifdef __cplusplus
}  // namespace turner::gpu
#endif
#undef TURNER_CONST
#endif
