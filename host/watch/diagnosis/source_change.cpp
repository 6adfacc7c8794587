// Loops in which something was changed come before other changes.
#include "watch/diagnosis/source_change.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "kernel/edits/source_edit.h"
#include "watch/diagnosis/glsl_loops.h"

namespace turner::watch {
namespace {

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
    const ShaderSource* before = findSource(good, source.name);
    if (!before || before->text != source.text) add(source);
  }
  for (const ShaderSource& source : good)
    if (!findSource(edited, source.name)) add(source);
  return files;
}

}  // namespace turner::watch
