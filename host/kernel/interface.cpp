// Tables made from layout.h at compile time; what layout.h counts or measures, they are checked against.
#include "kernel/interface.h"

#include <cstddef>
#include <iterator>
#include <type_traits>

#include "layout.h"

namespace turner {
namespace {

template <class Member>
constexpr HostMember hostMember(const char* name, size_t offset) {
  using Element = std::remove_extent_t<Member>;
  static_assert(std::is_same_v<Element, gpu::Row> || std::is_same_v<Element, gpu::uint>);
  return {name, uint32_t(offset), std::is_same_v<Element, gpu::Row> ? "uvec4" : "uint", uint32_t(std::extent_v<Member>),
          uint32_t(sizeof(Member))};
}
#define HOST_MEMBER(Struct, member) hostMember<decltype(gpu::Struct::member)>(#member, offsetof(gpu::Struct, member))

constexpr HostMember kFrame[] = {
    HOST_MEMBER(Frame, centreHi),   HOST_MEMBER(Frame, centreLo), HOST_MEMBER(Frame, rightHi),
    HOST_MEMBER(Frame, rightLo),    HOST_MEMBER(Frame, downHi),   HOST_MEMBER(Frame, downLo),
    HOST_MEMBER(Frame, background), HOST_MEMBER(Frame, media),    HOST_MEMBER(Frame, addresses),
};
constexpr HostMember kTile[] = {
    HOST_MEMBER(Tile, x0),    HOST_MEMBER(Tile, y0),         HOST_MEMBER(Tile, width),  HOST_MEMBER(Tile, height),
    HOST_MEMBER(Tile, slots), HOST_MEMBER(Tile, firstGroup), HOST_MEMBER(Tile, groups), HOST_MEMBER(Tile, stride),
};
constexpr HostMember kStatus[] = {
    HOST_MEMBER(Status, unfinished),
    HOST_MEMBER(Status, limiter),
    HOST_MEMBER(Status, samplesWaiting),
    HOST_MEMBER(Status, mediaLost),
};
#undef HOST_MEMBER

// The tables name every member: there are no bytes between them.
constexpr size_t bytesOf(std::span<const HostMember> members) {
  size_t bytes = 0;
  for (const HostMember& member : members) bytes += member.size;
  return bytes;
}
static_assert(bytesOf(kFrame) == sizeof(gpu::Frame) && bytesOf(kTile) == sizeof(gpu::Tile) &&
              bytesOf(kStatus) == sizeof(gpu::Status));

constexpr HostBlock kFrameBlock = {"Frame", kFrame}, kTileBlock = {"Tile", kTile}, kStatusBlock = {"Status", kStatus},
                    kRowsBlock = {"", {}};

constexpr HostBinding kBindings[] = {
    {gpu::kBindFrame, "kBindFrame", "frameInMemory", "the frame", kFrameBlock},
    {gpu::kBindState, "kBindState", "state", "the state of the invocations", kRowsBlock},
    {gpu::kBindPixels, "kBindPixels", "pixels", "the pixels", kRowsBlock},
    {gpu::kBindStatus, "kBindStatus", "status", "the status", kStatusBlock},
    {gpu::kBindNodes, "kBindNodes", "nodes", "the nodes", kRowsBlock},
    {gpu::kBindPrimitives, "kBindPrimitives", "primitives", "the primitives", kRowsBlock},
    {gpu::kBindVertexNormals, "kBindVertexNormals", "vertexNormals", "the vertex normals", kRowsBlock},
    {gpu::kBindMaterials, "kBindMaterials", "materials", "the materials", kRowsBlock},
    {gpu::kBindLights, "kBindLights", "lights", "the lights", kRowsBlock},
    {gpu::kBindLightBuffers, "kBindLightBuffers", "cubes", "the cubes of directions", kRowsBlock},
};
static_assert(std::size(kBindings) == gpu::kBindCount);

constexpr HostConstant kConstants[] = {
    {gpu::kSpecWorkGroup, "kSpecWorkGroup", "", false},
    {gpu::kSpecDepth, "kSpecDepth", "DEPTH", false},
    {gpu::kSpecSamples, "kSpecSamples", "SAMPLES", false},
    {gpu::kSpecLights, "kSpecLights", "LIGHTS", false},
    {gpu::kSpecSpheres, "kSpecSpheres", "SPHERES", true},
    {gpu::kSpecTriangles, "kSpecTriangles", "TRIANGLES", true},
    {gpu::kSpecSmoothNormals, "kSpecSmoothNormals", "SMOOTH_NORMALS", true},
    {gpu::kSpecHighlights, "kSpecHighlights", "HIGHLIGHTS", true},
    {gpu::kSpecReflection, "kSpecReflection", "REFLECTION", true},
    {gpu::kSpecRefraction, "kSpecRefraction", "REFRACTION", true},
    {gpu::kSpecFalloff, "kSpecFalloff", "FALLOFF", true},
    {gpu::kSpecSampler, "kSpecSampler", "SAMPLER", false},
    {gpu::kSpecCounters, "kSpecCounters", "COUNTERS", true},
    {gpu::kSpecNearestNodes, "kSpecNearestNodes", "NEAREST_NODES", true},
    {gpu::kSpecShadowNodes, "kSpecShadowNodes", "SHADOW_NODES", true},
    {gpu::kSpecBudget, "kSpecBudget", "BUDGET", false},
    {gpu::kSpecFresh, "kSpecFresh", "FRESH", true},
    {gpu::kSpecNearSpheres, "kSpecNearSpheres", "NEAR_SPHERES", true},
    {gpu::kSpecFarSpheres, "kSpecFarSpheres", "FAR_SPHERES", true},
    {gpu::kSpecNestedDielectrics, "kSpecNestedDielectrics", "NESTED_DIELECTRICS", true},
    {gpu::kSpecRadicesLow, "kSpecRadicesLow", "RADICES_LOW", false},
    {gpu::kSpecRadicesHigh, "kSpecRadicesHigh", "RADICES_HIGH", false},
};
static_assert(std::size(kConstants) == gpu::kSpecCount);

// The tables are looked up by number.
template <class Entry, size_t n>
constexpr bool areInOrder(const Entry (&entries)[n], uint32_t Entry::*number) {
  for (size_t i = 0; i < n; ++i)
    if (entries[i].*number != i) return false;
  return true;
}
static_assert(areInOrder(kBindings, &HostBinding::binding) && areInOrder(kConstants, &HostConstant::id));

}  // namespace

std::string glslType(const HostMember& member) {
  return member.type + (member.length ? '[' + std::to_string(member.length) + ']' : std::string());
}

std::span<const HostBinding> hostBindings() {
  return kBindings;
}

std::span<const HostConstant> hostConstants() {
  return kConstants;
}

HostBlock hostTile() {
  return kTileBlock;
}

}  // namespace turner
