// std::from_chars: exact, and deaf to the locale. Before it, a shorter way for the numbers that most files consist of.
#include "base/number.h"

#include <array>
#include <cfloat>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>

namespace turner {

namespace {

bool isDigit(char c) {
  return c >= '0' && c <= '9';
}

std::string_view withoutSign(std::string_view text) {
  return text.starts_with('-') || text.starts_with('+') ? text.substr(1) : text;
}

// All powers of ten that are doubles.
constexpr std::array<double, 23> kPowersOfTen{1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                                              1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

}  // namespace

// Clinger, "How to Read Floating Point Numbers Accurately", 1990: where the digits as a whole number and the
// power of ten are both doubles, one multiplication or division of the two is rounded once, and so correctly.
size_t readPlainDecimal(std::string_view text, double& value) {
  static_assert(FLT_EVAL_METHOD == 0, "a wider register would round a second time");
  const char* at = text.data();
  const char* const end = at + text.size();
  const bool negative = at != end && *at == '-';
  if (at != end && (*at == '-' || *at == '+')) ++at;

  uint64_t digits = 0;
  const auto takeDigits = [&] {
    const char* const first = at;
    for (; at != end && isDigit(*at); ++at) digits = 10 * digits + uint64_t(*at - '0');
    return at - first;
  };
  std::ptrdiff_t count = takeDigits();
  int exponent = 0;
  if (at != end && *at == '.') {
    ++at;
    const std::ptrdiff_t decimals = takeDigits();
    count += decimals;
    if (count > 19) return 0;  // they may have overflowed
    exponent = -int(decimals);
  }
  constexpr uint64_t kMostDigits = uint64_t(1) << DBL_MANT_DIG;
  if (count == 0 || count > 19 || digits > kMostDigits) return 0;

  if (at != end && (*at == 'e' || *at == 'E')) {
    ++at;
    const bool below = at != end && *at == '-';
    if (at != end && (*at == '-' || *at == '+')) ++at;
    if (at == end || !isDigit(*at)) return 0;
    int power = 0;
    for (int i = 0; i < 3 && at != end && isDigit(*at); ++i, ++at) power = 10 * power + (*at - '0');
    if (at != end && isDigit(*at)) return 0;
    exponent += below ? -power : power;
  }
  constexpr int kMostExponent = int(kPowersOfTen.size()) - 1;
  if (exponent < -kMostExponent || exponent > kMostExponent) return 0;
  const double magnitude =
      exponent < 0 ? double(digits) / kPowersOfTen[size_t(-exponent)] : double(digits) * kPowersOfTen[size_t(exponent)];
  value = negative ? -magnitude : magnitude;
  return size_t(at - text.data());
}

NumberFault parseNumber(std::string_view text, double& value) {
  if (!text.empty() && readPlainDecimal(text, value) == text.size()) return NumberFault::none;
  // from_chars takes "inf" and "nan", and a second sign is no number either.
  const std::string_view digits = withoutSign(text);
  if (digits.empty() || !(digits[0] == '.' || (digits[0] >= '0' && digits[0] <= '9'))) return NumberFault::notANumber;
  if (text.starts_with('+')) text.remove_prefix(1);
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
  if (!withoutSign(text).empty() && !isDigit(withoutSign(text)[0])) return NumberFault::notANumber;
  if (text.starts_with('+')) text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (end != text.data() + text.size()) return NumberFault::notANumber;
  if (error == std::errc::result_out_of_range) return NumberFault::tooLarge;
  return error == std::errc() ? NumberFault::none : NumberFault::notANumber;
}

}  // namespace turner
