// A comparison of code lines by their longest common subsequence.
#include "kernel/edits/source_edit.h"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace turner {
namespace {

std::vector<CodeLine> codeLines(const std::vector<GlslToken>& tokens) {
  std::vector<CodeLine> lines;
  for (const GlslToken& token : tokens) {
    if (lines.empty() || lines.back().line != token.line) lines.push_back({"", token.line, token.column});
    lines.back().code.append(token.text).append(" ");
  }
  return lines;
}

// The table below takes 2 bytes for each pair of lines: at most 50 MB. Longer stretches count as changed throughout.
constexpr size_t kMostPairs = 5000 * 5000;

// By the longest common subsequence of what lies between the common head and tail.
std::vector<LineChange> findChanges(const std::vector<CodeLine>& before, const std::vector<CodeLine>& after) {
  const auto same = [&](size_t i, size_t j) { return before[i].code == after[j].code; };
  size_t head = 0;
  while (head < before.size() && head < after.size() && same(head, head)) ++head;
  size_t endBefore = before.size(), endAfter = after.size();
  while (endBefore > head && endAfter > head && same(endBefore - 1, endAfter - 1)) --endBefore, --endAfter;
  const size_t rows = endBefore - head, columns = endAfter - head;
  if (rows == 0 && columns == 0) return {};
  if (rows == 0 || columns == 0 || rows > UINT16_MAX || columns > UINT16_MAX || rows > kMostPairs / columns)
    return {{head, endAfter}};

  // longest(i, j): of the lines from i on and those from j on.
  std::vector<uint16_t> table((rows + 1) * (columns + 1), 0);
  const auto longest = [&](size_t i, size_t j) -> uint16_t& { return table[i * (columns + 1) + j]; };
  for (size_t i = rows; i-- > 0;)
    for (size_t j = columns; j-- > 0;)
      longest(i, j) = same(head + i, head + j) ? uint16_t(longest(i + 1, j + 1) + 1)
                                               : std::max(longest(i + 1, j), longest(i, j + 1));

  // Walk along it; between two lines in common all is one change.
  std::vector<LineChange> changes;
  bool changing = false;
  const auto extend = [&](size_t first, size_t end) {
    if (!changing) changes.push_back({first, end});
    changes.back().end = end;
    changing = true;
  };
  for (size_t i = 0, j = 0; i < rows || j < columns;) {
    if (i < rows && j < columns && same(head + i, head + j)) {
      ++i, ++j;
      changing = false;
    } else if (j < columns && (i == rows || longest(i, j + 1) >= longest(i + 1, j))) {
      extend(head + j, head + j + 1);
      ++j;
    } else {
      extend(head + j, head + j);
      ++i;
    }
  }
  return changes;
}

}  // namespace

size_t EditedFile::lineOf(size_t token) const {
  const auto found = std::lower_bound(lines.begin(), lines.end(), tokens[token].line,
                                      [](const CodeLine& code, int line) { return code.line < line; });
  return size_t(found - lines.begin());
}

bool EditedFile::isCutBefore(size_t token) const {
  if (token >= tokens.size()) return false;
  return std::any_of(changes.begin(), changes.end(), [at = lineOf(token)](const LineChange& change) {
    return change.first == change.end && change.first == at;
  });
}

bool EditedFile::isChanged(size_t begin, size_t end) const {
  if (begin >= end) return false;
  const size_t first = lineOf(begin), last = lineOf(end - 1);
  return std::any_of(changes.begin(), changes.end(), [&](const LineChange& change) {
    return change.first < change.end ? change.first <= last && change.end > first
                                     : change.first > first && change.first <= last;
  });
}

std::vector<EditedFile> editedFiles(const std::vector<ShaderSource>& good, const std::vector<ShaderSource>& edited) {
  std::vector<EditedFile> files;
  for (const ShaderSource& source : edited) {
    const ShaderSource* before = findSource(good, source.name);
    if (!source.text || (before && before->text == source.text)) continue;
    EditedFile file;
    file.path = source.path;
    file.tokens = readGlslTokens(*source.text);
    file.lines = codeLines(file.tokens);
    const std::vector<CodeLine> old =
        before && before->text ? codeLines(readGlslTokens(*before->text)) : std::vector<CodeLine>();
    file.changes = findChanges(old, file.lines);
    if (!file.changes.empty()) files.push_back(std::move(file));
  }
  return files;
}

}  // namespace turner
