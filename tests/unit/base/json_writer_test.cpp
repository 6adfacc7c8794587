// JSON that others read: a line each, and valid whatever the texts are.
#include <gtest/gtest.h>

#include <cmath>

#include "base/json_writer.h"

namespace turner {
namespace {

std::string lineOf(const std::string& value) {
  JsonWriter json;
  json.object([&] { json.put("text", value); });
  return json.oneLine();
}

TEST(JsonWriter, OneLineHasNoBreaksOutsideOfStrings) {
  JsonWriter json;
  json.object([&] {
    json.array("list", [&] {
      json.put(1);
      json.put(2.5);
    });
    json.object("inner", [&] { json.put("text", std::string("two\n  lines")); });
    json.put("none", std::optional<int>());
    json.put("some", std::optional<int>(3));
    json.put("nan", std::nan(""));
  });
  EXPECT_EQ(json.oneLine(),
            "{\"list\": [1,2.5],\"inner\": {\"text\": \"two\\n  lines\"},\"none\": null,\"some\": 3,\"nan\": null}\n");
}

TEST(JsonWriter, StringsAreUtf8WhateverTheyWere) {
  EXPECT_EQ(lineOf("caf\xc3\xa9 \xe2\x82\xac \xf0\x9f\x98\x80"),
            "{\"text\": \"caf\xc3\xa9 \xe2\x82\xac \xf0\x9f\x98\x80\"}\n");
  EXPECT_EQ(lineOf("a\xff"
                   "b"),
            "{\"text\": \"a\xef\xbf\xbd"
            "b\"}\n");
  EXPECT_EQ(lineOf("\xe2\x82"), "{\"text\": \"\xef\xbf\xbd\xef\xbf\xbd\"}\n") << "cut at the end";
  EXPECT_EQ(lineOf("\xed\xa0\x80"), "{\"text\": \"\xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd\"}\n")
      << "half of a surrogate pair";
  EXPECT_EQ(lineOf(std::string("a\0b", 3)), "{\"text\": \"a\\u0000b\"}\n");
}

}  // namespace
}  // namespace turner
