// Names come from the disassembler of SPIRV-Tools.
#include "kernel/capabilities.h"

#include <glslang/SPIRV/spirv.hpp>
#include <spirv-tools/libspirv.hpp>

#include <string_view>

namespace turner {

bool isOpenCapability(uint32_t capability, BufferAccess access) {
  switch (capability) {
    case spv::CapabilityMatrix:
    case spv::CapabilityShader:
    case spv::CapabilityInputAttachment:
    case spv::CapabilitySampled1D:
    case spv::CapabilityImage1D:
    case spv::CapabilitySampledBuffer:
    case spv::CapabilityImageBuffer:
    case spv::CapabilityImageQuery:
    case spv::CapabilityDerivativeControl:
    case spv::CapabilityDeviceGroup:
      return true;
    case spv::CapabilityPhysicalStorageBufferAddresses:
      return access == BufferAccess::deviceAddress;
    default:
      return capability >= spv::CapabilityGroupNonUniform && capability <= spv::CapabilityGroupNonUniformQuad;
  }
}

std::string capabilityName(uint32_t capability) {
  const std::vector<uint32_t> words = {spv::MagicNumber, 0x00010500, 0, 1, 0, 2u << 16 | spv::OpCapability, capability};
  std::string text;
  const bool isKnown =
      spvtools::SpirvTools(SPV_ENV_VULKAN_1_2).Disassemble(words, &text, SPV_BINARY_TO_TEXT_OPTION_NO_HEADER);
  const size_t start = text.find("OpCapability ");
  if (!isKnown || start == std::string::npos) return "capability " + std::to_string(capability);
  text.erase(0, start + std::string_view("OpCapability ").size());
  return text.substr(0, text.find_first_of(" \r\n"));
}

std::vector<std::string> glslWordsOfCapability(const std::string& name) {
  if (name == "Float64") return {"double", "dvec2", "dvec3", "dvec4"};
  if (name == "Int64") return {"uint64_t", "int64_t", "u64vec2", "i64vec2"};
  if (name == "Int16" || name == "StorageBuffer16BitAccess") return {"uint16_t", "int16_t", "float16_t"};
  if (name == "Int8" || name == "StorageBuffer8BitAccess") return {"uint8_t", "int8_t"};
  if (name == "Float16") return {"float16_t", "f16vec2", "f16vec3", "f16vec4"};
  if (name == "PhysicalStorageBufferAddresses") return {"buffer_reference"};
  return {};
}

}  // namespace turner
