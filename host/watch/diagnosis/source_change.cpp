// A comparison line by line, of the lines that hold code.
#include "watch/diagnosis/source_change.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <string_view>
#include <utility>

#include "kernel/glsl_tokens.h"
#include "watch/diagnosis/glsl_loops.h"

namespace turner::watch {
namespace {

// What is left of a line without its blanks and comments.
struct CodeLine {
  std::string code;
  int line, column;  // of its first token
};

std::vector<CodeLine> codeLines(const std::vector<GlslToken>& tokens) {
  std::vector<CodeLine> lines;
  for (const GlslToken& token : tokens) {
    if (lines.empty() || lines.back().line != token.line) lines.push_back({"", token.line, token.column});
    lines.back().code.append(token.text).append(" ");
  }
  return lines;
}

// Code lines [first, end) took the place of some others. Where lines were only taken out it is empty, before `first`.
struct Change {
  size_t first, end;
};

// The table below takes 2 bytes for each pair of lines: at most 50 MB. Longer stretches count as changed throughout.
constexpr size_t kMostPairs = 5000 * 5000;

// By the longest common subsequence of what lies between the common head and tail.
std::vector<Change> findChanges(const std::vector<CodeLine>& before, const std::vector<CodeLine>& after) {
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
  std::vector<Change> changes;
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

const ShaderSource* find(const std::vector<ShaderSource>& sources, const std::string& name) {
  const auto found =
      std::find_if(sources.begin(), sources.end(), [&](const ShaderSource& source) { return source.name == name; });
  return found == sources.end() ? nullptr : &*found;
}

// What was changed in one file.
struct EditedFile {
  std::string path;
  std::vector<GlslToken> tokens;
  std::vector<CodeLine> lines;
  std::vector<Change> changes;

  size_t lineOf(size_t token) const {
    const auto found = std::lower_bound(lines.begin(), lines.end(), tokens[token].line,
                                        [](const CodeLine& code, int line) { return code.line < line; });
    return size_t(found - lines.begin());
  }

  // Is there a change in the lines of the tokens [begin, end)?
  bool isChanged(size_t begin, size_t end) const {
    if (begin >= end) return false;
    const size_t first = lineOf(begin), last = lineOf(end - 1);
    return std::any_of(changes.begin(), changes.end(), [&](const Change& change) {
      return change.first < change.end ? change.first <= last && change.end > first
                                       : change.first > first && change.first <= last;
    });
  }
};

// Files without a change are left out.
std::vector<EditedFile> editedFiles(const std::vector<ShaderSource>& good, const std::vector<ShaderSource>& edited) {
  std::vector<EditedFile> files;
  for (const ShaderSource& source : edited) {
    const ShaderSource* before = find(good, source.name);
    if (!source.text || (before && before->text == source.text)) continue;
    EditedFile file{source.path, readGlslTokens(*source.text), {}, {}};
    file.lines = codeLines(file.tokens);
    const std::vector<CodeLine> old =
        before && before->text ? codeLines(readGlslTokens(*before->text)) : std::vector<CodeLine>();
    file.changes = findChanges(old, file.lines);
    if (!file.changes.empty()) files.push_back(std::move(file));
  }
  return files;
}

// The first of the loops that none of the others lies in.
const GlslLoop* firstInnermost(const std::vector<GlslLoop>& loops) {
  for (size_t i = 0; i < loops.size(); ++i)
    if (i + 1 == loops.size() || loops[i + 1].keyword >= loops[i].end) return &loops[i];
  return nullptr;
}

template <class IsWanted>
std::optional<SourceLocation> findLoop(const std::vector<EditedFile>& files, IsWanted isWanted) {
  for (const EditedFile& file : files) {
    std::vector<GlslLoop> wanted;
    for (const GlslLoop& loop : findLoops(file.tokens))
      if (isWanted(file, loop)) wanted.push_back(loop);
    if (const GlslLoop* loop = firstInnermost(wanted))
      return SourceLocation{file.path, file.tokens[loop->keyword].line, file.tokens[loop->keyword].column};
  }
  return std::nullopt;
}

}  // namespace

std::optional<SourceLocation> likelyLocation(const std::vector<ShaderSource>& good,
                                             const std::vector<ShaderSource>& edited) {
  if (good.empty()) return std::nullopt;
  const std::vector<EditedFile> files = editedFiles(good, edited);
  const auto hasNewHead = [](const EditedFile& file, const GlslLoop& loop) {
    return file.isChanged(loop.keyword, loop.bodyBegin) || file.isChanged(loop.bodyEnd, loop.end);
  };
  const auto hasChange = [](const EditedFile& file, const GlslLoop& loop) {
    return file.isChanged(loop.begin, loop.end);
  };
  if (std::optional<SourceLocation> location = findLoop(files, hasNewHead)) return location;
  if (std::optional<SourceLocation> location = findLoop(files, hasChange)) return location;
  for (const EditedFile& file : files) {
    if (file.lines.empty()) continue;  // nothing is left of it
    // Of lines that were taken out, where they stood.
    const CodeLine& line = file.lines[std::min(file.changes[0].first, file.lines.size() - 1)];
    return SourceLocation{file.path, line.line, line.column};
  }
  return std::nullopt;
}

std::vector<std::string> changedFiles(const std::vector<ShaderSource>& good, const std::vector<ShaderSource>& edited) {
  std::vector<std::string> files;
  const auto add = [&](const ShaderSource& source) {
    files.push_back(std::filesystem::path(source.path).filename().string());
  };
  for (const ShaderSource& source : edited) {
    const ShaderSource* before = find(good, source.name);
    if (!before || before->text != source.text) add(source);
  }
  for (const ShaderSource& source : good)
    if (!find(edited, source.name)) add(source);
  return files;
}

}  // namespace turner::watch
