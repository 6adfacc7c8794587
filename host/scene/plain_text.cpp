// A text begins with a character of ASCII, so that its first bytes tell the encoding even without a mark (RFC 4627,
// section 3).
#include "scene/plain_text.h"

#include <algorithm>
#include <cstdint>

#include "base/errors.h"

namespace turner {

namespace {

enum class Encoding { utf8, utf16Little, utf16Big, utf32 };

Encoding encodingOf(std::string_view bytes) {
  using namespace std::string_view_literals;
  if (bytes.starts_with("\xFF\xFE\0\0"sv) || bytes.starts_with("\0\0\xFE\xFF"sv)) return Encoding::utf32;
  if (bytes.starts_with("\xFF\xFE"sv)) return Encoding::utf16Little;
  if (bytes.starts_with("\xFE\xFF"sv)) return Encoding::utf16Big;
  if (bytes.size() < 4) return Encoding::utf8;
  const auto isZero = [&](size_t i) { return bytes[i] == '\0'; };
  if (!isZero(0) && isZero(1)) return isZero(2) && isZero(3) ? Encoding::utf32 : Encoding::utf16Little;
  if (isZero(0) && isZero(1) && isZero(2) && !isZero(3)) return Encoding::utf32;
  return isZero(0) && !isZero(1) ? Encoding::utf16Big : Encoding::utf8;
}

void appendUtf8(std::string& text, uint32_t c) {
  if (c < 0x80) {
    text += char(c);
    return;
  }
  const int more = c < 0x800 ? 1 : c < 0x10000 ? 2 : 3;
  constexpr uint32_t kFirst[] = {0, 0xC0, 0xE0, 0xF0};
  text += char(kFirst[more] | c >> 6 * more);
  for (int k = more - 1; k >= 0; --k) text += char(0x80 | (c >> 6 * k & 0x3F));
}

// What is no character (half a pair, half a unit) becomes U+FFFD.
std::string fromUtf16(std::string_view bytes, bool bigEndian) {
  constexpr uint32_t kReplacement = 0xFFFD;
  const size_t count = bytes.size() / 2;
  const auto unit = [&](size_t i) {
    const auto first = uint8_t(bytes[2 * i]), second = uint8_t(bytes[2 * i + 1]);
    return bigEndian ? uint32_t(first) << 8 | second : uint32_t(second) << 8 | first;
  };
  std::string text;
  text.reserve(count);
  for (size_t i = 0; i < count; ++i) {
    uint32_t c = unit(i);
    if (c == 0xFEFF && i == 0) continue;
    if (c >= 0xD800 && c < 0xE000) {
      const uint32_t low = c < 0xDC00 && i + 1 < count ? unit(i + 1) : 0;
      const bool isPair = low >= 0xDC00 && low < 0xE000;
      c = isPair ? 0x10000 + ((c - 0xD800) << 10) + (low - 0xDC00) : kReplacement;
      i += isPair;
    }
    appendUtf8(text, c);
  }
  if (bytes.size() % 2 != 0) appendUtf8(text, kReplacement);
  return text;
}

bool endsALineAlone(std::string_view text, size_t carriageReturn) {
  return carriageReturn + 1 == text.size() || text[carriageReturn + 1] != '\n';
}

// The place of a carriage return that ends a line alone.
size_t findMacLineEnd(std::string_view text) {
  size_t at = text.find('\r');
  // Files of Windows are passed in blocks, of whose bytes none is looked at by itself.
  constexpr size_t kBlock = 64;
  for (; at != std::string_view::npos && at + kBlock < text.size(); at += kBlock) {
    const char* const block = text.data() + at;
    unsigned char isAlone = 0;
    for (size_t k = 0; k < kBlock; ++k) isAlone |= (unsigned char)((block[k] == '\r') & (block[k + 1] != '\n'));
    if (isAlone) break;
  }
  at = text.find('\r', at);
  while (at != std::string_view::npos && !endsALineAlone(text, at)) at = text.find('\r', at + 1);
  return at;
}

// Where a text ends that may have DOS's mark behind it, repeated up to the end of a block.
size_t endOf(std::string_view text) {
  const size_t end = text.find_last_not_of("\x1A \t\r\n") + 1;  // npos + 1 is 0
  return text.find('\x1A', end) == std::string_view::npos ? text.size() : end;
}

}  // namespace

PlainText::PlainText(const std::string& path, std::string_view bytes) : view_(bytes) {
  const Encoding encoding = encodingOf(bytes);
  if (encoding == Encoding::utf32) throw InputError(path + ": error: is UTF-32; save it as UTF-8");
  if (encoding != Encoding::utf8) {
    converted_ = fromUtf16(bytes, encoding == Encoding::utf16Big);
    view_ = converted_;
  }
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (view_.starts_with(kByteOrderMark)) view_.remove_prefix(kByteOrderMark.size());
  view_ = view_.substr(0, endOf(view_));

  if (const size_t first = findMacLineEnd(view_); first != std::string_view::npos) {
    converted_ = std::string(view_);
    view_ = converted_;
    for (size_t at = first; at < converted_.size(); ++at) {
      if (converted_[at] == '\r' && endsALineAlone(converted_, at)) converted_[at] = '\n';
    }
  }
}

}  // namespace turner
