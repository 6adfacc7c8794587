// Each table is one expansion of shaders/interface.h.
#include "kernel/host_interface.h"

#include <iterator>
#include <string_view>

#include "layout.h"

namespace turner {
namespace {

constexpr bool isBoolean(std::string_view type) {
  return type == "bool";
}

constexpr HostConstant kConstants[] = {
    {gpu::kSpecWorkGroup, "kSpecWorkGroup", "", false},
#define TURNER_CONSTANT(Name, id, type, NAME, value) {gpu::kSpec##Name, "kSpec" #Name, #NAME, isBoolean(#type)},
#define TURNER_FEATURE(Name, id, type, NAME, value, member) {gpu::kSpec##Name, "kSpec" #Name, #NAME, isBoolean(#type)},
#include "interface.h"
};

constexpr uint32_t kBindings[] = {
#define TURNER_BLOCK(Name, id, access, Type, variable, extent, what) id,
#define TURNER_ARRAY(Name, id, variable, what) id,
#include "interface.h"
};

// Tables are looked up by number: ids and bindings are given in order, without a gap.
constexpr bool areInOrder() {
  for (uint32_t i = 0; i < std::size(kConstants); ++i)
    if (kConstants[i].id != i) return false;
  for (uint32_t i = 0; i < std::size(kBindings); ++i)
    if (kBindings[i] != i) return false;
  return std::size(kConstants) == gpu::kSpecCount && std::size(kBindings) == gpu::kBindCount;
}
static_assert(areInOrder());

HostBlock hostBlock(const std::string& type) {
  return type == "Word4" ? HostBlock{} : HostBlock{type, layoutMembers(type)};
}

}  // namespace

std::string glslType(const LayoutMember& member) {
  return member.type + (member.length ? '[' + std::to_string(member.length) + ']' : std::string());
}

std::span<const HostBinding> hostBindings() {
  static const HostBinding bindings[] = {
#define TURNER_BLOCK(Name, id, access, Type, variable, extent, what) \
  {gpu::kBind##Name, "kBind" #Name, #variable, what, hostBlock(#Type)},
#define TURNER_ARRAY(Name, id, variable, what) {gpu::kBind##Name, "kBind" #Name, #variable, what, {}},
#include "interface.h"
  };
  return bindings;
}

std::span<const HostConstant> hostConstants() {
  return kConstants;
}

HostBlock hostTile() {
  return hostBlock("Tile");
}

}  // namespace turner
