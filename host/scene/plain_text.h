// The bytes of a text file as all parsers want them: UTF-8 without a byte order mark, lines that end in '\n'.
#pragma once

#include <string>
#include <string_view>

namespace turner {

class PlainText {
 public:
  // Takes UTF-8 and UTF-16, with a byte order mark or without; lines may end as on DOS (whose carriage return stays, a
  // blank), and in a carriage return alone, as on old Macs; DOS's mark of the end of a file is cut off. `bytes` must
  // outlive this object: what is plain already is not copied. Throws InputError, naming `path`, for UTF-32.
  PlainText(const std::string& path, std::string_view bytes);
  PlainText(const PlainText&) = delete;
  PlainText& operator=(const PlainText&) = delete;

  std::string_view view() const { return view_; }

 private:
  std::string converted_;
  std::string_view view_;
};

}  // namespace turner
