// Reads the module's declarations, which all stand before its first function, and compares them with tables made from
// layout.h. Of SPIR-V it knows the instructions that declare, by their numbers in the specification.
#include "kernel/kernel_check.h"

#include <spirv-tools/libspirv.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>

#include "base/errors.h"
#include "kernel/layout_text.h"
#include "kernel/source_names.h"
#include "kernel/spirv_words.h"
#include "layout.h"

namespace turner {
namespace {

enum Op : uint16_t {
  kOpName = 5,
  kOpMemberName = 6,
  kOpExtension = 10,
  kOpEntryPoint = 15,
  kOpCapability = 17,
  kOpTypeVoid = 19,
  kOpTypeBool = 20,
  kOpTypeInt = 21,
  kOpTypeFloat = 22,
  kOpTypeVector = 23,
  kOpTypeMatrix = 24,
  kOpTypeImage = 25,
  kOpTypeSampler = 26,
  kOpTypeSampledImage = 27,
  kOpTypeArray = 28,
  kOpTypeRuntimeArray = 29,
  kOpTypeStruct = 30,
  kOpTypePointer = 32,
  kOpTypeFunction = 33,
  kOpConstantTrue = 41,
  kOpConstant = 43,
  kOpSpecConstantTrue = 48,
  kOpSpecConstantFalse = 49,
  kOpSpecConstant = 50,
  kOpSpecConstantOp = 52,
  kOpFunction = 54,
  kOpVariable = 59,
  kOpDecorate = 71,
  kOpMemberDecorate = 72,
};
enum Decoration : uint32_t {
  kSpecId = 1,
  kArrayStride = 6,
  kBuiltIn = 11,
  kBinding = 33,
  kDescriptorSet = 34,
  kOffset = 35,
};
enum StorageClass : uint32_t {
  kUniformConstant = 0,
  kInput = 1,
  kUniform = 2,
  kWorkgroup = 4,
  kPrivate = 6,
  kPushConstant = 9,
  kStorageBuffer = 12,
};
constexpr uint32_t kGlCompute = 5, kWorkgroupSize = 25, kDimBuffer = 5, kStorageImage = 2, kRgba32ui = 30;

constexpr uint32_t kRuntime = 0xffffffff;  // length of an array that ends with its buffer

// --- what the host gives ---------------------------------------------------------------------------------------------

// A structure of the host's; without members a block is words.
struct HostBlock {
  std::string name;
  std::vector<LayoutMember> members;
};

struct HostBinding {
  uint32_t binding;
  const char* constant;  // its name in layout.h
  const char* variable;  // its name in the kernel
  const char* what;
  HostBlock block;
};

struct HostConstant {
  uint32_t id;
  const char* constant;  // its name in layout.h
  const char* variable;  // its name in the kernel
  bool isBoolean;        // else a 32-bit integer
};

HostBlock hostBlock(const std::string& type) {
  return type == "Word4" ? HostBlock{} : HostBlock{type, layoutMembers(type)};
}

// The lines of shaders/interface.h; entry i is binding or id i.
const std::vector<HostBinding>& hostBindings() {
  static const std::vector<HostBinding> bindings = {
#define TURNER_BLOCK(Name, id, access, Type, variable, extent, what) \
  {gpu::kBind##Name, "kBind" #Name, #variable, what, hostBlock(#Type)},
#define TURNER_ARRAY(Name, id, variable, what) {gpu::kBind##Name, "kBind" #Name, #variable, what, {}},
#include "interface.h"
  };
  return bindings;
}

constexpr bool isBoolean(std::string_view type) {
  return type == "bool";
}
constexpr HostConstant kConstants[] = {
    {gpu::kSpecWorkGroup, "kSpecWorkGroup", "", false},
#define TURNER_CONSTANT(Name, id, type, NAME, value) {gpu::kSpec##Name, "kSpec" #Name, #NAME, isBoolean(#type)},
#define TURNER_FEATURE(Name, id, type, NAME, value, member) TURNER_CONSTANT(Name, id, type, NAME, value)
#include "interface.h"
};

// Tables are looked up by number: ids and bindings are given in order, without a gap.
constexpr bool idsAreInOrder() {
  for (uint32_t i = 0; i < std::size(kConstants); ++i)
    if (kConstants[i].id != i) return false;
  return true;
}
static_assert(idsAreInOrder() && std::size(kConstants) == gpu::kSpecCount);
constexpr uint32_t kBindings[] = {
#define TURNER_BLOCK(Name, id, access, Type, variable, extent, what) id,
#define TURNER_ARRAY(Name, id, variable, what) id,
#include "interface.h"
};
constexpr bool bindingsAreInOrder() {
  for (uint32_t i = 0; i < std::size(kBindings); ++i)
    if (kBindings[i] != i) return false;
  return true;
}
static_assert(bindingsAreInOrder());

// What every Vulkan 1.2 device takes without a feature having been asked for; operations of subgroups are properties of
// the device, not features.
bool isOpenCapability(uint32_t capability, BufferAccess access) {
  constexpr uint32_t kMatrix = 0, kShader = 1, kInputAttachment = 40, kSampled1D = 43, kImage1D = 44,
                     kSampledBuffer = 46, kImageBuffer = 47, kImageQuery = 50, kDerivativeControl = 51,
                     kGroupNonUniform = 61, kGroupNonUniformQuad = 68, kDeviceGroup = 4437, kAddresses = 5347;
  switch (capability) {
    case kMatrix:
    case kShader:
    case kInputAttachment:
    case kSampled1D:
    case kImage1D:
    case kSampledBuffer:
    case kImageBuffer:
    case kImageQuery:
    case kDerivativeControl:
    case kDeviceGroup:
      return true;
    case kAddresses:
      return access == BufferAccess::deviceAddress;
    default:
      return capability >= kGroupNonUniform && capability <= kGroupNonUniformQuad;
  }
}

// --- what the module declares ----------------------------------------------------------------------------------------

struct EntryPoint {
  uint32_t model;
  std::string name;
};

struct Declarations {
  std::vector<uint32_t> capabilities;
  std::vector<std::string> extensions;
  std::vector<EntryPoint> entryPoints;
  std::map<uint32_t, std::vector<std::string>> names;  // an id may have several: the optimiser unites constants
  std::map<std::pair<uint32_t, uint32_t>, std::string> memberNames;                // (struct, member)
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> decorations;                   // (id, decoration)
  std::map<std::tuple<uint32_t, uint32_t, uint32_t>, uint32_t> memberDecorations;  // (struct, member, ...)
  std::map<uint32_t, SpirvInstruction> definitions;                                // types, constants, ...
  std::vector<uint32_t> variables;

  // An instruction of opcode 0 where there is none.
  SpirvInstruction definition(uint32_t id) const {
    const auto found = definitions.find(id);
    return found == definitions.end() ? SpirvInstruction() : found->second;
  }
  const uint32_t* decoration(uint32_t id, Decoration decoration) const {
    const auto found = decorations.find({id, decoration});
    return found == decorations.end() ? nullptr : &found->second;
  }
  std::string name(uint32_t id) const {
    const auto found = names.find(id);
    return found == names.end() ? "" : found->second[0];
  }
  std::string memberName(uint32_t structure, uint32_t member) const {
    const auto found = memberNames.find({structure, member});
    return found == memberNames.end() ? "" : found->second;
  }
  uint32_t memberOffset(uint32_t structure, uint32_t member) const {
    const auto found = memberDecorations.find({structure, member, kOffset});
    return found == memberDecorations.end() ? 0 : found->second;
  }
};

Declarations readDeclarations(std::span<const uint32_t> words) {
  Declarations module;
  SpirvInstruction instruction;
  for (size_t at = kSpirvHeaderWords; nextInstruction(words, at, instruction);) {
    const uint16_t op = instruction.opcode;
    const auto operand = [&](size_t i) { return instruction.operand(i); };
    if (op == kOpFunction) break;
    if (op == kOpCapability) module.capabilities.push_back(operand(0));
    if (op == kOpExtension) module.extensions.push_back(instruction.text(0));
    if (op == kOpEntryPoint) module.entryPoints.push_back({operand(0), instruction.text(2)});
    if (op == kOpName) {
      if (std::string name = instruction.text(1); !name.empty()) module.names[operand(0)].push_back(std::move(name));
    }
    if (op == kOpMemberName) module.memberNames[{operand(0), operand(1)}] = instruction.text(2);
    if (op == kOpDecorate) module.decorations[{operand(0), operand(1)}] = operand(2);
    if (op == kOpMemberDecorate) module.memberDecorations[{operand(0), operand(1), operand(2)}] = operand(3);
    if (op >= kOpTypeVoid && op <= kOpTypeFunction) module.definitions[operand(0)] = instruction;
    if (op >= kOpConstantTrue && op <= kOpSpecConstantOp) module.definitions[operand(1)] = instruction;
    if (op == kOpVariable) {
      module.definitions[operand(1)] = instruction;
      module.variables.push_back(operand(1));
    }
  }
  return module;
}

// A type as GLSL spells it.
std::string typeText(const Declarations& module, uint32_t id, int depth = 0) {
  constexpr int kDeepest = 8;  // no honest type nests deeper
  const SpirvInstruction type = module.definition(id);
  const auto inner = [&](size_t operand) {
    return depth < kDeepest ? typeText(module, type.operand(operand), depth + 1) : std::string("...");
  };
  switch (type.opcode) {
    case kOpTypeBool:
      return "bool";
    case kOpTypeInt: {
      const std::string sign = type.operand(2) ? "" : "u";
      return type.operand(1) == 32 ? sign + "int" : sign + "int" + std::to_string(type.operand(1)) + "_t";
    }
    case kOpTypeFloat:
      return type.operand(1) == 32   ? "float"
             : type.operand(1) == 64 ? "double"
                                     : "float" + std::to_string(type.operand(1)) + "_t";
    case kOpTypeVector: {
      const std::string component = inner(1), count = std::to_string(type.operand(2));
      if (component == "float") return "vec" + count;
      for (const char* known : {"uint", "int", "bool", "double"})
        if (component == known) return std::string(1, component[0]) + "vec" + count;
      return component + "[" + count + "]";
    }
    case kOpTypeMatrix:
      return "mat" + std::to_string(type.operand(2)) + " of " + inner(1);
    case kOpTypeArray:
    case kOpTypeRuntimeArray:
      return "array of " + inner(1);
    case kOpTypeStruct:
      return "struct " + module.name(id);
    case kOpTypePointer:
      return "reference to a buffer";
    default:
      return "type of another kind";
  }
}

// A member of a block, those of structures inside of it for themselves.
struct BlockMember {
  uint32_t structure;   // that declares it
  std::string name;     // empty where the names have been stripped
  uint32_t offset;      // in the block
  std::string type;     // of an array its elements'
  uint32_t length = 0;  // of an array, kRuntime if the buffer tells; else 0
  uint32_t stride = 0;  // of an array
};

void addMembers(const Declarations& module, uint32_t structure, uint32_t base, int depth,
                std::vector<BlockMember>& members) {
  constexpr int kDeepest = 8;
  const SpirvInstruction type = module.definition(structure);
  for (uint32_t i = 0; i + 1 < type.operands.size(); ++i) {
    const uint32_t memberType = type.operand(i + 1), offset = base + module.memberOffset(structure, i);
    const SpirvInstruction member = module.definition(memberType);
    if (member.opcode == kOpTypeStruct && depth < kDeepest) {
      addMembers(module, memberType, offset, depth + 1, members);
      continue;
    }
    BlockMember found{structure, module.memberName(structure, i), offset, typeText(module, memberType)};
    if (member.opcode == kOpTypeArray || member.opcode == kOpTypeRuntimeArray) {
      found.type = typeText(module, member.operand(1));
      const uint32_t* stride = module.decoration(memberType, kArrayStride);
      found.stride = stride ? *stride : 0;
      // A length that is a specialisation constant is no number yet; it fits nothing.
      const SpirvInstruction length = module.definition(member.operand(2));
      found.length =
          member.opcode == kOpTypeRuntimeArray || length.opcode != kOpConstant ? kRuntime : length.operand(2);
    }
    members.push_back(std::move(found));
  }
}

std::string typeOf(const BlockMember& member) {
  if (member.length == 0) return member.type;
  return member.type + '[' + (member.length == kRuntime ? "" : std::to_string(member.length)) + ']';
}

std::string typeOf(const LayoutMember& member) {
  return member.type + (member.length ? '[' + std::to_string(member.length) + ']' : std::string());
}

// --- the comparison --------------------------------------------------------------------------------------------------

class KernelCheck {
 public:
  KernelCheck(const Declarations& declarations, const std::vector<ShaderSource>& shaderSources, BufferAccess way)
      : module(declarations), sources(shaderSources), access(way) {}

  void checkEntryPoint();
  void checkCapabilities();
  void checkWorkGroup();
  void checkConstants();
  void checkVariables();

  std::vector<std::string> faults;

 private:
  // Notes a fault once: several variables may lead to the same one.
  void add(const SourceLocation& location, const std::string& message) {
    const std::string fault = faultAt(location) + message;
    if (std::find(faults.begin(), faults.end(), fault) == faults.end()) faults.push_back(fault);
  }
  void addOf(const std::vector<std::string>& names, const std::string& message) {
    add(findDeclaration(sources, names), message);
  }

  // A variable that is a resource, as the user sees it.
  struct Resource {
    uint32_t type;                   // what its pointer points to
    std::vector<std::string> names;  // its own, its block's, its block's first member's, as far as it has them
    std::string name() const { return names.empty() ? "a variable" : names[0]; }
  };
  Resource resourceOf(uint32_t variable, uint32_t type) const;
  void checkResource(uint32_t variable, const Resource& resource, uint32_t storage);
  void checkTexels(const Resource& resource, const HostBinding& host);
  void checkWords(const Resource& resource, const HostBinding& host);
  void checkBlock(const Resource& resource, const HostBlock& host);

  const Declarations& module;
  const std::vector<ShaderSource>& sources;
  BufferAccess access;
};

void KernelCheck::checkEntryPoint() {
  if (module.entryPoints.size() != 1 || module.entryPoints[0].model != kGlCompute ||
      module.entryPoints[0].name != "main")
    addOf({"main"}, "the kernel must have one entry point, a compute shader's main()");
}

// The name that the specification gives a capability, as the disassembler knows it: "Float64".
std::string capabilityName(uint32_t capability) {
  const std::vector<uint32_t> words = {0x07230203, 0x00010500, 0, 1, 0, 2u << 16 | kOpCapability, capability};
  std::string text;
  const bool isKnown =
      spvtools::SpirvTools(SPV_ENV_VULKAN_1_2).Disassemble(words, &text, SPV_BINARY_TO_TEXT_OPTION_NO_HEADER);
  const size_t start = text.find("OpCapability ");
  if (!isKnown || start == std::string::npos) return "capability " + std::to_string(capability);
  text.erase(0, start + std::string_view("OpCapability ").size());
  return text.substr(0, text.find_first_of(" \r\n"));
}

// Words that bring a capability in, to find the place.
std::vector<std::string> wordsOfCapability(const std::string& name) {
  if (name == "Float64") return {"double", "dvec2", "dvec3", "dvec4"};
  if (name == "Int64") return {"uint64_t", "int64_t", "u64vec2", "i64vec2"};
  if (name == "Int16" || name == "StorageBuffer16BitAccess") return {"uint16_t", "int16_t", "float16_t"};
  if (name == "Int8" || name == "StorageBuffer8BitAccess") return {"uint8_t", "int8_t"};
  if (name == "Float16") return {"float16_t", "f16vec2", "f16vec3", "f16vec4"};
  if (name == "PhysicalStorageBufferAddresses") return {"buffer_reference"};
  return {};
}

void KernelCheck::checkCapabilities() {
  for (const uint32_t capability : module.capabilities) {
    if (isOpenCapability(capability, access)) continue;
    const std::string name = capabilityName(capability);
    const bool isOtherAccess = name == "PhysicalStorageBufferAddresses";
    addOf(wordsOfCapability(name), "the kernel needs " + name + ", which turner's device is not opened with" +
                                       (isOtherAccess ? " where rows are fetched as " + accessName(access) +
                                                            "; read them by ROW() of buffer_access.glsl"
                                                      : "; do without it, 32-bit floats and integers are there"));
  }
  // Extensions are part of the device's as well. What SPIR-V 1.5 has taken in has no need to be asked for.
  for (const std::string& extension : module.extensions)
    addOf({"extension"}, "the kernel needs the SPIR-V extension " + extension +
                             ", which turner's device is not opened with; do without it");
}

void KernelCheck::checkWorkGroup() {
  const auto isOne = [&](uint32_t id) {
    const SpirvInstruction constant = module.definition(id);
    return constant.opcode == kOpConstant && constant.operand(2) == 1;
  };
  for (const auto& [decorated, builtIn] : module.decorations) {
    if (decorated.second != kBuiltIn || builtIn != kWorkgroupSize) continue;
    // The type and the id of the composite come before x, y and z.
    const SpirvInstruction size = module.definition(decorated.first);
    const uint32_t x = size.operand(2);
    const uint32_t* const id = module.decoration(x, kSpecId);
    if (module.definition(x).opcode == kOpSpecConstant && id && *id == gpu::kSpecWorkGroup && isOne(size.operand(3)) &&
        isOne(size.operand(4)))
      return;
  }
  addOf({"local_size_x_id", "local_size_x", "local_size_y_id", "local_size_y", "local_size_z_id", "local_size_z"},
        "the size of the work-group is not what turner sets: one specialisation constant in x, 1 in y and z; write "
        "layout(local_size_x_id = kSpecWorkGroup, local_size_y = 1, local_size_z = 1) in;");
}

void KernelCheck::checkConstants() {
  for (const auto& [decorated, id] : module.decorations) {
    if (decorated.second != kSpecId || id >= gpu::kSpecCount) continue;
    const auto found = module.names.find(decorated.first);
    const std::vector<std::string> names = found == module.names.end() ? std::vector<std::string>() : found->second;
    const std::string name = names.empty() ? "a specialisation constant" : names[0];
    const SpirvInstruction constant = module.definition(decorated.first);
    const bool isBoolean = constant.opcode == kOpSpecConstantTrue || constant.opcode == kOpSpecConstantFalse;
    const std::string type = isBoolean ? "bool" : typeText(module, constant.operand(0));
    const HostConstant& host = kConstants[id];
    if (host.isBoolean ? !isBoolean : type != "uint" && type != "int")
      addOf(names, name + " is a " + type + " with the constant_id of " + host.constant +
                       ", for which turner gives a " + (host.isBoolean ? "bool" : "uint") +
                       "; declare it so, or take an id from " + std::to_string(gpu::kSpecCount) +
                       " on for a constant of your own");
    for (const HostConstant& other : kConstants)
      if (other.id != id && std::find(names.begin(), names.end(), other.variable) != names.end())
        addOf({other.variable}, std::string(other.variable) + " has the constant_id of " + host.constant +
                                    ", but turner gives it as " + other.constant +
                                    "; write constant_id = " + other.constant);
  }
}

KernelCheck::Resource KernelCheck::resourceOf(uint32_t variable, uint32_t type) const {
  Resource resource{type, {}};
  for (const std::string& name : {module.name(variable), module.name(type), module.memberName(type, 0)})
    if (!name.empty()) resource.names.push_back(name);
  return resource;
}

void KernelCheck::checkVariables() {
  for (const uint32_t variable : module.variables) {
    const SpirvInstruction declaration = module.definition(variable);
    const uint32_t storage = declaration.operand(2);
    const Resource resource = resourceOf(variable, module.definition(declaration.operand(0)).operand(2));
    switch (storage) {
      case kInput:
      case kPrivate:
        break;
      case kWorkgroup:
        if (declaration.operands.size() > 3)
          addOf(resource.names, resource.name() +
                                    " is shared and has an initial value, for which turner's device is not "
                                    "opened; set it in main()");
        break;
      case kPushConstant:
        checkBlock(resource, hostBlock("Tile"));
        break;
      default:
        checkResource(variable, resource, storage);
    }
  }
}

void KernelCheck::checkResource(uint32_t variable, const Resource& resource, uint32_t storage) {
  const std::string name = resource.name();
  const uint16_t kind = module.definition(resource.type).opcode;
  const SpirvInstruction image = module.definition(resource.type);
  const bool isTexels = storage == kUniformConstant && kind == kOpTypeImage && image.operand(2) == kDimBuffer &&
                        image.operand(6) == kStorageImage;
  if (kind == kOpTypeArray || kind == kOpTypeRuntimeArray)
    return addOf(resource.names, name +
                                     " is an array of bindings; turner binds one buffer at each; declare them one by "
                                     "one, or an array inside of the block");
  if (storage == kUniform)
    return addOf(resource.names, name +
                                     " is a uniform buffer; turner binds none; take a const of your own, or what the "
                                     "frame and the tile hold (layout.h)");
  if (storage != kStorageBuffer && !isTexels)
    return addOf(resource.names, name + " is " +
                                     (kind == kOpTypeImage          ? "an image"
                                      : kind == kOpTypeSampler      ? "a sampler"
                                      : kind == kOpTypeSampledImage ? "a texture"
                                                                    : "a resource of a kind") +
                                     " that turner does not bind; all it binds are buffers (layout.h)");

  const uint32_t* const set = module.decoration(variable, kDescriptorSet);
  if (set && *set != 0)
    return addOf(resource.names, name + " is in descriptor set " + std::to_string(*set) +
                                     "; turner binds set 0 only; leave the set away");
  const uint32_t* const location = module.decoration(variable, kBinding);
  if (!location)
    return addOf(resource.names, name + " has no binding; write layout(binding = ...) with one of layout.h");
  const uint32_t count = bindingCount(access);
  if (*location >= count)
    return addOf(resource.names, name + " has binding " + std::to_string(*location) + "; turner binds 0 to " +
                                     std::to_string(count - 1) + " where rows are fetched as " + accessName(access) +
                                     (*location < gpu::kBindCount ? "; read rows by ROW() of buffer_access.glsl"
                                                                  : "; take one of these, with what it holds"));

  // A name of the kernel's that has wandered to another binding would read other data without a word.
  const HostBinding& host = hostBindings()[*location];
  for (const HostBinding& other : hostBindings())
    if (&other != &host &&
        std::find(resource.names.begin(), resource.names.end(), other.variable) != resource.names.end())
      return addOf(resource.names, name + " has binding " + std::to_string(*location) + ", where turner binds " +
                                       host.what + "; write binding = " + other.constant);
  const bool wantsTexels = bindsTexels(*location, access);
  if (isTexels != wantsTexels)
    return addOf(resource.names, name + " is a storage " + (isTexels ? "texel buffer" : "buffer") + "; at binding " +
                                     std::to_string(*location) + " turner binds " + host.what + " as a storage " +
                                     (wantsTexels ? "texel buffer; declare it by ROWS() of buffer_access.glsl"
                                                  : "buffer; declare it as a buffer block"));
  if (isTexels)
    checkTexels(resource, host);
  else if (host.block.members.empty())
    checkWords(resource, host);
  else
    checkBlock(resource, host.block);
}

void KernelCheck::checkTexels(const Resource& resource, const HostBinding& host) {
  const SpirvInstruction image = module.definition(resource.type);
  if (image.operand(7) == kRgba32ui && typeText(module, image.operand(1)) == "uint") return;
  addOf(resource.names, resource.name() + " has texels of another format; turner binds " + host.what +
                            " as rgba32ui; write layout(binding = " + host.constant + ", rgba32ui) and uimageBuffer");
}

void KernelCheck::checkWords(const Resource& resource, const HostBinding& host) {
  std::vector<BlockMember> members;
  addMembers(module, resource.type, 0, 0, members);
  if (members.size() == 1 && members[0].offset == 0 && members[0].type == "uvec4" && members[0].length == kRuntime &&
      members[0].stride == kWordBytes)
    return;
  std::string found = "nothing";
  if (!members.empty()) found = typeOf(members[0]) + (members.size() > 1 ? " and more" : "");
  if (members.size() == 1 && members[0].type == "uvec4")
    found += " at byte " + std::to_string(members[0].offset) + ", one element every " +
             std::to_string(members[0].stride) + " bytes";
  addOf(resource.names, resource.name() + " holds " + found + "; at binding " + std::to_string(host.binding) +
                            " turner binds " + host.what + ", which are rows without end; declare it as { Word4 " +
                            host.variable + "[]; } in std430, and turn words into floats by uintBitsToFloat()");
}

void KernelCheck::checkBlock(const Resource& resource, const HostBlock& host) {
  std::vector<BlockMember> members;
  addMembers(module, resource.type, 0, 0, members);
  for (const BlockMember& member : members) {
    const std::string name = member.name.empty() ? "a member" : member.name;
    const std::string here = "byte " + std::to_string(member.offset) + " of " + host.name;
    const auto at = std::find_if(host.members.begin(), host.members.end(),
                                 [&](const LayoutMember& other) { return other.offset == member.offset; });
    const auto same = std::find_if(host.members.begin(), host.members.end(),
                                   [&](const LayoutMember& other) { return other.name == member.name; });
    std::string message;
    if (!member.name.empty() && same != host.members.end() && same->offset != member.offset)
      message = name + " is at " + here + " here, but at byte " + std::to_string(same->offset);
    else if (at == host.members.end())
      message = name + " is at " + here + " here, where nothing begins";
    else if (!member.name.empty() && member.name != at->name)
      message = here + " is called " + name + " here, but " + at->name;
    else if (member.type != at->type || (member.length == 0) != (at->length == 0) || member.length > at->length)
      message = name + " is a " + typeOf(member) + " here, but a " + typeOf(*at);
    else if (member.length != 0 && member.stride != kWordBytes)
      message = name + " has an element every " + std::to_string(member.stride) + " bytes here, but every " +
                std::to_string(kWordBytes);
    if (message.empty()) continue;
    SourceLocation location = findDeclaration(sources, resource.names);
    findMember(sources, module.name(member.structure), member.name, location);
    return add(location, message + kLayoutRemedy);
  }
}

// What SPIRV-Tools has against the module; empty if it is valid.
std::string validateSpirv(const std::vector<uint32_t>& words) {
  spvtools::SpirvTools tools(SPV_ENV_VULKAN_1_2);
  spvtools::ValidatorOptions options;
  options.SetFriendlyNames(false);  // they take a third of its time
  if (tools.Validate(words.data(), words.size(), options)) return {};
  // Once more, for the reason: the first line of the first complaint. What follows is the disassembled instruction.
  std::string complaint;
  tools.SetMessageConsumer([&](spv_message_level_t level, const char*, const spv_position_t&, const char* message) {
    const std::string_view text = message;
    if (level <= SPV_MSG_ERROR && complaint.empty()) complaint = text.substr(0, text.find('\n'));
  });
  tools.Validate(words);
  return complaint.empty() ? "no reason given" : complaint;
}

}  // namespace

void checkKernel(const Spirv& kernel, const std::vector<ShaderSource>& sources, BufferAccess access) {
  const Declarations module = readDeclarations(kernel.words);
  KernelCheck check(module, sources, access);
  check.checkEntryPoint();
  check.checkCapabilities();
  check.checkWorkGroup();
  check.checkConstants();
  check.checkVariables();
  if (const std::string complaint = validateSpirv(kernel.words); !complaint.empty())
    check.faults.push_back(
        faultAt({sources.empty() ? "" : sources[0].path}) +
        "what became of the shader is no valid SPIR-V for Vulkan 1.2, and no driver should see it: " + complaint);
  std::string message;
  for (const std::string& fault : check.faults) message += (message.empty() ? "" : "\n") + fault;
  if (!message.empty()) throw InputError(message);
}

}  // namespace turner
