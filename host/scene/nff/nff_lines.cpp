// Numbers that are written plainly are read at once; all others go through the checks that name their fault.
#include "scene/nff/nff_lines.h"

#include <algorithm>
#include <utility>

#include "base/errors.h"
#include "base/number.h"

namespace turner::nff {
namespace {

constexpr std::array<std::string_view, 8> kEntities{"b", "c", "f", "l", "p", "pp", "s", "v"};

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
    if (numbers.count == most) {
      fail(token.offset, "more on the line than expected: " + quoted(token.text) + "; allowed is " + std::string(form) +
                             ", one entity a line");
    }
    std::string wrong = readSceneNumber(token.text, numbers.values[numbers.count]);
    if (!wrong.empty()) fail(token.offset, std::move(wrong));
    numbers.offsets[numbers.count++] = token.offset;
  }
  if (std::find(allowed.begin(), allowed.end(), numbers.count) == allowed.end()) {
    fail(peek().offset, "found " + std::to_string(numbers.count) + (numbers.count == 1 ? " number" : " numbers") +
                            ", the line is too short; allowed is " + std::string(form));
  }
  return numbers;
}

glm::dvec3 Lines::readColor(const Numbers& numbers, size_t first) {
  for (size_t i = first; i < first + 3; ++i) {
    if (numbers[i] < 0) fail(numbers.offsets[i], "a colour must not be negative; allowed are values from 0");
  }
  return numbers.vector(first);
}

}  // namespace turner::nff
