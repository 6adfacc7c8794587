// Messages are taken apart, find their column, and reach a terminal without harm.
#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "base/errors.h"
#include "kernel/compile.h"
#include "watch/diagnosis/diagnosis.h"

namespace turner::watch {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::vector<ShaderSource> sourceOf(const std::string& text) {
  return {{"", "a.comp", text}};
}

// Of a message about the first line of a text.
int columnOf(const std::string& message, const std::string& line) {
  return readDiagnoses("a.comp:1: error: " + message, sourceOf(line)).at(0).column;
}

TEST(Diagnosis, TakesAMessageApart) {
  const Diagnosis found = readDiagnoses("a.comp:2:5: error: what: is wrong", sourceOf("one\n  two three\n")).at(0);
  EXPECT_EQ(found.file, "a.comp");
  EXPECT_EQ(found.line, 2);
  EXPECT_EQ(found.column, 5);
  EXPECT_EQ(found.message, "what: is wrong");
  EXPECT_EQ(found.source, "  two three");
}

TEST(Diagnosis, TakesEveryLineOfAMessage) {
  const auto found = readDiagnoses("a.comp:1:1: error: one\n\nC:/b c.glsl: error: two\nthree\n", sourceOf("x"));
  ASSERT_EQ(found.size(), 3u);
  EXPECT_EQ(found[1].file, "C:/b c.glsl");
  EXPECT_EQ(found[1].line, 0);
  EXPECT_EQ(found[1].message, "two");
  EXPECT_EQ(found[2].file, "");
  EXPECT_EQ(found[2].message, "three");
}

TEST(Diagnosis, WhatIsWrongWithASourceAsAWholeIsToldAtItsBeginning) {
  const Diagnosis found = readDiagnoses("a.comp: error: Missing entry point", sourceOf("#version 460\n")).at(0);
  EXPECT_EQ(gccText(found), "a.comp:1:1: error: Missing entry point\n  #version 460\n  ^");
}

TEST(Diagnosis, KeepsWhatOnlyLooksLikeAPlace) {
  const Diagnosis found = readDiagnoses("a.comp:99999999999999: error: m", sourceOf("x")).at(0);
  EXPECT_EQ(found.line, 0);
  EXPECT_EQ(found.file, "a.comp:99999999999999");
  EXPECT_EQ(readDiagnoses(": error: m", {}).at(0).message, ": error: m");
  EXPECT_THAT(readDiagnoses("", {}), IsEmpty());
}

TEST(Diagnosis, ReadsTheLineFromTheDiskWhereNoSourceHasIt) {
  const std::string path = testing::TempDir() + "diagnosis.glsl";
  std::ofstream(path) << "first\r\nsecond\rthird\n";
  EXPECT_EQ(readDiagnoses(path + ":2: error: m", {}).at(0).source, "second");
  EXPECT_EQ(readDiagnoses(path + ":3: error: m", {}).at(0).source, "third");
  EXPECT_EQ(readDiagnoses(path + ":9: error: m", {}).at(0).source, "");
  std::filesystem::remove(path);
  const Diagnosis missing = readDiagnoses(path + ":2: error: m", {}).at(0);
  EXPECT_EQ(missing.source, "");
  EXPECT_EQ(missing.column, 1);
  EXPECT_EQ(readDiagnoses("/dev/zero:1: error: m", {}).at(0).source, "");
}

TEST(Diagnosis, FindsTheColumnOfTheQuotedName) {
  EXPECT_EQ(columnOf("'b' : undeclared identifier", "\tab = b_ + b;"), 12);
  EXPECT_EQ(columnOf("'b' : undeclared identifier", "a /* b */ = b; // b"), 13);
  EXPECT_EQ(columnOf("'=' : cannot convert", "if (a == b) a = c;"), 15);
  EXPECT_EQ(columnOf("'#include' : no such file", "  #include \"x\""), 3);
}

TEST(Diagnosis, FindsTheColumnOfTheUnexpectedToken) {
  EXPECT_EQ(columnOf("'' : syntax error, unexpected RIGHT_BRACE, expecting COMMA or SEMICOLON", "  x = 1 }"), 9);
  EXPECT_EQ(columnOf("'' : syntax error, unexpected SEMICOLON", "  f(x;"), 6);
  EXPECT_EQ(columnOf("'' : syntax error, unexpected RETURN", "  returned return"), 12);
  EXPECT_EQ(columnOf("'' : syntax error, unexpected IDENTIFIER", "  3 abc"), 5);
  EXPECT_EQ(columnOf("'' : syntax error, unexpected FLOATCONSTANT", "a1 1.5e-3"), 4);
  EXPECT_EQ(columnOf("'' : syntax error, unexpected UVEC4, expecting COMMA", "a uvec4 b"), 3);
}

TEST(Diagnosis, FallsBackOnTheFirstColumnThatIsNotBlank) {
  EXPECT_EQ(columnOf("'lost' : something", " \t x"), 4);
  EXPECT_EQ(columnOf("nothing quoted", "x"), 1);
  EXPECT_EQ(columnOf("nothing quoted", ""), 1);
  EXPECT_EQ(columnOf("'", "  x"), 3);
}

// The messages as the compiler really writes them.
TEST(Diagnosis, FindsTheColumnOfTheCompilersErrors) {
  const auto placed = [](const std::string& line) {
    const std::vector<ShaderSource> sources =
        sourceOf("#version 460\nlayout(local_size_x = 1) in;\nvoid main() {\n" + line + "\n}\n");
    try {
      compileGlsl(sources);
    } catch (const InputError& error) {
      const Diagnosis found = readDiagnoses(error.what(), sources).at(0);
      return std::to_string(found.line) + ':' + std::to_string(found.column);
    }
    return std::string("compiles");
  };
  EXPECT_EQ(placed("  float x = lost;"), "4:13");
  EXPECT_EQ(placed("  float x = (1.0;"), "4:17");
  EXPECT_EQ(placed("  float x = 1.0"), "5:1");
  EXPECT_EQ(placed("  uint x = 1.0;"), "4:10");
  EXPECT_EQ(placed("  x 3;"), "4:3");
}

TEST(Diagnosis, WritesWhatEditorsRead) {
  EXPECT_EQ(gccText({"a.comp", 3, 5, "wrong", "\tab cd"}), "a.comp:3:5: error: wrong\n  \tab cd\n  \t   ^");
  EXPECT_EQ(gccText({"a.comp", 3, 1, "wrong", ""}), "a.comp:3:1: error: wrong");
  EXPECT_EQ(gccText({"a.comp", 0, 0, "wrong", ""}), "a.comp: error: wrong");
  EXPECT_EQ(gccText({"", 0, 0, "wrong", ""}), "turner: error: wrong");
}

TEST(Diagnosis, PutsTheCaretBelowItsCharacter) {
  // Two bytes of UTF-8 take one place on the terminal.
  EXPECT_THAT(gccText({"a", 1, 4, "m", "\u00e9 x"}), HasSubstr("\n  \u00e9 x\n    ^"));
  EXPECT_THAT(gccText({"a", 1, 2, "m", "\u00e9 x"}), HasSubstr("\n  ^"));
  EXPECT_THAT(gccText({"a", 1, 99, "m", "ab"}), HasSubstr("\n  ab\n    ^"));
}

TEST(Diagnosis, CutsALongLineAroundTheCaret) {
  const std::string line = std::string(300, 'a') + 'X' + std::string(300, 'b');
  const std::string text = gccText({"a", 1, 301, "m", line});
  const size_t second = text.find('\n') + 1, third = text.find('\n', second) + 1;
  const std::string shown = text.substr(second, third - 1 - second), caret = text.substr(third);
  EXPECT_LE(shown.size(), 130u);
  EXPECT_EQ(shown.at(caret.find('^')), 'X');
  EXPECT_EQ(shown.substr(0, 6), "  ...a");
  EXPECT_THAT(shown, testing::EndsWith("b..."));
}

TEST(Diagnosis, HarmsNoTerminal) {
  // Escape, bell, delete, a control character of Latin 1, one that turns the writing, and bytes that are no UTF-8.
  const std::string text = gccText({"a\x1b[2J", 1, 1, "m\x07",
                                    "x\x1b]0;t\x7f\xc2\x9b\xe2\x80\xae\xff\x9b\xe2\x80"
                                    "\r y"});
  EXPECT_EQ(text,
            "a?[2J:1:1: error: m?\n  x?]0;t?????"
            "??? y\n  ^");
}

}  // namespace
}  // namespace turner::watch
