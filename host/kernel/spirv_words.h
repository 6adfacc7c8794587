// SPIR-V as a sequence of instructions, without their meaning. Never reads beyond the words, whatever they say.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace turner {

inline constexpr size_t kSpirvHeaderWords = 5;

struct SpirvInstruction {
  uint16_t opcode = 0;
  std::span<const uint32_t> operands;  // all words but the first

  // 0 where the instruction has no such operand.
  uint32_t operand(size_t i) const { return i < operands.size() ? operands[i] : 0; }
  // The string that begins at an operand.
  std::string text(size_t i) const;
};

// Takes the instruction at `at` and goes behind it. False at the end, and where the words make no sense from here on.
bool nextInstruction(std::span<const uint32_t> words, size_t& at, SpirvInstruction& instruction);

// How many instructions of each opcode there are.
std::map<uint16_t, size_t> countInstructions(const std::vector<uint32_t>& words);

struct InstructionChange {
  size_t total = 0;               // instructions after the change
  size_t added = 0, removed = 0;  // by opcode: an instruction that only moved, or has other operands, is neither
};

InstructionChange compareInstructions(const std::vector<uint32_t>& before, const std::vector<uint32_t>& after);

}  // namespace turner
