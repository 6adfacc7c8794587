// Where the loops of a GLSL text begin and end, as its tokens show them. Macros are not expanded: a loop that one
// writes is not seen.
#pragma once

#include "kernel/glsl_tokens.h"

namespace turner::watch {

// Numbers of tokens; the ends are those of the tokens behind. Behind the body of a do stands its while.
struct GlslLoop {
  size_t begin;    // of the statement: the keyword, or the attributes before it
  size_t keyword;  // for, while or do
  size_t bodyBegin, bodyEnd;
  size_t end;
};

// A function's body, with its braces.
struct GlslBody {
  size_t begin, end;
};

// The loops in the order of their keywords. Left out is what cannot be followed, such as a loop that begins in one
// branch of the preprocessor and ends behind it.
std::vector<GlslLoop> findLoops(const std::vector<GlslToken>& tokens);

// The bodies of main(): one, or one in each of several branches of the preprocessor.
std::vector<GlslBody> findMains(const std::vector<GlslToken>& tokens);

}  // namespace turner::watch
