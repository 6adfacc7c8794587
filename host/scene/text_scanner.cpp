// Walks the bytes once; tokens are views into the text.
#include "scene/text_scanner.h"

#include <algorithm>

namespace turner {

TextScanner::TextScanner(std::string_view text, Continuation continuation)
    : text_(text), joinsLines_(continuation == Continuation::backslash) {}

size_t TextScanner::continuationAt(size_t at) const {
  if (!joinsLines_) return 0;
  size_t end = at + 1;
  while (end < text_.size() && kindOf(text_[end]) == ByteKind::blank) ++end;
  if (end == text_.size()) return end - at;  // it joins nothing
  return text_[end] == '\n' ? end + 1 - at : 0;
}

bool TextScanner::nextLine() {
  for (;; begun_ = true) {
    if (begun_) {
      // Pass what the line still holds: tokens one by one, since a continuation may join further lines to it.
      while (!next().text.empty()) {
      }
      // A comment may still lie before the line's end.
      const size_t lineEnd = at_ < text_.size() && text_[at_] == '\n' ? at_ : text_.find('\n', at_);
      if (lineEnd == std::string_view::npos) {
        at_ = text_.size();
        return false;
      }
      at_ = lineEnd + 1;
    }
    if (!atLineEnd()) {
      begun_ = true;
      return true;
    }
  }
}

bool TextScanner::passRest() {
  const size_t end = std::min(text_.find('\n', at_), text_.size());
  size_t last = end;
  while (last > at_ && kindOf(text_[last - 1]) == ByteKind::blank) --last;
  const bool hasBackslash = last > at_ && text_[last - 1] == '\\';
  at_ = end;
  return hasBackslash;
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
