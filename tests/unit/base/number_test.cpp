// Decimal numbers become the nearest double on every path that reads them; strtod, exact by its own means, is witness.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>

#include "base/number.h"

namespace turner {
namespace {

// Reads a text by both paths. Returns whether the fast one took it.
bool expectNearestDouble(const std::string& text) {
  const double expected = std::strtod(text.c_str(), nullptr);
  double value = NAN;
  const NumberFault fault = parseNumber(text, value);
  if (std::isinf(expected)) {
    EXPECT_EQ(fault, NumberFault::tooLarge) << text;
    return false;
  }
  EXPECT_EQ(fault, NumberFault::none) << text;
  // The sign of 0 counts too.
  EXPECT_EQ(std::bit_cast<uint64_t>(value), std::bit_cast<uint64_t>(expected)) << text;

  double plain = NAN;
  const size_t length = readPlainDecimal(text + " 7", plain);
  if (length == 0) return false;
  EXPECT_EQ(length, text.size()) << text;
  EXPECT_EQ(std::bit_cast<uint64_t>(plain), std::bit_cast<uint64_t>(expected)) << text;
  return true;
}

TEST(Number, RandomDecimalsAreTheNearestDouble) {
  std::mt19937_64 random(1);
  int fast = 0, all = 0;
  for (; all < 2'000'000 && !HasFailure(); ++all) {
    std::string text = random() % 3 == 0 ? "-" : random() % 8 == 0 ? "+" : "";
    const uint64_t whole = random() % 12, decimals = random() % (whole == 0 ? 12 : 13) + (whole == 0);
    for (uint64_t i = 0; i < whole; ++i) text += char('0' + random() % 10);
    if (decimals > 0 || random() % 2) text += '.';
    for (uint64_t i = 0; i < decimals; ++i) text += char('0' + random() % 10);
    if (random() % 3 == 0) {
      text += random() % 2 ? 'e' : 'E';
      text += std::to_string(int(random() % 61) - 30);
    }
    fast += expectNearestDouble(text);
  }
  // Both ways are taken.
  EXPECT_GT(fast, all / 4);
  EXPECT_LT(fast, all);
}

TEST(Number, DoublesInAnyNumberOfDigitsAreTheNearestDouble) {
  std::mt19937_64 random(2);
  char text[64];
  for (int i = 0; i < 500'000 && !HasFailure(); ++i) {
    const auto value = std::bit_cast<double>(random());
    if (!std::isfinite(value)) continue;
    std::snprintf(text, sizeof text, "%.*g", int(1 + random() % 20), value);
    expectNearestDouble(text);
    std::snprintf(text, sizeof text, "%.*f", int(random() % 16), std::remainder(value, 1000.0));
    expectNearestDouble(text);
  }
}

// Halfway between two doubles and beside it: whole numbers of 54 bits, and those over a power of ten.
TEST(Number, HardDecimalsAreTheNearestDouble) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 200'000 && !HasFailure(); ++i) {
    const uint64_t odd = (uint64_t(1) << 53) + 2 * (random() % 1000) + 1;
    for (const uint64_t digits : {odd, odd - 1, odd + 1, random() % (uint64_t(1) << 54), uint64_t(1) << 53}) {
      std::string text = std::to_string(digits);
      expectNearestDouble(text + "e" + std::to_string(int(random() % 48) - 24));
      expectNearestDouble(text.insert(random() % (text.size() + 1), "."));
    }
  }
}

TEST(Number, EdgesOfTheFastPathAreTheNearestDouble) {
  for (const char* text : {"0",
                           "-0",
                           "+0",
                           "0.0",
                           "-0.000000",
                           "-0e5",
                           ".5",
                           "5.",
                           "-.5",
                           "9007199254740992",
                           "9007199254740993",
                           "9007199254740992e22",
                           "9007199254740991e-22",
                           "1e22",
                           "1e23",
                           "1e-22",
                           "1e-23",
                           "1e+07",
                           "1E-07",
                           "1e0000001",
                           "9999999999999999999",
                           "18446744073709551616",
                           "18446744073709551617",
                           "0.30000000000000004",
                           "0.1000000000000000055511151231257827",
                           "00000000000000000000000001",
                           "0.00000000000000000000000001",
                           "1.7976931348623157e308",
                           "1.7976931348623159e308",
                           "4.9e-324",
                           "2e-324",
                           "1e-400",
                           "1e400",
                           "-1e400"}) {
    expectNearestDouble(text);
  }
}

TEST(Number, WhatIsNoNumberIsRefused) {
  for (const char* text :
       {"",   "+",  "-",  ".",  "-.",   "e5",  "1e",   "1e+", "1e-",   "+-1", "--1",   "++1", "1.2.3",
        "1x", "x1", " 1", "1 ", "0x10", "inf", "-inf", "nan", "1e5.5", "1,5", "1_000", "1f"}) {
    double value;
    EXPECT_EQ(parseNumber(text, value), NumberFault::notANumber) << '\'' << text << '\'';
  }
  for (const char* text : {"", "+", "-", "+-1", "-+1", "--1", "1.5", "1e3", "0x1", " 1", "1 "}) {
    long long value;
    EXPECT_EQ(parseInteger(text, value), NumberFault::notANumber) << '\'' << text << '\'';
  }
}

}  // namespace
}  // namespace turner
