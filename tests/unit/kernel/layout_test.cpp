// shaders/layout.h as C++ compiles it against layout.h as the kernel's SPIR-V has it.
#include <gtest/gtest.h>

#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "layout.h"
#include "support/shader_harness.h"

namespace turner {
namespace {

// The instructions that this test reads; numbers from the SPIR-V specification.
constexpr uint32_t kOpName = 5, kOpMemberName = 6, kOpMemberDecorate = 72, kOpDecorate = 71;
constexpr uint32_t kDecorationArrayStride = 6, kDecorationOffset = 35, kDecorationBinding = 33;

struct SpirvNames {
  std::map<std::pair<std::string, std::string>, uint32_t> offsets;  // (struct, member) -> byte offset
  std::map<uint32_t, int> bindings;                                 // binding -> how many blocks have it
  std::vector<uint32_t> arrayStrides;
};

SpirvNames readNames(const std::vector<uint32_t>& words) {
  std::map<uint32_t, std::string> names;
  std::map<std::pair<uint32_t, uint32_t>, std::string> memberNames;
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> memberOffsets;
  SpirvNames result;
  for (size_t at = 5; at < words.size();) {
    const uint32_t length = words[at] >> 16, op = words[at] & 0xffff;
    EXPECT_GT(length, 0u);
    if (length == 0) break;
    const auto text = [&](size_t word) { return std::string(reinterpret_cast<const char*>(&words[at + word])); };
    if (op == kOpName) names[words[at + 1]] = text(2);
    if (op == kOpMemberName) memberNames[{words[at + 1], words[at + 2]}] = text(3);
    if (op == kOpMemberDecorate && words[at + 3] == kDecorationOffset)
      memberOffsets[{words[at + 1], words[at + 2]}] = words[at + 4];
    if (op == kOpDecorate && words[at + 2] == kDecorationArrayStride) result.arrayStrides.push_back(words[at + 3]);
    if (op == kOpDecorate && words[at + 2] == kDecorationBinding) ++result.bindings[words[at + 3]];
    at += length;
  }
  for (const auto& [key, offset] : memberOffsets) result.offsets[{names[key.first], memberNames[key]}] = offset;
  return result;
}

TEST(Layout, OffsetsInSpirvAreThoseOfTheCompiler) {
  const SpirvNames names = readNames(test::compileKernel(BufferAccess::storageBuffer).words);
#define EXPECT_SAME_OFFSET(Struct, member)                                                \
  do {                                                                                    \
    const auto found = names.offsets.find({#Struct, #member});                            \
    ASSERT_NE(found, names.offsets.end()) << #Struct "." #member " is not in the SPIR-V"; \
    EXPECT_EQ(found->second, offsetof(gpu::Struct, member)) << #Struct "." #member;       \
  } while (false)
  EXPECT_SAME_OFFSET(Frame, centreHi);
  EXPECT_SAME_OFFSET(Frame, root);
  EXPECT_SAME_OFFSET(Frame, centreLo);
  EXPECT_SAME_OFFSET(Frame, width);
  EXPECT_SAME_OFFSET(Frame, rightHi);
  EXPECT_SAME_OFFSET(Frame, height);
  EXPECT_SAME_OFFSET(Frame, rightLo);
  EXPECT_SAME_OFFSET(Frame, seed);
  EXPECT_SAME_OFFSET(Frame, downHi);
  EXPECT_SAME_OFFSET(Frame, minWeight);
  EXPECT_SAME_OFFSET(Frame, downLo);
  EXPECT_SAME_OFFSET(Frame, threads);
  EXPECT_SAME_OFFSET(Frame, background);
  EXPECT_SAME_OFFSET(Frame, canaryLength);
  EXPECT_SAME_OFFSET(Frame, media);
  EXPECT_SAME_OFFSET(Frame, addresses);
  EXPECT_SAME_OFFSET(Tile, x0);
  EXPECT_SAME_OFFSET(Tile, y0);
  EXPECT_SAME_OFFSET(Tile, width);
  EXPECT_SAME_OFFSET(Tile, height);
  EXPECT_SAME_OFFSET(Tile, firstGroup);
  EXPECT_SAME_OFFSET(Tile, groups);
  EXPECT_SAME_OFFSET(Tile, stride);
  EXPECT_SAME_OFFSET(Tile, slots);
  EXPECT_SAME_OFFSET(Status, unfinished);
  EXPECT_SAME_OFFSET(Status, limiter);
  EXPECT_SAME_OFFSET(Status, samplesWaiting);
  EXPECT_SAME_OFFSET(Status, mediaLost);
#undef EXPECT_SAME_OFFSET
}

TEST(Layout, ArraysInSpirvHaveTheStrideOfTheCompiler) {
  std::map<uint32_t, int> found;
  for (const uint32_t stride : readNames(test::compileKernel(BufferAccess::storageBuffer).words).arrayStrides)
    ++found[stride];
  // The frame's addresses, state, pixels and the scene's arrays, all in rows.
  EXPECT_EQ(found, (std::map<uint32_t, int>{{uint32_t(sizeof(gpu::Word4)), found[sizeof(gpu::Word4)]}}));
  EXPECT_GT(found[sizeof(gpu::Word4)], 0);
}

TEST(Layout, BindingsAreThoseOfTheHeader) {
  for (const BufferAccess access :
       {BufferAccess::texelBuffer, BufferAccess::storageBuffer, BufferAccess::deviceAddress}) {
    SCOPED_TRACE(accessName(access));
    std::map<uint32_t, int> bindings = readNames(test::compileKernel(access).words).bindings;
    const uint32_t count = access == BufferAccess::deviceAddress ? gpu::kBindNodes : gpu::kBindCount;
    EXPECT_EQ(bindings.size(), size_t(count));
    for (uint32_t binding = 0; binding < count; ++binding) EXPECT_EQ(bindings[binding], 1) << binding;
  }
}

}  // namespace
}  // namespace turner
