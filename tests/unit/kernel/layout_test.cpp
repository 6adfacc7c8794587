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
  EXPECT_SAME_OFFSET(Frame, centreLo);
  EXPECT_SAME_OFFSET(Frame, rightHi);
  EXPECT_SAME_OFFSET(Frame, rightLo);
  EXPECT_SAME_OFFSET(Frame, downHi);
  EXPECT_SAME_OFFSET(Frame, downLo);
  EXPECT_SAME_OFFSET(Frame, background);
  EXPECT_SAME_OFFSET(Frame, addresses);
  EXPECT_SAME_OFFSET(Tile, x0);
  EXPECT_SAME_OFFSET(Tile, y0);
  EXPECT_SAME_OFFSET(Tile, width);
  EXPECT_SAME_OFFSET(Tile, height);
  EXPECT_SAME_OFFSET(Tile, slots);
  EXPECT_SAME_OFFSET(Tile, firstGroup);
  EXPECT_SAME_OFFSET(Tile, groups);
  EXPECT_SAME_OFFSET(Status, unfinished);
  EXPECT_SAME_OFFSET(Status, limiter);
  EXPECT_SAME_OFFSET(Status, samplesWaiting);
#undef EXPECT_SAME_OFFSET
}

TEST(Layout, ArraysInSpirvHaveTheStrideOfTheCompiler) {
  std::map<uint32_t, int> found;
  for (const uint32_t stride : readNames(test::compileKernel(BufferAccess::storageBuffer).words).arrayStrides)
    ++found[stride];
  // The frame's addresses, state, pixels and the scene's arrays, all in rows.
  EXPECT_EQ(found, (std::map<uint32_t, int>{{uint32_t(sizeof(gpu::Row)), found[sizeof(gpu::Row)]}}));
  EXPECT_GT(found[sizeof(gpu::Row)], 0);
}

// The kernel fetches row by row: its numbers of rows against the structures that the host writes.
TEST(Layout, RowsAreWhereTheKernelFetchesThem) {
  constexpr size_t row = sizeof(gpu::Row);
  EXPECT_EQ(offsetof(gpu::Node, origin), gpu::kNodeOrigin * row);
  EXPECT_EQ(offsetof(gpu::Node, planes), gpu::kNodePlanes * row);
  EXPECT_EQ(sizeof(gpu::Node), gpu::kNodeRows * row);
  EXPECT_EQ(offsetof(gpu::Sphere, center), gpu::kSphereCenter * row);
  EXPECT_EQ(offsetof(gpu::Sphere, tags), gpu::kSphereTags * row);
  EXPECT_EQ(offsetof(gpu::TrianglePair, v0), gpu::kPairV0 * row);
  EXPECT_EQ(offsetof(gpu::TrianglePair, v1), gpu::kPairV1 * row);
  EXPECT_EQ(offsetof(gpu::TrianglePair, v2), gpu::kPairV2 * row);
  EXPECT_EQ(offsetof(gpu::TrianglePair, v3), gpu::kPairV3 * row);
  EXPECT_EQ(offsetof(gpu::TrianglePair, normals), gpu::kPairNormals * row);
  EXPECT_EQ(sizeof(gpu::VertexNormals), gpu::kVertexNormalsRows * row);
  EXPECT_EQ(offsetof(gpu::Material, diffuse), gpu::kMaterialDiffuse * row);
  EXPECT_EQ(offsetof(gpu::Material, specular), gpu::kMaterialSpecular * row);
  EXPECT_EQ(offsetof(gpu::Material, other), gpu::kMaterialOther * row);
  EXPECT_EQ(sizeof(gpu::Material), gpu::kMaterialRows * row);
  EXPECT_EQ(offsetof(gpu::Light, position), gpu::kLightPosition * row);
  EXPECT_EQ(offsetof(gpu::Light, color), gpu::kLightColor * row);
  EXPECT_EQ(sizeof(gpu::Light), gpu::kLightRows * row);
  EXPECT_EQ(6 * sizeof(gpu::LightBufferFace), gpu::kLightBufferRows * row);
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
