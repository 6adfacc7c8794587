// shaders/layout.h as C++ compiles it, compared with layout.h as the kernel's SPIR-V has it.
#include <gtest/gtest.h>
#include <glslang/SPIRV/spirv.hpp>

#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "kernel/spirv_module.h"
#include "layout.h"
#include "support/shader_harness.h"

namespace turner {
namespace {

struct SpirvNames {
  std::map<std::pair<std::string, std::string>, uint32_t> offsets;  // (struct, member) -> byte offset
  std::map<uint32_t, int> bindings;                                 // binding -> how many blocks have it
  std::vector<uint32_t> arrayStrides;
};

SpirvNames readNames(const std::vector<uint32_t>& words) {
  const SpirvModule module = readSpirvModule(words);
  SpirvNames result;
  for (const auto& [member, value] : module.memberDecorations) {
    const auto& [structure, index, decoration] = member;
    if (decoration == spv::DecorationOffset)
      result.offsets[{module.name(structure), module.memberName(structure, index)}] = value;
  }
  for (const auto& [decorated, value] : module.decorations) {
    if (decorated.second == spv::DecorationArrayStride) result.arrayStrides.push_back(value);
    if (decorated.second == spv::DecorationBinding) ++result.bindings[value];
  }
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
