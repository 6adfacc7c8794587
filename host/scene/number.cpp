// std::from_chars: exact, and deaf to the locale.
#include "scene/number.h"

#include <charconv>
#include <cmath>
#include <cstdlib>
#include <string>

namespace turner {

NumberFault parseNumber(std::string_view text, double& value) {
  if (text.starts_with('+')) text.remove_prefix(1);
  // from_chars takes "inf" and "nan", and a second sign is no number either.
  const std::string_view digits = text.starts_with('-') ? text.substr(1) : text;
  if (digits.empty() || !(digits[0] == '.' || (digits[0] >= '0' && digits[0] <= '9'))) return NumberFault::notANumber;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (end != text.data() + text.size()) return NumberFault::notANumber;
  if (error == std::errc::result_out_of_range) {
    // from_chars does not say on which side; strtod does, and rounds what is too small correctly.
    value = std::strtod(std::string(text).c_str(), nullptr);
    return std::isinf(value) ? NumberFault::tooLarge : NumberFault::none;
  }
  return error == std::errc() ? NumberFault::none : NumberFault::notANumber;
}

NumberFault parseInteger(std::string_view text, long long& value) {
  if (text.starts_with('+')) text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (end != text.data() + text.size()) return NumberFault::notANumber;
  if (error == std::errc::result_out_of_range) return NumberFault::tooLarge;
  return error == std::errc() ? NumberFault::none : NumberFault::notANumber;
}

}  // namespace turner
