// The tokens of a GLSL text, each with its location. Knows nothing of what they mean.
#pragma once

#include <string_view>
#include <vector>

namespace turner {

enum class GlslKind {
  word,       // keywords too
  number,     // 1u, 0.5, .5e-3
  mark,       // an operator, a bracket, a comma ...
  string,     // of extensions such as debugPrintfEXT
  directive,  // from its # to its end, lines that a backslash goes on with included
};

struct GlslToken {
  GlslKind kind;
  std::string_view text;  // a part of the text that was read
  size_t offset;          // of it in there
  int line, column;       // count from 1; columns in bytes
};

// Comments and blanks are left out. Takes any text: what GLSL does not know is a mark.
std::vector<GlslToken> readGlslTokens(std::string_view text);

// What the preprocessor is told: "version" of #version 460. Empty for tokens that are no directive.
std::string_view directiveName(const GlslToken& token);

}  // namespace turner
