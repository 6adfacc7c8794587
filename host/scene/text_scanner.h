// Cuts a text into lines and blank-separated tokens, each with its byte offset, so that a parser can name the place of
// a fault. Copies and allocates nothing; '#' at the start of a token makes the rest of its line a comment. What is done
// for every byte is inline: of all that reads a large file, this takes the most time.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <string_view>

#include "base/number.h"

namespace turner {

// The largest magnitude of a number in a scene or mesh: well inside float32, so that no later difference overflows.
inline constexpr double kLargestNumber = 1e30;

struct Token {
  std::string_view text;  // empty where the line has no more tokens
  size_t offset = 0;      // of its first byte; where the line ends if there is no token
};

class TextScanner {
 public:
  enum class Continuation { none, backslash };  // backslash: at the end of a line it joins the next one to it

  // `text` must outlive this object and the tokens.
  explicit TextScanner(std::string_view text, Continuation continuation = Continuation::none);

  // Goes to the next line that holds a token, whatever is left of the current one. False at the end of the text.
  bool nextLine();
  // The next token of the line.
  Token next();
  // The same, without passing it.
  Token peek() const;
  // Passes what the line still holds, up to its end in the text: nothing is joined to it. Whether a backslash stands at
  // its end.
  bool passRest();
  // Whether the line has no more tokens.
  bool atLineEnd() const { return !isTokenAt(skipBlanks(at_)); }
  // Reads the next token, and where it begins, if it is a number that readSceneNumber takes. False, with nothing
  // passed, if it is anything else, or a number of a kind that readPlainDecimal leaves to others: next() and
  // readSceneNumber then tell.
  bool nextPlainNumber(double& value, size_t& offset);
  // Bytes from here to the end of the text: bounds what may still follow.
  size_t remaining() const { return text_.size() - at_; }

 private:
  enum class ByteKind : unsigned char { other, blank, newline, backslash };
  // A table look-up for each byte is what keeps the scanner fast.
  static constexpr std::array<ByteKind, 256> kByteKinds = [] {
    std::array<ByteKind, 256> kinds{};
    // A carriage return is a blank: files with CRLF and with LF read alike.
    for (const char blank : {' ', '\t', '\r', '\v', '\f'}) kinds[(unsigned char)blank] = ByteKind::blank;
    kinds['\n'] = ByteKind::newline;
    kinds['\\'] = ByteKind::backslash;
    return kinds;
  }();
  static ByteKind kindOf(char byte) { return kByteKinds[(unsigned char)byte]; }

  // The length of the line continuation that the backslash at `at` begins, 0 if it is a plain byte.
  size_t continuationAt(size_t at) const;
  size_t skipBlanks(size_t at) const;
  // Whether a token begins at `at`, a place behind blanks.
  bool isTokenAt(size_t at) const { return at < text_.size() && text_[at] != '\n' && text_[at] != '#'; }

  std::string_view text_;
  size_t at_ = 0;
  bool begun_ = false;
  bool joinsLines_;
};

inline size_t TextScanner::skipBlanks(size_t at) const {
  for (; at < text_.size(); ++at) {
    const ByteKind kind = kindOf(text_[at]);
    if (kind == ByteKind::blank) continue;
    if (kind != ByteKind::backslash) break;
    const size_t length = continuationAt(at);
    if (length == 0) break;
    at += length - 1;
  }
  return at;
}

inline Token TextScanner::peek() const {
  const size_t start = skipBlanks(at_);
  if (!isTokenAt(start)) return {{}, start};
  size_t end = start;
  for (; end < text_.size(); ++end) {
    const ByteKind kind = kindOf(text_[end]);
    if (kind != ByteKind::other && (kind != ByteKind::backslash || continuationAt(end))) break;
  }
  return {text_.substr(start, end - start), start};
}

inline Token TextScanner::next() {
  const Token token = peek();
  at_ = token.offset + token.text.size();
  return token;
}

inline bool TextScanner::nextPlainNumber(double& value, size_t& offset) {
  const size_t start = skipBlanks(at_);
  const size_t length = readPlainDecimal(text_.substr(start), value);
  const size_t end = start + length;
  if (length == 0 || !(std::abs(value) <= kLargestNumber)) return false;
  if (end < text_.size() && kindOf(text_[end]) != ByteKind::blank && kindOf(text_[end]) != ByteKind::newline) {
    return false;
  }
  offset = start;
  at_ = end;
  return true;
}

// Reads a token as a number of a scene. Returns what is wrong with it and what is allowed; empty if all is well.
std::string readSceneNumber(std::string_view token, double& value);

// A token in quotes for a message: shortened where long, unprintable bytes replaced.
std::string quoted(std::string_view token);

}  // namespace turner
