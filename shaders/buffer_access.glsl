// How the scene's rows are fetched. Every driver has a way that it is good at, and the host compiles the kernel for one:
//   kAccessTexelBuffer     storage texel buffers: lavapipe 22.3 inlines these loads and loops over the lanes for all others
//   kAccessStorageBuffer    storage buffers: what every device has
//   kAccessDeviceAddress  buffer device addresses: no descriptors, no limit on a buffer's size
// ROW(name, i) is row i of the named array in each of them.
#define kAccessTexelBuffer 0
#define kAccessStorageBuffer 1
#define kAccessDeviceAddress 2

#if BUFFER_ACCESS == kAccessTexelBuffer
#define ROWS(name, place) layout(binding = place, rgba32ui) readonly uniform uimageBuffer name
#define ROW(name, i) imageLoad(name, int(i))
#elif BUFFER_ACCESS == kAccessStorageBuffer
#define ROWS(name, place) layout(std430, binding = place) readonly buffer name##Buffer { Row name[]; }
#define ROW(name, i) name[i]
#else
#extension GL_EXT_buffer_reference_uvec2 : require
layout(std430, buffer_reference, buffer_reference_align = 16) readonly buffer RowsAt { Row at[]; };
#define ROWS(name, place) uvec2 name() { return frame.addresses[place - kBindNodes].xy; }
#define ROW(name, i) RowsAt(name()).at[i]
#endif

ROWS(nodes, kBindNodes);
ROWS(primitives, kBindPrimitives);
ROWS(vertexNormals, kBindVertexNormals);
ROWS(materials, kBindMaterials);
ROWS(lights, kBindLights);
ROWS(lightBuffers, kBindLightBuffers);
