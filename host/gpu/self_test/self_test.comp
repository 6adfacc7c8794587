// What the kernel relies on and a driver may get wrong, each by itself. In: random words. Out: of each invocation one word
// for each check; the host computes them too (self_test.cpp). Nothing here asks for what Vulkan leaves open: subnormal
// numbers, NaN in min() and max(), the last bits of a division.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "self_test_layout.h"

layout(constant_id = kSelfTestLoopsAtHead) const bool LOOPS_AT_HEAD = false;
layout(local_size_x = kSelfTestInvocations) in;
layout(push_constant) uniform PushConstants { uvec2 address; };
layout(std430, binding = 0) buffer Results { uint results[]; };
layout(std430, binding = 1) buffer States { uint states[]; };  // cleared

// The same three ways as in buffer_access.glsl.
#if BUFFER_ACCESS == 0
layout(binding = 2, rgba32ui) readonly uniform uimageBuffer words;
#define WORD4(i) imageLoad(words, int(i))
#elif BUFFER_ACCESS == 1
layout(std430, binding = 2) readonly buffer Words { uvec4 words[]; };
#define WORD4(i) words[i]
#else
#extension GL_EXT_buffer_reference_uvec2 : require
layout(std430, buffer_reference, buffer_reference_align = 16) readonly buffer WordsAt { uvec4 at[]; };
#define WORD4(i) WordsAt(address).at[i]
#endif

#include "float_float.glsl"

uint invocation;

uint hash(uint x) {
  x = (x ^ (x >> 16u)) * 0x7feb352du;
  x = (x ^ (x >> 15u)) * 0x846ca68bu;
  return x ^ (x >> 16u);
}

// In brief, all checks are one word, since lavapipe takes 8 ms to compile a store. In detail, each has its own.
#ifdef IN_DETAIL
void report(const uint check, const uint value) { results[check * kSelfTestInvocations + invocation] = value; }
#else
uint all = 0u;
void report(const uint check, const uint value) { all = hash(all ^ value); }
#endif
// A result and its rest in one word; a rest of -0 is 0.
void report(const uint check, const float value, const float rest) {
  report(check, hash(floatBitsToUint(value)) + (rest == 0.0 ? 0u : floatBitsToUint(rest)));
}

// A number in [1, 2) or (-2, -1], times a power of two from 1/16 to 8: sums and products of two have room in a double.
float numberOf(const uint bits) {
  return uintBitsToFloat((bits & 0x807fffffu) | ((123u + ((bits >> 23u) & 7u)) << 23u));
}

uint stack[kSelfTestStack];

// The loops of a traversal: references from a stack, nodes, leaves, each with a loop of its own and a budget for all. What
// a lane has computed in its own last turn is what it has behind the loop. A node has two children, a leaf up to four
// words; which are taken depends on the lane's key. Some words are kept in a buffer, and read in another branch.
uint walkTree(const uint key, int budget) {
  uint top = 0u, next = 1u, sum = 0u;
  do {
    if (LOOPS_AT_HEAD && ((next == 0u && top == 0u) || budget <= 0)) break;
    --budget;
    if (next == 0u && top > 0u) {
      --top;
      next = stack[top];
    }
    if (next > 0u && next < kSelfTestLeaves && budget > 0) {
      do {
        if (LOOPS_AT_HEAD && (next >= kSelfTestLeaves || budget <= 0)) break;
        --budget;
        uvec4 word = WORD4(next);
        bool both = ((word.z ^ key) & 3u) != 0u, first = ((word.w ^ key) & 4u) != 0u;
        uint nearer = 2u * next + uint(first), farther = 2u * next + uint(!first);
        if (both) {
          stack[top] = farther;
          ++top;
        }
        next = nearer;
      } while (LOOPS_AT_HEAD || (next < kSelfTestLeaves && budget > 0));
    }
    if (next >= kSelfTestLeaves && budget > 0) {
      uint left = 1u + (next & 3u);
      do {
        if (LOOPS_AT_HEAD && (next == 0u || budget <= 0)) break;
        --budget;
        uvec4 word = WORD4(next + left);
        bool taken = ((word.x ^ key) & 8u) != 0u;
        if (taken)
          sum = sum * 31u + word.y;
        else if ((word.x & 1u) != 0u)
          states[(next & 3u) * kSelfTestInvocations + invocation] = word.z;
        else
          sum ^= states[(left & 3u) * kSelfTestInvocations + invocation];
        --left;
        if (left == 0u || (word.z & 48u) == 0u) next = 0u;
      } while (LOOPS_AT_HEAD || (next > 0u && budget > 0));
    }
  } while (LOOPS_AT_HEAD || ((next > 0u || top > 0u) && budget > 0));
  return sum + uint(budget);
}

// Each product rounded by itself: the signed area of an edge (triangle.glsl).
float edgeArea(const vec2 from, const vec2 to) {
  precise float area = to.x * from.y - to.y * from.x;
  return area;
}

void main() {
  invocation = gl_LocalInvocationIndex;
  uvec4 random = WORD4(invocation);
  report(kCheckWords, random.x ^ random.y ^ random.z ^ random.w);
  report(kCheckTraversal, walkTree(random.y, 1 + int(random.z % 300u)));

  report(kCheckIntegers, hash(random.x) + uint(findMSB(random.y | 1u)) + uint(findLSB(random.z | 0x80000000u)) +
                             (random.w << (random.x & 31u)) + floatBitsToUint(float(random.w & 0xffffffu)) +
                             random.z % 255u);

  float a = numberOf(random.x), b = numberOf(random.y), c = numberOf(random.z), d = numberOf(random.w), rest;
  float sum = twoSum(a, b, rest);
  report(kCheckSum, sum, rest);
  float product = twoProduct(c, d, rest);
  report(kCheckProduct, product, rest);
  // Both ends of the edge lie on a line through the origin but for roundings, of which the area then consists.
  float scale = numberOf(random.z ^ random.w);
  precise vec2 end = vec2(a * scale, b * scale);
  report(kCheckArea, scale, edgeArea(vec2(a, b), end));
#ifndef IN_DETAIL
  results[invocation] = all;
#endif
  atomicAdd(results[kCheckedCounter], 1u);
}
