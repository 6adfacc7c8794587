// Damaged texts for parsers: whatever the bytes, a parser gives a result or an InputError, and never crashes.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "base/errors.h"

namespace turner::test {

// Parses a text. True for a result; an InputError must begin with the file's name.
inline bool survives(const std::function<void(const std::string&)>& parse, const std::string& text,
                     const std::string& file) {
  try {
    parse(text);
    return true;
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()).rfind(file + ':', 0), 0u) << error.what();
    return false;
  }
}

// A text with some words exchanged for others of it, or for words that are often wrong.
inline std::string exchangeWords(const std::string& text, std::mt19937_64& random) {
  static const std::vector<std::string> kOdd{"nan",  "inf",    "0",  "-1", "1e999", "1e30", "99999999999999999999",
                                             "\\\n", "\\\r\n", "\r", "\n", "#",     "\x1A", "x\\\n",
                                             "//",   "1//0",   "V",  "q",  "p 2\n", "\"",   ""};
  std::vector<std::string> words(1);
  for (const char c : text) {
    if (c == ' ' || c == '\n') {
      words.emplace_back(1, c);
      words.emplace_back();
    } else {
      words.back() += c;
    }
  }
  for (uint64_t k = 1 + random() % 4; k > 0; --k) {
    const std::string& other = random() % 2 ? kOdd[random() % kOdd.size()] : words[random() % words.size()];
    words[random() % words.size()] = std::string(other);
  }
  std::string mixed;
  for (const std::string& word : words) mixed += word;
  return mixed;
}

// Cut at every byte; a few bytes changed, 2000 times; words exchanged; nothing but noise.
inline void expectSurvivesDamage(const std::function<void(const std::string&)>& parse, const std::string& text,
                                 const std::string& file) {
  EXPECT_TRUE(survives(parse, text, file)) << "the whole text must be right";
  for (size_t length = 0; length < text.size(); ++length) survives(parse, text.substr(0, length), file);

  std::mt19937_64 random(1);
  int refused = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    std::string damaged = text;
    for (uint64_t k = 1 + random() % 4; k > 0; --k) damaged[random() % damaged.size()] = char(random());
    refused += !survives(parse, damaged, file);
  }
  EXPECT_GT(refused, 1000);

  for (int trial = 0; trial < 4000; ++trial) survives(parse, exchangeWords(text, random), file);

  std::string noise(100'000, '\0');
  for (char& byte : noise) byte = char(random());
  EXPECT_FALSE(survives(parse, noise, file));
}

}  // namespace turner::test
