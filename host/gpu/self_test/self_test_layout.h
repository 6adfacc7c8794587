// Sizes and numbers of the self-test, read by C++ and by GLSL.
#ifndef TURNER_SELF_TEST_LAYOUT_H
#define TURNER_SELF_TEST_LAYOUT_H

#ifdef __cplusplus
#include <cstdint>
namespace turner::gpu {
#define TURNER_CONST inline constexpr uint32_t
#else
#define TURNER_CONST const uint
#endif

TURNER_CONST kSelfTestLoopsAtHead = 0u;    // id of the specialisation constant
TURNER_CONST kSelfTestInvocations = 128u;  // one work-group, which every device has
TURNER_CONST kSelfTestLeaves = 128u;       // of the tree: the first reference that is a leaf
TURNER_CONST kSelfTestWords = 512u;        // more than twice the leaves, as the last leaves end beyond
TURNER_CONST kSelfTestStack = 16u;
TURNER_CONST kSelfTestStates = 4u;  // words of each invocation

// Words of the results, of each invocation.
TURNER_CONST kCheckWords = 0u;
TURNER_CONST kCheckTraversal = 1u;
TURNER_CONST kCheckIntegers = 2u;
TURNER_CONST kCheckSum = 3u;
TURNER_CONST kCheckProduct = 4u;
TURNER_CONST kCheckArea = 5u;
TURNER_CONST kChecks = 6u;
TURNER_CONST kCheckedCounter = kChecks * kSelfTestInvocations;  // and behind them one word, which all increase

#ifdef __cplusplus
}  // namespace turner::gpu
#endif
#undef TURNER_CONST
#endif
