// Reads decimal numbers exactly: the nearest double, whatever the locale.
#pragma once

#include <cstddef>
#include <string_view>

namespace turner {

enum class NumberFault { none, notANumber, tooLarge };

// Turns the whole of `text` into a finite double. A leading '+' is taken; "nan", "inf" and hexadecimal are not numbers;
// what is nearer to 0 than any double becomes 0.
NumberFault parseNumber(std::string_view text, double& value);

// The fast path of parseNumber: reads a decimal number at the start of `text` as far as it goes, and returns its
// length. 0, with `value` undefined, if none stands there or if it has too many digits to be read exactly in a few
// steps.
size_t readPlainDecimal(std::string_view text, double& value);

// Like parseNumber for integers; anything but digits after an optional sign is not a number.
NumberFault parseInteger(std::string_view text, long long& value);

}  // namespace turner
