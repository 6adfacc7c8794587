// The lines of an NFF file: where entities begin, and the numbers of a line. Faults are collected with their place.
#pragma once

#include <array>
#include <cstddef>
#include <glm/vec3.hpp>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>

#include "base/diagnostics.h"
#include "scene/counted_notes.h"
#include "scene/text_scanner.h"

namespace turner::nff {

// A file that is not NFF at all would be wrong in every line; nobody reads further than this.
inline constexpr size_t kMostFaults = 100;

// Whether a word begins an entity: b, c, f, l, p, pp, s or v.
bool isEntity(std::string_view word);

// The numbers of one line, each with its place.
struct Numbers {
  static constexpr size_t kMost = 9;
  std::array<double, kMost> values{};
  std::array<size_t, kMost> offsets{};
  size_t count = 0;

  double operator[](size_t i) const { return values[i]; }
  glm::dvec3 vector(size_t first) const { return {values[first], values[first + 1], values[first + 2]}; }
};

// What a fault inside an entity throws, to leave it at once.
struct Broken {};

class Lines : public TextScanner {
 public:
  Lines(const std::string& path, std::string_view text) : TextScanner(text), faults(path, text), notes(path, text) {}

  // Adds a fault and throws Broken.
  [[noreturn]] void fail(size_t offset, std::string message);

  // Goes on at the current line, if it begins an entity, or at the next one that does. False at the end of the file.
  bool skipToEntity();

  // Reads all numbers that the line still holds; their count must be one of the allowed. `form` shows them in the
  // message, as "s x y z radius".
  Numbers readNumbers(std::initializer_list<size_t> allowed, std::string_view form);

  // The same for `most` numbers of which those behind the first `needed` may be missing or wrong: they are NaN then.
  Numbers readNumbers(size_t needed, size_t most, std::string_view form);

  glm::dvec3 readColor(const Numbers& numbers, size_t first);

  // Counts an entity or a line of a view that is unknown.
  void noteUnknown(const Token& word);

  Diagnostics faults;
  CountedNotes notes;
  std::optional<Token> firstUnknown;
  bool atLineStart = false;  // whether the current line is still to be looked at
};

}  // namespace turner::nff
