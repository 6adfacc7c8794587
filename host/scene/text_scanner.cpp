// Walks the bytes once; tokens are views into the text.
#include "scene/text_scanner.h"

#include <array>
#include <cmath>

#include "scene/number.h"

namespace turner {

namespace {

enum class ByteKind : unsigned char { other, blank, newline, backslash };

// A table look-up for each byte is what keeps the scanner fast.
constexpr std::array<ByteKind, 256> kByteKinds = [] {
  std::array<ByteKind, 256> kinds{};
  // A carriage return is a blank: files with CRLF and with LF read alike.
  for (const char blank : {' ', '\t', '\r', '\v', '\f'}) kinds[(unsigned char)blank] = ByteKind::blank;
  kinds['\n'] = ByteKind::newline;
  kinds['\\'] = ByteKind::backslash;
  return kinds;
}();

ByteKind kindOf(char byte) {
  return kByteKinds[(unsigned char)byte];
}

}  // namespace

TextScanner::TextScanner(std::string_view text, Continuation continuation)
    : text_(text), joinsLines_(continuation == Continuation::backslash) {
  // A byte order mark is no part of the first word.
  if (text_.starts_with("\xEF\xBB\xBF")) at_ = 3;
}

size_t TextScanner::continuationAt(size_t at) const {
  if (!joinsLines_) return 0;
  size_t end = at + 1;
  while (end < text_.size() && kindOf(text_[end]) == ByteKind::blank) ++end;
  return end < text_.size() && text_[end] == '\n' ? end + 1 - at : 0;
}

size_t TextScanner::skipBlanks(size_t at) const {
  while (at < text_.size()) {
    const ByteKind kind = kindOf(text_[at]);
    const size_t step = kind == ByteKind::blank ? 1 : kind == ByteKind::backslash ? continuationAt(at) : 0;
    if (step == 0) break;
    at += step;
  }
  return at;
}

Token TextScanner::peek() const {
  const size_t start = skipBlanks(at_);
  if (start == text_.size() || text_[start] == '#') return {{}, start};
  size_t end = start;
  for (; end < text_.size(); ++end) {
    const ByteKind kind = kindOf(text_[end]);
    if (kind != ByteKind::other && (kind != ByteKind::backslash || continuationAt(end))) break;
  }
  return {text_.substr(start, end - start), start};
}

Token TextScanner::next() {
  const Token token = peek();
  at_ = token.offset + token.text.size();
  return token;
}

bool TextScanner::nextLine() {
  for (;; begun_ = true) {
    if (begun_) {
      // Pass what the line still holds: tokens one by one, since a continuation may join further lines to it.
      while (!next().text.empty()) {
      }
      const size_t lineEnd = text_.find('\n', at_);
      if (lineEnd == std::string_view::npos) {
        at_ = text_.size();
        return false;
      }
      at_ = lineEnd + 1;
    }
    if (!peek().text.empty()) {
      begun_ = true;
      return true;
    }
  }
}

std::string readSceneNumber(std::string_view token, double& value) {
  switch (parseNumber(token, value)) {
    case NumberFault::notANumber:
      return quoted(token) + " is not a number";
    case NumberFault::none:
      if (std::abs(value) <= kLargestNumber) return {};
      [[fallthrough]];
    case NumberFault::tooLarge:
      break;
  }
  return quoted(token) + " is too large; allowed are numbers from -1e30 to 1e30";
}

std::string quoted(std::string_view token) {
  constexpr size_t kLongest = 40;
  std::string text = "'";
  for (const char c : token.substr(0, kLongest)) text += c >= ' ' && c <= '~' ? c : '?';
  return text + (token.size() > kLongest ? "...'" : "'");
}

}  // namespace turner
