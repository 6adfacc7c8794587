// Diagnostics are kept by byte offset; lines and columns are counted once, when they are told.
#include "base/diagnostics.h"

#include <algorithm>
#include <cctype>
#include <numeric>
#include <utility>

#include "base/errors.h"

namespace turner {

Diagnostics::Diagnostics(std::string path, std::string_view text) : path_(std::move(path)), text_(text) {}

void Diagnostics::add(size_t offset, std::string message) {
  faults_.push_back({std::min(offset, text_.size()), std::move(message)});
}

std::string Diagnostics::placeOf(size_t offset) const {
  const std::string_view before = text_.substr(0, offset);
  const size_t lineStart = before.rfind('\n') + 1;  // 0 where there is none
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  return path_ + ':' + std::to_string(line) + ':' + std::to_string(offset - lineStart + 1) + ": error: ";
}

void Diagnostics::throwIfAny() const {
  if (faults_.empty()) return;
  std::vector<Fault> sorted = faults_;
  std::stable_sort(sorted.begin(), sorted.end(), [](const Fault& a, const Fault& b) { return a.offset < b.offset; });

  // One walk over the text gives every fault its line and column (both from 1; columns count bytes, as compilers do).
  std::string message;
  size_t line = 1, lineStart = 0, at = 0;
  for (const Fault& fault : sorted) {
    for (; at < fault.offset; ++at) {
      if (text_[at] == '\n') {
        ++line;
        lineStart = at + 1;
      }
    }
    if (!message.empty()) message += '\n';
    message += path_ + ':' + std::to_string(line) + ':' + std::to_string(fault.offset - lineStart + 1) +
               ": error: " + fault.message;
  }
  throw InputError(message);
}

namespace {

// Levenshtein's distance between two words, case ignored.
size_t editDistance(std::string_view a, std::string_view b) {
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t(0));
  for (size_t i = 1; i <= a.size(); ++i) {
    size_t diagonal = row[0];
    row[0] = i;
    for (size_t j = 1; j <= b.size(); ++j) {
      const bool same = std::tolower((unsigned char)a[i - 1]) == std::tolower((unsigned char)b[j - 1]);
      const size_t replaced = diagonal + (same ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row[b.size()];
}

}  // namespace

std::string nearestName(std::string_view misspelt, std::span<const std::string> known) {
  if (misspelt.size() > 64) return {};
  // Enough to be helpful: a file of wrong names must not take time that grows with the square of its size.
  known = known.first(std::min<size_t>(known.size(), 256));
  std::string best;
  // A third of the letters may be wrong, but at least two: "fov" for "vof", "colour" for "color".
  size_t bestDistance = std::max<size_t>(2, misspelt.size() / 3) + 1;
  for (const std::string& name : known) {
    const size_t distance = editDistance(misspelt, name);
    if (distance < bestDistance) {
      bestDistance = distance;
      best = name;
    }
  }
  return best;
}

}  // namespace turner
