// The declarations of a SPIR-V module: everything before its first function. Types are named as GLSL spells them. Knows
// nothing of the host's interface.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "kernel/spirv_words.h"

namespace turner {

struct EntryPoint {
  uint32_t model;  // spv::ExecutionModel
  std::string name;
};

// Definitions refer to the words that they were read from, which must outlive them.
struct SpirvModule {
  std::vector<uint32_t> capabilities;
  std::vector<std::string> extensions;
  std::vector<EntryPoint> entryPoints;
  std::map<uint32_t, std::vector<std::string>> names;  // an id may have several: the optimiser unites constants
  std::map<std::pair<uint32_t, uint32_t>, std::string> memberNames;                // (struct, member)
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> decorations;                   // (id, decoration)
  std::map<std::tuple<uint32_t, uint32_t, uint32_t>, uint32_t> memberDecorations;  // (struct, member, decoration)
  std::map<uint32_t, SpirvInstruction> definitions;                                // types, constants, variables
  std::vector<uint32_t> variables;

  // An instruction of opcode 0 where there is none.
  SpirvInstruction definition(uint32_t id) const;
  // The first operand of a decoration; null where there is none.
  const uint32_t* decoration(uint32_t id, uint32_t decoration) const;
  // Names are empty where they have been stripped; an offset is 0 where none is given.
  std::string name(uint32_t id) const;
  std::string memberName(uint32_t structure, uint32_t member) const;
  uint32_t memberOffset(uint32_t structure, uint32_t member) const;
};

// Reads as far as the words make sense.
SpirvModule readSpirvModule(std::span<const uint32_t> words);

// A type as GLSL spells it: "uvec4", "array of float", "struct Ray".
std::string glslType(const SpirvModule& module, uint32_t type);

inline constexpr uint32_t kRuntimeLength = 0xffffffff;  // of an array that ends with its buffer

// A member of a block; members of nested structures stand for themselves.
struct BlockMember {
  uint32_t structure;   // that declares it
  std::string name;     // empty where the names have been stripped
  uint32_t offset;      // bytes from the start of the block
  std::string type;     // of an array its elements'
  uint32_t length = 0;  // of an array, kRuntimeLength if the buffer decides; else 0
  uint32_t stride = 0;  // of an array, in bytes
};

// "uint", "uvec4[6]" or "uvec4[]".
std::string glslType(const BlockMember& member);

// The members of a block of this type, in the order of their declaration.
std::vector<BlockMember> blockMembers(const SpirvModule& module, uint32_t structure);

}  // namespace turner
