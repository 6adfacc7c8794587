// How fast a parser is beside the least that any parser of numbers must do, so that a test of its speed holds on every
// machine and under load: both are measured in turn, in processor time.
#pragma once

#include <algorithm>
#include <charconv>
#include <ctime>
#include <functional>
#include <limits>
#include <string>
#include <string_view>

namespace turner::test {

inline double processorSeconds() {
  timespec time;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

// Finds each line's end with memchr and each number's value with from_chars. Returns their sum.
inline double sumNumbers(std::string_view text) {
  double sum = 0;
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    for (const char *at = line.data(), *end = at + line.size(); at < end;) {
      double value = 0;
      const auto [stop, error] = std::from_chars(at, end, value);
      at = error == std::errc() ? stop : at + 1;
      sum += value;
    }
    text.remove_prefix(std::min(text.size(), line.size() + 1));
  }
  return sum;
}

// The parser's time over that of sumNumbers, each the least of a few runs.
inline double timeBesideSumming(const std::string& text, const std::function<void(const std::string&)>& parse) {
  double parsing = std::numeric_limits<double>::infinity(), summing = parsing, sum = 0;
  for (int run = 0; run < 5; ++run) {
    const double start = processorSeconds();
    sum += sumNumbers(text);
    const double middle = processorSeconds();
    parse(text);
    summing = std::min(summing, middle - start);
    parsing = std::min(parsing, processorSeconds() - middle);
  }
  // The sum is used, or it would not be computed.
  return sum == sum ? parsing / summing : std::numeric_limits<double>::infinity();
}

// What optimised parsers keep well below; unoptimised or sanitized ones have their own ratio.
#if defined(NDEBUG) && !defined(__SANITIZE_ADDRESS__)
inline constexpr double kMostTimeBesideSumming = 3;
#else
inline constexpr double kMostTimeBesideSumming = 200;
#endif

}  // namespace turner::test
