// One pass over the instructions that declare; types and members follow from the definitions.
#include "kernel/spirv_module.h"

#include <glslang/SPIRV/spirv.hpp>

namespace turner {
namespace {

constexpr int kDeepest = 8;  // no honest type nests deeper

std::string glslTypeWithin(const SpirvModule& module, uint32_t id, int depth) {
  const SpirvInstruction type = module.definition(id);
  const auto inner = [&](size_t operand) {
    return depth < kDeepest ? glslTypeWithin(module, type.operand(operand), depth + 1) : std::string("...");
  };
  switch (type.opcode) {
    case spv::OpTypeBool:
      return "bool";
    case spv::OpTypeInt: {
      const std::string sign = type.operand(2) ? "" : "u";
      return type.operand(1) == 32 ? sign + "int" : sign + "int" + std::to_string(type.operand(1)) + "_t";
    }
    case spv::OpTypeFloat:
      return type.operand(1) == 32   ? "float"
             : type.operand(1) == 64 ? "double"
                                     : "float" + std::to_string(type.operand(1)) + "_t";
    case spv::OpTypeVector: {
      const std::string component = inner(1), count = std::to_string(type.operand(2));
      if (component == "float") return "vec" + count;
      for (const char* known : {"uint", "int", "bool", "double"})
        if (component == known) return std::string(1, component[0]) + "vec" + count;
      return component + "[" + count + "]";
    }
    case spv::OpTypeMatrix:
      return "mat" + std::to_string(type.operand(2)) + " of " + inner(1);
    case spv::OpTypeArray:
    case spv::OpTypeRuntimeArray:
      return "array of " + inner(1);
    case spv::OpTypeStruct:
      return "struct " + module.name(id);
    case spv::OpTypePointer:
      return "reference to a buffer";
    default:
      return "type of another kind";
  }
}

void addMembers(const SpirvModule& module, uint32_t structure, uint32_t base, int depth,
                std::vector<BlockMember>& members) {
  const SpirvInstruction type = module.definition(structure);
  for (uint32_t i = 0; i + 1 < type.operands.size(); ++i) {
    const uint32_t memberType = type.operand(i + 1), offset = base + module.memberOffset(structure, i);
    const SpirvInstruction member = module.definition(memberType);
    if (member.opcode == spv::OpTypeStruct && depth < kDeepest) {
      addMembers(module, memberType, offset, depth + 1, members);
      continue;
    }
    BlockMember found{structure, module.memberName(structure, i), offset, glslType(module, memberType)};
    if (member.opcode == spv::OpTypeArray || member.opcode == spv::OpTypeRuntimeArray) {
      found.type = glslType(module, member.operand(1));
      const uint32_t* stride = module.decoration(memberType, spv::DecorationArrayStride);
      found.stride = stride ? *stride : 0;
      // A length that is a specialisation constant is no number yet; it fits nothing.
      const SpirvInstruction length = module.definition(member.operand(2));
      found.length = member.opcode == spv::OpTypeRuntimeArray || length.opcode != spv::OpConstant ? kRuntimeLength
                                                                                                  : length.operand(2);
    }
    members.push_back(std::move(found));
  }
}

}  // namespace

SpirvInstruction SpirvModule::definition(uint32_t id) const {
  const auto found = definitions.find(id);
  return found == definitions.end() ? SpirvInstruction() : found->second;
}

const uint32_t* SpirvModule::decoration(uint32_t id, uint32_t decoration) const {
  const auto found = decorations.find({id, decoration});
  return found == decorations.end() ? nullptr : &found->second;
}

std::string SpirvModule::name(uint32_t id) const {
  const auto found = names.find(id);
  return found == names.end() ? "" : found->second[0];
}

std::string SpirvModule::memberName(uint32_t structure, uint32_t member) const {
  const auto found = memberNames.find({structure, member});
  return found == memberNames.end() ? "" : found->second;
}

uint32_t SpirvModule::memberOffset(uint32_t structure, uint32_t member) const {
  const auto found = memberDecorations.find({structure, member, spv::DecorationOffset});
  return found == memberDecorations.end() ? 0 : found->second;
}

SpirvModule readSpirvModule(std::span<const uint32_t> words) {
  SpirvModule module;
  SpirvInstruction instruction;
  for (size_t at = kSpirvHeaderWords; nextInstruction(words, at, instruction);) {
    const uint16_t op = instruction.opcode;
    const auto operand = [&](size_t i) { return instruction.operand(i); };
    if (op == spv::OpFunction) break;
    if (op == spv::OpCapability) module.capabilities.push_back(operand(0));
    if (op == spv::OpExtension) module.extensions.push_back(instruction.text(0));
    if (op == spv::OpEntryPoint) module.entryPoints.push_back({operand(0), instruction.text(2)});
    if (op == spv::OpName) {
      if (std::string name = instruction.text(1); !name.empty()) module.names[operand(0)].push_back(std::move(name));
    }
    if (op == spv::OpMemberName) module.memberNames[{operand(0), operand(1)}] = instruction.text(2);
    if (op == spv::OpDecorate) module.decorations[{operand(0), operand(1)}] = operand(2);
    if (op == spv::OpMemberDecorate) module.memberDecorations[{operand(0), operand(1), operand(2)}] = operand(3);
    if (op >= spv::OpTypeVoid && op <= spv::OpTypeFunction) module.definitions[operand(0)] = instruction;
    if (op >= spv::OpConstantTrue && op <= spv::OpSpecConstantOp) module.definitions[operand(1)] = instruction;
    if (op == spv::OpVariable) {
      module.definitions[operand(1)] = instruction;
      module.variables.push_back(operand(1));
    }
  }
  return module;
}

std::string glslType(const SpirvModule& module, uint32_t type) {
  return glslTypeWithin(module, type, 0);
}

std::string glslType(const BlockMember& member) {
  if (member.length == 0) return member.type;
  return member.type + '[' + (member.length == kRuntimeLength ? "" : std::to_string(member.length)) + ']';
}

std::vector<BlockMember> blockMembers(const SpirvModule& module, uint32_t structure) {
  std::vector<BlockMember> members;
  addMembers(module, structure, 0, 0, members);
  return members;
}

}  // namespace turner
