// Compares the module's declarations with the host's tables, and has SPIRV-Tools validate the rest.
#include "kernel/kernel_check.h"

#include <glslang/SPIRV/spirv.hpp>
#include <spirv-tools/libspirv.hpp>

#include <algorithm>
#include <string>
#include <string_view>

#include "base/errors.h"
#include "kernel/capabilities.h"
#include "kernel/host_interface.h"
#include "kernel/layout_text.h"
#include "kernel/source_names.h"
#include "kernel/spirv_module.h"
#include "layout.h"

namespace turner {
namespace {

constexpr uint32_t kWithoutSampler = 2;  // "Sampled" of OpTypeImage: a storage image

class KernelCheck {
 public:
  KernelCheck(const SpirvModule& declarations, const std::vector<ShaderSource>& shaderSources, BufferAccess way)
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

  const SpirvModule& module;
  const std::vector<ShaderSource>& sources;
  BufferAccess access;
};

void KernelCheck::checkEntryPoint() {
  if (module.entryPoints.size() != 1 || module.entryPoints[0].model != spv::ExecutionModelGLCompute ||
      module.entryPoints[0].name != "main")
    addOf({"main"}, "the kernel must have one entry point, a compute shader's main()");
}

void KernelCheck::checkCapabilities() {
  for (const uint32_t capability : module.capabilities) {
    if (isOpenCapability(capability, access)) continue;
    const std::string name = capabilityName(capability);
    const bool isOtherAccess = name == "PhysicalStorageBufferAddresses";
    addOf(glslWordsOfCapability(name), "the kernel needs " + name + ", which turner's device is not opened with" +
                                           (isOtherAccess ? " where rows are fetched as " + accessName(access) +
                                                                "; read them by WORD4() of buffer_access.glsl"
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
    return constant.opcode == spv::OpConstant && constant.operand(2) == 1;
  };
  for (const auto& [decorated, builtIn] : module.decorations) {
    if (decorated.second != spv::DecorationBuiltIn || builtIn != spv::BuiltInWorkgroupSize) continue;
    // The type and the id of the composite come before x, y and z.
    const SpirvInstruction size = module.definition(decorated.first);
    const uint32_t x = size.operand(2);
    const uint32_t* const id = module.decoration(x, spv::DecorationSpecId);
    if (module.definition(x).opcode == spv::OpSpecConstant && id && *id == gpu::kSpecWorkGroup &&
        isOne(size.operand(3)) && isOne(size.operand(4)))
      return;
  }
  addOf({"local_size_x_id", "local_size_x", "local_size_y_id", "local_size_y", "local_size_z_id", "local_size_z"},
        "the size of the work-group is not what turner sets: one specialisation constant in x, 1 in y and z; write "
        "layout(local_size_x_id = kSpecWorkGroup, local_size_y = 1, local_size_z = 1) in;");
}

void KernelCheck::checkConstants() {
  for (const auto& [decorated, id] : module.decorations) {
    if (decorated.second != spv::DecorationSpecId || id >= gpu::kSpecCount) continue;
    const auto found = module.names.find(decorated.first);
    const std::vector<std::string> names = found == module.names.end() ? std::vector<std::string>() : found->second;
    const std::string name = names.empty() ? "a specialisation constant" : names[0];
    const SpirvInstruction constant = module.definition(decorated.first);
    const bool isBoolean = constant.opcode == spv::OpSpecConstantTrue || constant.opcode == spv::OpSpecConstantFalse;
    const std::string type = isBoolean ? "bool" : glslType(module, constant.operand(0));
    const HostConstant& host = hostConstants()[id];
    if (host.isBoolean ? !isBoolean : type != "uint" && type != "int")
      addOf(names, name + " is a " + type + " with the constant_id of " + host.constant +
                       ", for which turner gives a " + (host.isBoolean ? "bool" : "uint") +
                       "; declare it so, or take an id from " + std::to_string(gpu::kSpecCount) +
                       " on for a constant of your own");
    for (const HostConstant& other : hostConstants())
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
      case spv::StorageClassInput:
      case spv::StorageClassPrivate:
        break;
      case spv::StorageClassWorkgroup:
        if (declaration.operands.size() > 3)
          addOf(resource.names, resource.name() +
                                    " is shared and has an initial value, for which turner's device is not "
                                    "opened; set it in main()");
        break;
      case spv::StorageClassPushConstant:
        checkBlock(resource, hostTile());
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
  const bool isTexels = storage == spv::StorageClassUniformConstant && kind == spv::OpTypeImage &&
                        image.operand(2) == spv::DimBuffer && image.operand(6) == kWithoutSampler;
  if (kind == spv::OpTypeArray || kind == spv::OpTypeRuntimeArray)
    return addOf(resource.names, name +
                                     " is an array of bindings; turner binds one buffer at each; declare them one by "
                                     "one, or an array inside of the block");
  if (storage == spv::StorageClassUniform)
    return addOf(resource.names, name +
                                     " is a uniform buffer; turner binds none; take a const of your own, or what the "
                                     "frame and the tile hold (layout.h)");
  if (storage != spv::StorageClassStorageBuffer && !isTexels)
    return addOf(resource.names, name + " is " +
                                     (kind == spv::OpTypeImage          ? "an image"
                                      : kind == spv::OpTypeSampler      ? "a sampler"
                                      : kind == spv::OpTypeSampledImage ? "a texture"
                                                                        : "a resource of a kind") +
                                     " that turner does not bind; all it binds are buffers (layout.h)");

  const uint32_t* const set = module.decoration(variable, spv::DecorationDescriptorSet);
  if (set && *set != 0)
    return addOf(resource.names, name + " is in descriptor set " + std::to_string(*set) +
                                     "; turner binds set 0 only; leave the set away");
  const uint32_t* const location = module.decoration(variable, spv::DecorationBinding);
  if (!location)
    return addOf(resource.names, name + " has no binding; write layout(binding = ...) with one of layout.h");
  const uint32_t count = bindingCount(access);
  if (*location >= count)
    return addOf(resource.names, name + " has binding " + std::to_string(*location) + "; turner binds 0 to " +
                                     std::to_string(count - 1) + " where rows are fetched as " + accessName(access) +
                                     (*location < gpu::kBindCount ? "; read rows by WORD4() of buffer_access.glsl"
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
                                     (wantsTexels ? "texel buffer; declare it by WORDS() of buffer_access.glsl"
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
  if (image.operand(7) == spv::ImageFormatRgba32ui && glslType(module, image.operand(1)) == "uint") return;
  addOf(resource.names, resource.name() + " has texels of another format; turner binds " + host.what +
                            " as rgba32ui; write layout(binding = " + host.constant + ", rgba32ui) and uimageBuffer");
}

void KernelCheck::checkWords(const Resource& resource, const HostBinding& host) {
  const std::vector<BlockMember> members = blockMembers(module, resource.type);
  if (members.size() == 1 && members[0].offset == 0 && members[0].type == "uvec4" &&
      members[0].length == kRuntimeLength && members[0].stride == kWordBytes)
    return;
  std::string found = "nothing";
  if (!members.empty()) found = glslType(members[0]) + (members.size() > 1 ? " and more" : "");
  if (members.size() == 1 && members[0].type == "uvec4")
    found += " at byte " + std::to_string(members[0].offset) + ", one element every " +
             std::to_string(members[0].stride) + " bytes";
  addOf(resource.names, resource.name() + " holds " + found + "; at binding " + std::to_string(host.binding) +
                            " turner binds " + host.what + ", which are rows without end; declare it as { Word4 " +
                            host.variable + "[]; } in std430, and turn words into floats by uintBitsToFloat()");
}

void KernelCheck::checkBlock(const Resource& resource, const HostBlock& host) {
  const std::vector<BlockMember> members = blockMembers(module, resource.type);
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
      message = name + " is a " + glslType(member) + " here, but a " + glslType(*at);
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
  const SpirvModule module = readSpirvModule(kernel.words);
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
