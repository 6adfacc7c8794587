// An instruction's first word has its length in the upper half, its opcode in the lower.
#include "kernel/spirv_words.h"

namespace turner {

std::string SpirvInstruction::text(size_t i) const {
  std::string text;
  for (; i < operands.size(); ++i) {
    for (uint32_t shift = 0; shift < 32; shift += 8) {
      const char c = char(operands[i] >> shift & 0xff);
      if (c == 0) return text;
      text += c;
    }
  }
  return text;
}

bool nextInstruction(std::span<const uint32_t> words, size_t& at, SpirvInstruction& instruction) {
  if (at >= words.size()) return false;
  const size_t length = words[at] >> 16;
  if (length == 0 || length > words.size() - at) return false;
  instruction.opcode = uint16_t(words[at] & 0xffff);
  instruction.operands = words.subspan(at + 1, length - 1);
  at += length;
  return true;
}

std::map<uint16_t, size_t> countInstructions(const std::vector<uint32_t>& words) {
  std::map<uint16_t, size_t> counts;
  SpirvInstruction instruction;
  for (size_t at = kSpirvHeaderWords; nextInstruction(words, at, instruction);) ++counts[instruction.opcode];
  return counts;
}

InstructionChange compareInstructions(const std::vector<uint32_t>& before, const std::vector<uint32_t>& after) {
  std::map<uint16_t, size_t> left = countInstructions(before);
  InstructionChange change;
  for (const auto& [opcode, count] : countInstructions(after)) {
    size_t& had = left[opcode];
    change.total += count;
    change.added += count > had ? count - had : 0;
    had -= count < had ? count : had;
  }
  for (const auto& [opcode, count] : left) change.removed += count;
  return change;
}

}  // namespace turner
