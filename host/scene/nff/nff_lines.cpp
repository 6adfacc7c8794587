// Numbers that are written plainly are read at once; all others go through the checks that name their fault.
#include "scene/nff/nff_lines.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "base/errors.h"
#include "base/number.h"

namespace turner::nff {
namespace {

constexpr std::array<std::string_view, 8> kEntities{"b", "c", "f", "l", "p", "pp", "s", "v"};
constexpr NoteKind kUnknown{"unknown entity was passed over", "unknown entities were passed over"};

std::string tooMuch(const Token& token, std::string_view form) {
  return "more on the line than expected: " + quoted(token.text) + "; allowed is " + std::string(form) +
         ", one entity a line";
}

std::string tooShort(size_t count, std::string_view form) {
  return "found " + std::to_string(count) + (count == 1 ? " number" : " numbers") +
         ", the line is too short; allowed is " + std::string(form);
}

}  // namespace

bool isEntity(std::string_view word) {
  // Almost every line of a large file begins with a number.
  return word.size() <= 2 && std::find(kEntities.begin(), kEntities.end(), word) != kEntities.end();
}

void Lines::fail(size_t offset, std::string message) {
  faults.add(offset, std::move(message));
  throw Broken();
}

bool Lines::skipToEntity() {
  if (atLineStart && isEntity(peek().text)) return true;
  atLineStart = true;
  while (nextLine()) {
    if (isEntity(peek().text)) return true;
  }
  return false;
}

Numbers Lines::readNumbers(std::initializer_list<size_t> allowed, std::string_view form) {
  Numbers numbers;
  const size_t most = std::max(allowed);
  while (numbers.count < most && nextPlainNumber(numbers.values[numbers.count], numbers.offsets[numbers.count])) {
    ++numbers.count;
  }
  for (Token token = next(); !token.text.empty(); token = next()) {
    if (numbers.count == most) fail(token.offset, tooMuch(token, form));
    std::string wrong = readSceneNumber(token.text, numbers.values[numbers.count]);
    if (!wrong.empty()) fail(token.offset, std::move(wrong));
    numbers.offsets[numbers.count++] = token.offset;
  }
  if (std::find(allowed.begin(), allowed.end(), numbers.count) == allowed.end()) {
    fail(peek().offset, tooShort(numbers.count, form));
  }
  return numbers;
}

Numbers Lines::readNumbers(size_t needed, size_t most, std::string_view form) {
  Numbers numbers;
  size_t& count = numbers.count;
  while (count < most && nextPlainNumber(numbers.values[count], numbers.offsets[count])) ++count;
  for (Token token = next(); !token.text.empty(); token = next()) {
    if (count == most) fail(token.offset, tooMuch(token, form));
    std::string wrong = readSceneNumber(token.text, numbers.values[count]);
    if (!wrong.empty()) {
      if (count < needed) fail(token.offset, std::move(wrong));
      numbers.values[count] = std::numeric_limits<double>::quiet_NaN();
    }
    numbers.offsets[count++] = token.offset;
  }
  const size_t end = peek().offset;
  if (count < needed) fail(end, tooShort(count, form));
  for (; count < most; ++count) {
    numbers.values[count] = std::numeric_limits<double>::quiet_NaN();
    numbers.offsets[count] = end;
  }
  return numbers;
}

void Lines::noteUnknown(const Token& word) {
  if (!firstUnknown) firstUnknown = word;
  notes.add(kUnknown, word.offset, quoted(word.text));
}

glm::dvec3 Lines::readColor(const Numbers& numbers, size_t first) {
  for (size_t i = first; i < first + 3; ++i) {
    if (numbers[i] < 0) fail(numbers.offsets[i], "a colour must not be negative; allowed are values from 0");
  }
  return numbers.vector(first);
}

}  // namespace turner::nff
