// What was changed in the sources of a shader, line by line, of the lines that hold code.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "kernel/glsl_tokens.h"
#include "kernel/shader_sources.h"

namespace turner {

// What is left of a line without its blanks and comments.
struct CodeLine {
  std::string code;
  int line, column;  // of its first token
};

// Code lines [first, end) took the place of some others. Where lines were only taken out it is empty, before `first`.
struct LineChange {
  size_t first, end;
};

// What was changed in one file. Its tokens refer to the text of the source, which must outlive them.
struct EditedFile {
  std::string path;
  std::vector<GlslToken> tokens;
  std::vector<CodeLine> lines;
  std::vector<LineChange> changes;

  // Is there a change in the lines of the tokens [begin, end)?
  bool isChanged(size_t begin, size_t end) const;
  // Were lines taken out before the one of this token?
  bool isCutBefore(size_t token) const;

 private:
  size_t lineOf(size_t token) const;
};

// Files are the same by their names. Those without a change are left out.
std::vector<EditedFile> editedFiles(const std::vector<ShaderSource>& good, const std::vector<ShaderSource>& edited);

}  // namespace turner
