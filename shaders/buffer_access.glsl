// How the scene's words are read. Every driver has a way that it is good at, and the host compiles the kernel for one:
//   kAccessTexelBuffer     storage texel buffers: lavapipe 22.3 inlines these loads and loops over the lanes for all others
//   kAccessStorageBuffer   storage buffers: what every device has
//   kAccessDeviceAddress   buffer device addresses: no descriptors, no limit on a buffer's size
// WORD4(name, i) is word i of the named array in each of them; scene.h uses it, and what must not be edited.
#define kAccessTexelBuffer 0
#define kAccessStorageBuffer 1
#define kAccessDeviceAddress 2

#if BUFFER_ACCESS == kAccessTexelBuffer
#define WORDS(name, place) layout(binding = place, rgba32ui) readonly uniform uimageBuffer name
#define WORD4(name, i) imageLoad(name, int(i))
#elif BUFFER_ACCESS == kAccessStorageBuffer
#define WORDS(name, place) layout(std430, binding = place) readonly buffer name##Buffer { Word4 name[]; }
#define WORD4(name, i) name[i]
#else
#extension GL_EXT_buffer_reference_uvec2 : require
layout(std430, buffer_reference, buffer_reference_align = 16) readonly buffer WordsAt { Word4 at[]; };
#define WORDS(name, place) uvec2 name() { return frame.addresses[place - kBindNodes].xy; }
#define WORD4(name, i) WordsAt(name()).at[i]
#endif

#define TURNER_ARRAY(Name, id, variable, what) WORDS(variable, id);
#include "interface.h"
