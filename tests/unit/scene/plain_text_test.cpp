// Whatever a text is written in, the parsers get the same.
#include <gtest/gtest.h>

#include <string>

#include "base/errors.h"
#include "scene/json/scene_json.h"
#include "scene/nff/scene_nff.h"
#include "scene/obj/mesh_obj.h"
#include "scene/plain_text.h"

namespace turner {
namespace {

using namespace std::string_literals;

std::string plain(const std::string& bytes) {
  return std::string(PlainText("x", bytes).view());
}

std::string inUtf16(const std::string& ascii, bool bigEndian) {
  std::string bytes;
  for (const char c : ascii) bytes += bigEndian ? std::string{'\0', c} : std::string{c, '\0'};
  return bytes;
}

TEST(PlainText, WhatIsPlainIsNotCopied) {
  for (const std::string& text : {""s, "v"s, "v 0 0 0\nf 1 2 3\n"s, "a\r\nb\r\n"s, "k\xC3\xA4se\n"s, "a\0b"s}) {
    const PlainText plain("x", text);
    EXPECT_EQ(plain.view(), text);
    EXPECT_EQ(plain.view().data(), text.data());
  }
}

TEST(PlainText, ByteOrderMarkIsNoText) {
  EXPECT_EQ(plain("\xEF\xBB\xBFv 0"), "v 0");
  EXPECT_EQ(plain("\xEF\xBB\xBF"), "");
}

TEST(PlainText, Utf16IsDecoded) {
  const std::string text = "v 0 0 0\r\nf 1\n";
  for (const bool bigEndian : {false, true}) {
    EXPECT_EQ(plain(inUtf16(text, bigEndian)), text);
    EXPECT_EQ(plain((bigEndian ? "\xFE\xFF"s : "\xFF\xFE"s) + inUtf16(text, bigEndian)), text);
  }
  // Two, three and four bytes; halves of pairs, and half a unit.
  EXPECT_EQ(plain("\xFF\xFE\xE4\x00\xAC\x20\x3D\xD8\x00\xDE"s), "\xC3\xA4\xE2\x82\xAC\xF0\x9F\x98\x80");
  EXPECT_EQ(plain("\xFF\xFE\x3D\xD8\x61\x00\x00\xDE\x3D\xD8\x61"s),
            "\xEF\xBF\xBD"
            "a\xEF\xBF\xBD\xEF\xBF\xBD\xEF\xBF\xBD");
}

TEST(PlainText, Utf32IsRefused) {
  for (const std::string& bytes :
       {"\xFF\xFE\0\0v\0\0\0"s, "\0\0\xFE\xFF\0\0\0v"s, "v\0\0\0 \0\0\0"s, "\0\0\0v\0\0\0 "s}) {
    try {
      plain(bytes);
      ADD_FAILURE();
    } catch (const InputError& error) {
      EXPECT_STREQ(error.what(), "x: error: is UTF-32; save it as UTF-8");
    }
  }
}

TEST(PlainText, CarriageReturnAloneEndsALine) {
  EXPECT_EQ(plain("a\rb\r"), "a\nb\n");
  EXPECT_EQ(plain("a\r\nb\rc\nd\r\r\n"), "a\r\nb\nc\nd\n\r\n");
}

TEST(PlainText, DosEndOfFileIsCutOff) {
  for (const char* end : {"\x1A", "\n\x1A\x1A\x1A", "\r\n\x1A\r\n"})
    EXPECT_EQ(plain(std::string("f 1 2 3") + end), "f 1 2 3");
  EXPECT_EQ(plain("a\x1A"
                  "b\n"),
            "a\x1A"
            "b\n");
}

// Each format, in each way to write it.
TEST(PlainText, AllFormatsTakeAllTexts) {
  const std::string obj = "v 0 0 0\nv 1 0 0 # c\nv 0 1 0\nf 1 2 3\n", json = "{ // comment\n\"depth\": 7\n}\n",
                    nff = "# comment\nb 1 0 0\n";
  const auto check = [&](const auto& write) {
    const Mesh mesh = parseObj("x.obj", write(obj));
    EXPECT_EQ(mesh.faces.size(), 1u);
    EXPECT_TRUE(mesh.notes.empty());
    EXPECT_EQ(parseJsonScene("x.json", write(json)).scene.depth, 7);
    const Scene scene = parseNffScene("x.nff", write(nff)).scene;
    EXPECT_EQ(scene.background, glm::dvec3(1, 0, 0));
    EXPECT_TRUE(scene.notes.empty());
  };
  const auto withLineEnds = [](std::string text, const std::string& end) {
    for (size_t at = 0; (at = text.find('\n', at)) != text.npos; at += end.size()) text.replace(at, 1, end);
    return text;
  };
  check([](const std::string& text) { return text; });
  check([](const std::string& text) { return "\xEF\xBB\xBF" + text; });
  check([](const std::string& text) { return text + "\x1A"; });
  check([](const std::string& text) { return "\xFF\xFE" + inUtf16(text, false); });
  check([](const std::string& text) { return "\xFE\xFF" + inUtf16(text, true); });
  check([](const std::string& text) { return inUtf16(text, false); });
  for (const char* end : {"\r", "\r\n"}) {
    check([&](const std::string& text) { return withLineEnds(text, end); });
    check([&](const std::string& text) { return "\xFF\xFE" + inUtf16(withLineEnds(text, end), false); });
  }
}

// Lines are counted as the user's editor counts them.
TEST(PlainText, FaultsHaveTheirPlaces) {
  try {
    parseObj("x.obj", "\xEF\xBB\xBFv 0 0 0\rv 1 0 0\rf 1 2 3\r");
    ADD_FAILURE();
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()).substr(0, 17), "x.obj:3:7: error:");
  }
}

}  // namespace
}  // namespace turner
