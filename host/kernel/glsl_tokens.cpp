// One pass over the text, a character at a time.
#include "kernel/glsl_tokens.h"

#include <algorithm>
#include <array>

namespace turner {
namespace {

// The longer ones first: GLSL cuts by longest match.
constexpr std::array<std::string_view, 22> kLongOperators = {
    "<<=", ">>=", "<<", ">>", "++", "--", "<=", ">=", "==", "!=", "&&",
    "||",  "^^",  "+=", "-=", "*=", "/=", "%=", "&=", "^=", "|=", "##"};

// As in the "C" locale, whatever the program's is.
bool isDigit(char c) {
  return c >= '0' && c <= '9';
}
bool isOfWord(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || isDigit(c);
}
bool isNewline(char c) {
  return c == '\n' || c == '\r';
}
bool isBlank(char c) {
  return c == ' ' || c == '\t' || c == '\v' || c == '\f';
}

struct Scanner {
  std::string_view text;
  size_t at = 0, lineStart = 0;
  int line = 1;
  bool lineHasToken = false;

  bool atEnd() const { return at >= text.size(); }
  bool sees(std::string_view what) const { return text.substr(at).starts_with(what); }

  // Over one character, or over the two of a line's end.
  void skipOne() {
    const bool newline = isNewline(text[at]);
    at += sees("\r\n") ? 2 : 1;
    if (!newline) return;
    ++line;
    lineStart = at;
    lineHasToken = false;
  }

  // A backslash at a line's end, which joins it to the next.
  bool skipJoint() {
    if (!sees("\\\n") && !sees("\\\r")) return false;
    const bool before = lineHasToken;
    ++at;
    skipOne();
    lineHasToken = before;
    return true;
  }

  bool skipComment() {
    if (sees("//")) {
      while (!atEnd() && !isNewline(text[at]))
        if (!skipJoint()) ++at;
      return true;
    }
    if (!sees("/*")) return false;
    const bool before = lineHasToken;
    at += 2;
    while (!atEnd() && !sees("*/")) skipOne();
    at = std::min(at + 2, text.size());
    lineHasToken = before;  // a comment counts as one blank
    return true;
  }

  // A string that is not closed ends with its line.
  void skipString() {
    ++at;
    while (!atEnd() && !isNewline(text[at]) && text[at] != '"') {
      const bool escapes = text[at] == '\\';
      ++at;
      if (escapes && !atEnd() && !isNewline(text[at])) ++at;
    }
    if (sees("\"")) ++at;
  }

  void skipDirective() {
    while (!atEnd() && !isNewline(text[at])) {
      if (skipJoint() || skipComment()) continue;
      if (text[at] == '"')
        skipString();
      else
        ++at;
    }
  }

  // A sign belongs to a number behind the e of its exponent.
  void skipNumber() {
    const bool hexadecimal = sees("0x") || sees("0X");
    while (!atEnd() && (isOfWord(text[at]) || text[at] == '.' ||
                        ((text[at] == '+' || text[at] == '-') && !hexadecimal && (text[at - 1] | 32) == 'e')))
      ++at;
  }

  void skipOperator() {
    const auto longer = std::find_if(kLongOperators.begin(), kLongOperators.end(),
                                     [&](std::string_view one) { return text.substr(at).starts_with(one); });
    at += longer == kLongOperators.end() ? 1 : longer->size();
  }

  GlslKind skipToken() {
    const char c = text[at];
    const bool pointed = c == '.' && at + 1 < text.size() && isDigit(text[at + 1]);
    if (c == '#' && !lineHasToken) {
      skipDirective();
      return GlslKind::directive;
    }
    if (isDigit(c) || pointed) {
      skipNumber();
      return GlslKind::number;
    }
    if (c == '"') {
      skipString();
      return GlslKind::string;
    }
    if (!isOfWord(c)) {
      skipOperator();
      return GlslKind::mark;
    }
    while (!atEnd() && isOfWord(text[at])) ++at;
    return GlslKind::word;
  }
};

}  // namespace

std::vector<GlslToken> readGlslTokens(std::string_view text) {
  std::vector<GlslToken> tokens;
  Scanner scanner{text};
  while (!scanner.atEnd()) {
    const char c = text[scanner.at];
    if (isBlank(c) || isNewline(c)) {
      scanner.skipOne();
      continue;
    }
    if (scanner.skipJoint() || scanner.skipComment()) continue;
    GlslToken token{GlslKind::mark, {}, scanner.at, scanner.line, int(scanner.at - scanner.lineStart) + 1};
    token.kind = scanner.skipToken();
    token.text = text.substr(token.offset, scanner.at - token.offset);
    scanner.lineHasToken = true;
    tokens.push_back(token);
  }
  return tokens;
}

std::string_view directiveName(const GlslToken& token) {
  if (token.kind != GlslKind::directive) return {};
  std::string_view text = token.text.substr(1);
  text.remove_prefix(std::min(text.find_first_not_of(" \t"), text.size()));
  return text.substr(0, text.find_first_not_of("abcdefghijklmnopqrstuvwxyz"));
}

}  // namespace turner
