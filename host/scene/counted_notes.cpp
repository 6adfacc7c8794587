// There are few kinds: they are searched one by one.
#include "scene/counted_notes.h"

#include <algorithm>

namespace turner {

void CountedNotes::add(const NoteKind& kind, size_t offset, std::string_view detail) {
  const auto known =
      std::find_if(counted_.begin(), counted_.end(), [&](const Counted& counted) { return counted.kind == &kind; });
  if (known != counted_.end())
    ++known->count;
  else
    counted_.push_back({&kind, offset, 1, std::string(detail)});
}

std::vector<std::string> CountedNotes::lines() const {
  std::vector<Counted> sorted = counted_;
  std::stable_sort(sorted.begin(), sorted.end(), [](const Counted& a, const Counted& b) { return a.first < b.first; });
  std::vector<std::string> lines;
  for (const auto& [kind, first, count, detail] : sorted) {
    const std::string_view before = text_.substr(0, first);
    const size_t line = 1 + size_t(std::count(before.begin(), before.end(), '\n'));
    const size_t column = first - (before.rfind('\n') + 1) + 1;  // npos + 1 is 0
    lines.push_back(path_ + ':' + std::to_string(line) + ':' + std::to_string(column) +
                    ": note: " + std::to_string(count) + ' ' + std::string(count == 1 ? kind->one : kind->many) +
                    (detail.empty() ? "" : ": " + detail) + (count == 1 ? "" : "; the first is here"));
  }
  return lines;
}

}  // namespace turner
