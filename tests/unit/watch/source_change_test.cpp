// Where an edit is likely to have put an endless loop.
#include "watch/diagnosis/source_change.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <random>

namespace turner::watch {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

std::vector<ShaderSource> sources(const std::string& kernel, const std::string& included = "") {
  return {{"", "shaders/a.comp", kernel}, {"b.glsl", "shaders/b.glsl", included}};
}

// "b.glsl:2:3", or nothing.
std::string placeIn(const std::vector<ShaderSource>& good, const std::vector<ShaderSource>& edited) {
  const std::optional<SourceLocation> location = likelyLocation(good, edited);
  if (!location) return "";
  return location->path.substr(location->path.rfind('/') + 1) + ':' + std::to_string(location->line) + ':' +
         std::to_string(location->column);
}

std::string placeIn(const std::string& good, const std::string& edited) {
  return placeIn(sources(good), sources(edited));
}

TEST(SourceChange, NamesTheLoopThatWasAdded) {
  EXPECT_EQ(placeIn("void f() {\n}\n", "void f() {\n  int i = 0;\n  while (i < 3) {\n    g();\n  }\n}\n"),
            "a.comp:3:3");
}

TEST(SourceChange, NamesTheLoopThatLostALine) {
  EXPECT_EQ(placeIn("void f() {\n  do {\n    g();\n    ++i;\n  } while (i < 3);\n}\n",
                    "void f() {\n  do {\n    g();\n  } while (i < 3);\n}\n"),
            "a.comp:2:3");
}

TEST(SourceChange, NamesTheInnermostLoopAroundAChange) {
  const std::string good = "for (;;) {\n  a();\n  while (b) {\n    c();\n    ++i;\n  }\n  d();\n}\n";
  EXPECT_EQ(placeIn(good, "for (;;) {\n  a();\n  while (b) {\n    c();\n    --i;\n  }\n  d();\n}\n"), "a.comp:3:3");
  EXPECT_EQ(placeIn(good, "for (;;) {\n  a();\n  while (b) {\n    c();\n    ++i;\n  }\n  e();\n}\n"), "a.comp:1:1");
  EXPECT_EQ(placeIn(good, "for (;;) {\n  a();\n  while (b) {\n    c();\n    ++i;\n  }\n}\n"), "a.comp:1:1");
}

TEST(SourceChange, PrefersALoopWhoseHeadWasChanged) {
  const std::string good = "for (i) {\n  a();\n}\nvoid f() {}\ndo {\n  b();\n} while (c);\n";
  EXPECT_EQ(placeIn(good, "for (i) {\n  A();\n}\nvoid f() {}\ndo {\n  b();\n} while (true);\n"), "a.comp:5:1");
  EXPECT_EQ(placeIn(good, "for (i) {\n  A();\n}\nvoid f() {}\ndo {\n  B();\n} while (c);\n"), "a.comp:1:1");
  EXPECT_EQ(placeIn(good, "for (j) {\n  a();\n}\nvoid f() {}\ndo {\n  b();\n} while (true);\n"), "a.comp:1:1");
  // Also where it stands in a later file.
  EXPECT_EQ(placeIn(sources(good, "while (a)\n  b();\n"),
                    sources("for (i) {\n  A();\n}\nvoid f() {}\ndo {\n  b();\n} while (c);\n", "while (c)\n  b();\n")),
            "b.glsl:1:1");
}

TEST(SourceChange, NamesTheFirstChangeWhereNoLoopWasTouched) {
  EXPECT_EQ(placeIn("a();\nb();\nwhile (c) ;\n", "a();\n\n// why\n  B();\nwhile (c) ;\n"), "a.comp:4:3");
  EXPECT_EQ(placeIn("a();\nb();\nc();\n", "a();\nc();\n"), "a.comp:2:1");
  EXPECT_EQ(placeIn("a();\nb();\n", "a();\n"), "a.comp:1:1");
  EXPECT_EQ(placeIn("#define A 1\na();\n", "#define A 2\na();\n"), "a.comp:1:1");
}

TEST(SourceChange, IsSilentWhereNothingChanged) {
  EXPECT_EQ(placeIn("a();\n", "a();\n"), "");
  EXPECT_EQ(placeIn("while (a)  b();\n", "// a loop\n\n   while (a) b();  /* turns */\n"), "");
  EXPECT_EQ(placeIn({}, sources("while (a) b();\n")), "");
  EXPECT_EQ(placeIn("a();\n", ""), "");  // nothing is left that could be named
}

TEST(SourceChange, TakesANewFileAsChangedThroughout) {
  std::vector<ShaderSource> edited = sources("a();\n");
  edited.push_back({"c.glsl", "shaders/c.glsl", "int a;\n  for (;;) ;\n"});
  edited.push_back({"lost.glsl", "shaders/lost.glsl", std::nullopt});
  EXPECT_EQ(placeIn(sources("a();\n"), edited), "c.glsl:2:3");
}

// Blocks that are moved, doubled and thrown away: whatever is compared, a place is a line that differs.
TEST(SourceChange, FindsOnlyLinesThatDiffer) {
  std::mt19937 random(1);
  for (int round = 0; round < 300; ++round) {
    std::string good, edited;
    int firstNew = 0, line = 0;
    for (int i = 0; i < 30; ++i) {
      const std::string text = "f" + std::to_string(random() % 4) + "();\n";
      if (random() % 8 != 0) good += text;
      const bool isNew = random() % 8 == 0;
      edited += isNew ? "new" + std::to_string(i) + "();\n" : text;
      ++line;
      if (isNew && firstNew == 0) firstNew = line;
    }
    const std::optional<SourceLocation> location = likelyLocation(sources(good), sources(edited));
    if (firstNew == 0) continue;
    ASSERT_TRUE(location);
    EXPECT_LE(location->line, firstNew);
  }
}

TEST(SourceChange, FindsTheOneLineOfManyThatIsNew) {
  std::string good, edited;
  for (int i = 0; i < 4000; ++i) {
    good += "f" + std::to_string(i % 7) + "();\n";
    edited += "f" + std::to_string(i % 7) + "();\n";
    if (i == 17) good += "lost();\n";
    if (i == 2000) edited += "for (;;) new();\n";
    if (i == 3900) good += "lost();\n";
  }
  EXPECT_EQ(placeIn(good, edited), "a.comp:2002:1");
}

TEST(SourceChange, TakesLongFilesThatHaveNothingInCommon) {
  std::string good, edited;
  for (int i = 0; i < 30000; ++i) good += "f();\n", edited += "g();\n";
  EXPECT_EQ(placeIn(good, edited), "a.comp:1:1");
}

TEST(SourceChange, NamesALoopOfTheShaders) {
  const std::vector<ShaderSource> good = readShaderSources(TURNER_SHADERS_DIR "/whitted.comp");
  std::vector<ShaderSource> edited = good;
  for (ShaderSource& source : edited) {
    const std::string from = "        visitNode(ray, factors, traversal);\n";
    if (const size_t at = source.text->find(from); at != std::string::npos) source.text->erase(at, from.size());
  }
  const std::optional<SourceLocation> location = likelyLocation(good, edited);
  ASSERT_TRUE(location);
  EXPECT_EQ(location->path, TURNER_SHADERS_DIR "/traverse.glsl");
  const std::string& text = *std::find_if(edited.begin(), edited.end(), [&](const ShaderSource& source) {
                               return source.path == location->path;
                             })->text;
  size_t at = 0;
  for (int line = 1; line < location->line; ++line) at = text.find('\n', at) + 1;
  EXPECT_TRUE(text.substr(at).starts_with("      do {\n        if (LOOPS_AT_HEAD && (!isAtNode(traversal)"));
  EXPECT_THAT(changedFiles(good, edited), ElementsAre("traverse.glsl"));
}

TEST(SourceChange, ListsFilesThatDifferWereAddedOrAreGone) {
  std::vector<ShaderSource> good = sources("a();\n", "b();\n"), edited = sources("a();\n", "b(); \n");
  EXPECT_THAT(changedFiles(good, good), IsEmpty());
  good.push_back({"sub/gone.glsl", "shaders/sub/gone.glsl", ""});
  good.push_back({"unreadable.glsl", "shaders/unreadable.glsl", ""});
  edited.push_back({"new.glsl", "shaders/new.glsl", ""});
  edited.push_back({"unreadable.glsl", "shaders/unreadable.glsl", std::nullopt});
  EXPECT_THAT(changedFiles(good, edited), ElementsAre("b.glsl", "new.glsl", "unreadable.glsl", "gone.glsl"));
  EXPECT_THAT(changedFiles({}, sources("a();\n")), ElementsAre("a.comp", "b.glsl"));
}

}  // namespace
}  // namespace turner::watch
