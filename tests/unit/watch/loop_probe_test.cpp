// The probe's kernel tells which loop never ends, and changes nothing else. Loops are planted in copies of the shaders.
#include "watch/diagnosis/loop_probe.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cstring>
#include <map>

#include "base/errors.h"
#include "base/text_file.h"
#include "scene/scene_load.h"
#include "support/our_scenes.h"
#include "support/shader_harness.h"
#include "support/shader_variant.h"

namespace turner::watch {

namespace {

using test::ours;
using test::settingsOf;
using testing::HasSubstr;
using testing::Not;

class RendererEndsWithTheTests : public testing::Environment {
  void TearDown() override { test::endRenderer(); }
};
const testing::Environment* const rendererEnd = testing::AddGlobalTestEnvironment(new RendererEndsWithTheTests);

std::vector<ShaderSource> shipped() {
  return readShaderSources(TURNER_SHADERS_DIR "/whitted.comp");
}

// The places of the loops of one text, as "line:column line:column ".
std::string loopsOf(const std::string& text) {
  std::string locations;
  for (const SourceLocation& location : probeLoops({{"", "a.comp", text}}).loops)
    locations += std::to_string(location.line) + ':' + std::to_string(location.column) + ' ';
  return locations;
}

// The text with its counters, but without the declarations before it and the definitions behind it.
std::string probed(const std::string& text) {
  std::string result = *probeLoops({{"", "a.comp", text}}).sources[0].text;
  result.erase(0, result.find('\n') + 1);
  result.erase(result.rfind("\nvoid turnerTell"));
  return result;
}

// --- texts ----------------------------------------------------------------------------------------------------------

TEST(LoopProbe, CountsTheTurnsOfALoop) {
  EXPECT_EQ(
      probed("void f() { for (;;) { g(); } }"),
      "void f() { { uint turnerTurns0 = 0u; for (;;) { if (turnerTooMany(turnerTurns0, 0u)) break; { g(); } } } }");
  EXPECT_EQ(
      probed("void f() { do g(); while (h()); }"),
      "void f() { { uint turnerTurns0 = 0u; do { if (turnerTooMany(turnerTurns0, 0u)) break; g(); } while (h()); } "
      "}");
}

TEST(LoopProbe, CountsTheTurnsOfALoopWithoutBraces) {
  EXPECT_EQ(probed("while (a) if (b) c(); else d();"),
            "{ uint turnerTurns0 = 0u; while (a) { if (turnerTooMany(turnerTurns0, 0u)) break; "
            "if (b) c(); else d(); } }");
  EXPECT_EQ(probed("if (a) b(); else for (;;) ;"),
            "if (a) b(); else { uint turnerTurns0 = 0u; for (;;) { if (turnerTooMany(turnerTurns0, 0u)) break; ; } }");
}

TEST(LoopProbe, KeepsAttributesAtTheirLoop) {
  EXPECT_EQ(
      probed("if (a) [[unroll]] for (;;) f();"),
      "if (a) { uint turnerTurns0 = 0u; [[unroll]] for (;;) { if (turnerTooMany(turnerTurns0, 0u)) break; f(); } }");
}

TEST(LoopProbe, TellsLoopsByTheirKeywords) {
  EXPECT_EQ(loopsOf("void f() {\n  for (;;)\n    while (true)\n      do g(); while (a);\n}"), "2:3 3:5 4:7 ");
  EXPECT_EQ(loopsOf("do do g(); while (a); while (b); while (c) ;"), "1:1 1:4 1:34 ");
  EXPECT_EQ(loopsOf("\t[[unroll]] for (;;) f();\r\nwhile (a) { }"), "1:13 2:1 ");
  EXPECT_EQ(loopsOf("switch (a) { case 1: for (;;) break; default: while (b) continue; }"), "1:22 1:47 ");
}

TEST(LoopProbe, SeesNoLoopsInCommentsNamesAndDirectives) {
  EXPECT_EQ(loopsOf("// for (;;) f();\n/* while\n(a) b(); */ int former, do_it, whiled; // \\\n for (;;) ;\n"), "");
  EXPECT_EQ(loopsOf("#define LOOP for (;;) \\\n  while (a)\n  # define B /* \n */ do b(); while (c)\n"), "");
  EXPECT_EQ(loopsOf("int a; /*\n*/ # for (;;) ;"), "2:6 ");  // no directive: the comment is a blank
  EXPECT_EQ(loopsOf("debugPrintfEXT(\"for (;;) \\\" ;\"); while (a) ;"), "1:34 ");
}

TEST(LoopProbe, CountsLinesAndColumnsWhereCommentsAndBrokenLinesCome) {
  EXPECT_EQ(loopsOf("/* a\n b */ for (;;) ;\r\n\r  while (a \\\n b) ;\nfor (;;) ;"), "2:7 4:3 6:1 ");
}

TEST(LoopProbe, LeavesAloneWhatTheConditionalsTearApart) {
  EXPECT_EQ(loopsOf("#if A\nfor (;;) {\n#else\nwhile (b) {\n#endif\n f(); }\nfor (;;) ;\n"), "7:1 ");
  EXPECT_EQ(loopsOf("#if A\ndo {\n#else\n{\n#endif\n f(); } while (b);\n"), "");
  EXPECT_EQ(loopsOf("#ifdef A\nfor (;;)\n#elif B\nwhile (b)\n#endif\n f();"), "");
  // Around such a place, and inside of a branch, loops are whole.
  EXPECT_EQ(loopsOf("for (;;) {\n#if A\nif (a) {\n#else\nif (b) { while (c) ; \n#endif\n f(); } }\nfor (;;) ;"),
            "1:1 5:10 8:1 ");
}

TEST(LoopProbe, FollowsBracketsThatAreConditionalWithoutAnElse) {
  EXPECT_EQ(loopsOf("void f() {\n#if A\nif (a) {\n#endif\nfor (;;) { b(); }\n#if A\n}\n#endif\nwhile (c) ;\n}\n"
                    "void g() { do ; while (d); }"),
            "5:1 9:1 11:12 ");
  EXPECT_EQ(loopsOf("for (;;) {\n#ifdef A\n if (a) {\n#endif\n b();\n#ifdef A\n}\n#endif\n}"), "1:1 ");
  EXPECT_EQ(loopsOf("for (;;) {\n#if 0\n {\n#endif\n}"), "1:1 ");
}

TEST(LoopProbe, TakesAnyText) {
  for (const std::string text : {"",
                                 "for",
                                 "for (",
                                 "for (;;",
                                 "for (;;)",
                                 "for (;;) {",
                                 "for (;;) }",
                                 "while (a) (",
                                 "do",
                                 "do ;",
                                 "do ; while",
                                 "do ; while (a)",
                                 "if (a) for",
                                 "} ) ] for (;;) ;",
                                 "#",
                                 "\"",
                                 "\"\\",
                                 "/*",
                                 "//",
                                 "\\",
                                 "#if",
                                 "#endif\n#else\n",
                                 "void main() {",
                                 "void main(",
                                 "void main() }",
                                 "] for (;;) ;",
                                 "for (;;) [ ;",
                                 "\xff\xfe for"})
    EXPECT_NO_THROW(probeLoops({{"", "a.comp", text}})) << text;
  std::string deep;
  for (int i = 0; i < 400000; ++i) deep += "if (a) ";
  EXPECT_NO_THROW(probeLoops({{"", "a.comp", "for (;;) " + deep + ";"}}));
}

TEST(LoopProbe, KeepsFilesThatCannotBeRead) {
  const LoopProbe probe = probeLoops({{"", "a.comp", "for (;;) ;"}, {"b.glsl", "b.glsl", std::nullopt}});
  ASSERT_EQ(probe.sources.size(), 2u);
  EXPECT_FALSE(probe.sources[1].text);
}

TEST(LoopProbe, DeclaresBehindTheVersionAndBeforeTheFirstInclude) {
  const std::string text =
      *probeLoops({{"", "a.comp", "// a\n#version 460\n#extension E : require\n#include \"b.glsl\"\nint a;\n"}})
           .sources[0]
           .text;
  EXPECT_LT(text.find("#extension"), text.find("uint turnerMost"));
  EXPECT_THAT(text, HasSubstr("\nuint turnerMost"));
  EXPECT_THAT(text, HasSubstr("\n#include"));
  EXPECT_LT(text.find("uint turnerMost"), text.find("#include"));
}

TEST(LoopProbe, TellsAtEveryEndOfMain) {
  EXPECT_EQ(probed("void f() { return; } void main(void) { if (a) return; b(); }"),
            "void f() { return; } void main(void) { if (a) { turnerTell(); return; } b(); turnerTell(); }");
  EXPECT_EQ(probed("void main() {}"), "void main() {turnerTell(); }");
}

TEST(LoopProbe, DecodesTheLoop) {
  const LoopProbe probe = probeLoops({{"", "a.comp", "for (;;) ;\nwhile (a) ;\n"}});
  EXPECT_FALSE(endlessLoop(probe, 0));
  EXPECT_FALSE(endlessLoop(probe, 4096));  // a canary alone
  EXPECT_EQ(endlessLoop(probe, 15u << 28 | 1u << 20 | 77u)->line, 2);
  EXPECT_EQ(endlessLoop(probe, 3u << 28)->line, 1);
  EXPECT_FALSE(endlessLoop(probe, 15u << 28 | 2u << 20));
}

// --- the kernel as it is shipped -------------------------------------------------------------------------------------

// Counted by hand.
TEST(LoopProbe, KnowsAllLoopsOfTheShaders) {
  std::map<std::string, int> counts;
  const LoopProbe probe = probeLoops(shipped());
  for (const SourceLocation& location : probe.loops) ++counts[location.path.substr(location.path.rfind('/') + 1)];
  const std::map<std::string, int> expected = {{"canary.glsl", 1},
                                               {"nested_dielectrics.glsl", 2},
                                               {"resume.glsl", 2},
                                               {"traverse.glsl", 4},
                                               {"whitted.comp", 2}};
  EXPECT_EQ(counts, expected) << "if a loop was added, count it here";
  for (const SourceLocation& location : probe.loops) {
    const std::string text = readTextFile(location.path);
    size_t at = 0;
    for (int line = 1; line < location.line; ++line) at = text.find('\n', at) + 1;
    const std::string found = text.substr(at + size_t(location.column) - 1, 4);
    EXPECT_TRUE(found == "do {" || found == "for ") << found;
  }
}

Image render(const Spirv& kernel, const RenderSettings& settings, uint32_t budget) {
  return test::renderer().render(kernel, settings, {}, {.budget = budget}).image;
}

Spirv compileProbe(const LoopProbe& probe, BufferAccess access) {
  return compileGlsl(probe.sources, accessPreamble(access));
}

TEST(LoopProbe, CompilesForEveryWayOfFetching) {
  const LoopProbe probe = probeLoops(shipped());
  for (const BufferAccess access :
       {BufferAccess::texelBuffer, BufferAccess::storageBuffer, BufferAccess::deviceAddress})
    EXPECT_NO_THROW(compileProbe(probe, access)) << accessName(access);
}

class HonestScene : public testing::TestWithParam<const char*> {};

// spot's rays meet nodes, those of glass have waiting rays, those of nested_glass carry solids, those of deep_glass
// make the most turns: pixels there spend the budgets of many dispatches.
TEST_P(HonestScene, KeepsItsPictureAndNoLoopIsBlamed) {
  const Spirv kernel = compileProbe(probeLoops(shipped()), test::renderer().access());
  const Scene scene = ours(GetParam());
  const RenderSettings settings = settingsOf(scene, 64, 64);
  const Image expected = test::renderShader(scene, settings);
  const Image image = render(kernel, settings, kProbeBudget);
  ASSERT_EQ(image.rgb.size(), expected.rgb.size());
  EXPECT_EQ(std::memcmp(image.rgb.data(), expected.rgb.data(), image.rgb.size() * sizeof(float)), 0);
}

INSTANTIATE_TEST_SUITE_P(LoopProbe, HonestScene,
                         testing::Values("spheres", "spot", "glass", "nested_glass", "cliff_hanger", "deep_glass"),
                         [](const auto& parameter) { return std::string(parameter.param); });

// --- endless loops --------------------------------------------------------------------------------------------------

// A copy of the shaders in which a loop never ends. Its keyword stands behind kHere.
const std::string kHere = "/*here*/";

SourceLocation placeOfHere(const std::vector<ShaderSource>& sources) {
  for (const ShaderSource& source : sources) {
    const size_t at = source.text->find(kHere);
    if (at == std::string::npos) continue;
    const std::string before = source.text->substr(0, at);
    return {source.path, int(std::count(before.begin(), before.end(), '\n')) + 1,
            int(at - (before.rfind('\n') + 1) + kHere.size()) + 1};
  }
  throw RunError("no loop is marked");
}

struct Planted {
  std::string name;
  std::vector<test::Replacement> replacements;
  std::string scene = "spheres";
  uint32_t budget = kProbeBudget;
};

void PrintTo(const Planted& planted, std::ostream* out) {
  *out << planted.name;
}

class EndlessLoop : public testing::TestWithParam<Planted> {};

TEST_P(EndlessLoop, IsFound) {
  const test::ShaderVariant variant(GetParam().replacements);
  const std::vector<ShaderSource> sources = readShaderSources(variant.folder() + "/shaders/whitted.comp");
  const SourceLocation expected = placeOfHere(sources);
  const LoopProbe probe = probeLoops(sources);
  const Spirv kernel = compileProbe(probe, test::renderer().access());
  const Scene scene = ours(GetParam().scene);
  const RenderSettings settings = settingsOf(scene, 64, 64);
  test::renderer().upload(test::packed(scene, settings));
  try {
    render(kernel, settings, GetParam().budget);
    FAIL() << "no loop was cut";
  } catch (const LoopsCut& cut) {
    const std::optional<SourceLocation> location = endlessLoop(probe, cut.count);
    ASSERT_TRUE(location) << std::hex << cut.count;
    EXPECT_EQ(location->path, expected.path);
    EXPECT_EQ(location->line, expected.line) << std::hex << cut.count;
    EXPECT_EQ(location->column, expected.column);
  }
}

INSTANTIATE_TEST_SUITE_P(
    LoopProbe, EndlessLoop,
    testing::Values(
        Planted{"EmptyWhile",
                {{"", "whitted.comp", "  int budget = int(BUDGET);",
                  "  int budget = int(BUDGET);\n"
                  "  /*here*/while (true) {}"}}},
        Planted{"EmptyForWithoutBody",
                {{"", "whitted.comp", "  if (!isFinished(traversal)) return;",
                  "  if (!isFinished(traversal)) return;\n  /*here*/for (;;);"}}},
        Planted{"EmptyDo",
                {{"", "nested_dielectrics.glsl", "  uvec4 interfaces = material.transmittance > 0.0 ?",
                  "  /*here*/do {} while (material.glass == 0u);\n"
                  "  uvec4 interfaces = material.transmittance > 0.0 ?"}},
                "nested_glass"},
        // With an effect, and only for some invocations.
        Planted{"SomePixels",
                {{"", "whitted.comp", "  bool finishedBefore = phase == kDone;",
                  "  if (pixel.x == 17u && pixel.y > 40u) /*here*/while (sum.x >= 0.0) sum.x += 1.0;\n"
                  "  bool finishedBefore = phase == kDone;"}}},
        Planted{"LostIncrement",
                {{"", "nested_dielectrics.glsl",
                  "  i = 0u;\n  do {\n    if (LOOPS_AT_HEAD && !isInterfaceAt(interfaces, i)) break;\n"
                  "    uint interfaceId = idAt(interfaces, i), medium = interfaceId & ~kInterfaceFront;",
                  "  i = 0u;\n  /*here*/do {\n"
                  "    uint interfaceId = idAt(interfaces, i), medium = interfaceId & ~kInterfaceFront;"},
                 {"", "nested_dielectrics.glsl", "beyond = withMedium(beyond, medium);\n    ++i;",
                  "beyond = withMedium(beyond, medium);"}},
                "nested_glass"},
        Planted{"LostIncrementInAFor",
                {{"", "canary.glsl", "  for (uint i = 0u; i < frame.canaryLength; ++i) ++sung;",
                  "  /*here*/for (uint i = 0u; i < frame.canaryLength;) ++sung;"}}},
        // A walk that nothing ends: neither its node nor the budget moves on.
        Planted{"NodesThatNeverEnd",
                {{"", "traverse.glsl",
                  "      do {\n        if (LOOPS_AT_HEAD && (!isAtNode(traversal) || budget <= 0)) break;\n"
                  "        --budget;\n        visitNode(ray, factors, traversal);",
                  "      /*here*/do {"}},
                "spot"},
        Planted{"ShapesThatNeverEnd",
                {{"", "traverse.glsl",
                  "  do {\n    if (LOOPS_AT_HEAD && (isBehindList(traversal, end) || budget <= 0)) break;\n"
                  "    --budget;\n    ListEntry entry",
                  "  /*here*/do {\n    ListEntry entry"},
                 {"", "traverse.glsl", "traversal.list.first = within ? traversal.list.first + 1u : end;", ";"}}},
        // A function with a loop, called in loops.
        Planted{
            "InACalledFunction",
            {{"", "sphere.glsl", "float nearestRoot(const float b,",
              "float spin(float x) {\n  /*here*/while (x != 2.0) x = abs(x);\n  return x;\n}\n\nfloat "
              "nearestRoot(const float b,"},
             {"", "sphere.glsl", "bool isOther = c > 0.0 || b < 0.0;", "bool isOther = c > 0.0 || spin(b) < 0.0;"}}},
        // Others run inside of it, each to its end.
        Planted{"AroundOtherLoops",
                {{"", "whitted.comp", "    do {\n      if (LOOPS_AT_HEAD && (phase",
                  "    /*here*/do {\n      if (LOOPS_AT_HEAD && (phase"},
                 {"", "whitted.comp", "    } while (LOOPS_AT_HEAD || (phase != kDone && budget > 0));",
                  "    } while (phase != 77u);"}}},
        Planted{"AroundLongerLoops",
                {{"", "whitted.comp", "  bool finishedBefore = phase == kDone;",
                  "  float x = float(pixelAt);\n  /*here*/while (x >= 0.0)\n"
                  "    for (int i = 0; i < 40; ++i) x += fract(x) + 1.0;\n  sum.x += x;\n"
                  "  bool finishedBefore = phase == kDone;"}}},
        // Its neighbours and the loops around it end.
        Planted{"InsideOfLoops",
                {{"", "whitted.comp", "  bool finishedBefore = phase == kDone;",
                  "  float x = float(pixelAt);\n  for (int i = 0; i < 30; ++i)\n    for (int j = 0; j < 30; ++j)"
                  "\n      if (i < 20) x += 1.0;\n      else /*here*/for (;; x += 1.0) {\n"
                  "        if (x < 0.0) break; else continue;\n      }\n  sum.x += x;\n"
                  "  bool finishedBefore = phase == kDone;"}}},
        // Every dispatch ends, and the picture is never done.
        Planted{"LightsThatNeverEnd",
                {{"", "whitted.comp", "      do {\n        if (LOOPS_AT_HEAD && (lightIndex",
                  "      /*here*/do {\n        if (LOOPS_AT_HEAD && (lightIndex"},
                 {"", "whitted.comp", "    ++lightIndex;\n", ""}},
                "spheres",
                kLongProbeBudget},
        Planted{"SamplesThatNeverEnd",
                {{"", "whitted.comp", "    do {\n      if (LOOPS_AT_HEAD && (phase",
                  "    /*here*/do {\n      if (LOOPS_AT_HEAD && (phase"},
                 {"", "whitted.comp", "sampleIndex < SAMPLES * SAMPLES ? kNextSample : kDone",
                  "sampleIndex < 0xffffffffu ? kNextSample : kDone"}},
                "spheres",
                kLongProbeBudget},
        Planted{"BeforeAReturn",
                {{"", "whitted.comp", "  bool finishedBefore = phase == kDone;",
                  "  if (pixel.y == 9u) {\n    /*here*/do sum.x += 1.0; while (sum.x > 0.0);\n    return;\n"
                  "  }\n  bool finishedBefore = phase == kDone;"}}},
        Planted{"InASwitch",
                {{"", "whitted.comp", "  bool finishedBefore = phase == kDone;",
                  "  switch (pixel.x % 3u) {\n    case 1u: /*here*/for (;;) sum.x += 1.0;\n"
                  "    case 2u: break;\n    default: for (int i = 0; i < 9; ++i) sum.y += 1.0;\n  }\n"
                  "  bool finishedBefore = phase == kDone;"}}}),
    [](const auto& parameter) { return parameter.param.name; });

// Many turns that end, in a loop of some invocations: a driver's limiter may cut them, and those beside them, whose
// loops are innocent. The loop with the most is told.
TEST(LoopProbe, TellsTheLoopWithTheMostTurnsWhereOnlyTheDriverCut) {
  const std::vector<test::Replacement> replacements = {
      {"", "whitted.comp", "  bool finishedBefore = phase == kDone;",
       "  float x = float(pixelAt);\n  if (pixel.x % 8u == 3u) for (int i = 0; i < 1000; ++i)\n    /*here*/for (int j "
       "= 0; "
       "j < 2000; ++j)\n"
       "      x = x * 0.75 + 1.0;\n  sum.x += x;\n  bool finishedBefore = phase == kDone;"}};
  const test::ShaderVariant variant(replacements);
  const std::vector<ShaderSource> sources = readShaderSources(variant.folder() + "/shaders/whitted.comp");
  const LoopProbe probe = probeLoops(sources);
  const Scene scene = ours("spheres");
  const RenderSettings settings = settingsOf(scene, 16, 16);
  test::renderer().upload(test::packed(scene, settings));
  try {
    const Image probed = render(compileProbe(probe, test::renderer().access()), settings, kProbeBudget);
    // A driver without a limiter cuts nothing: then it is the picture of the kernel that was not probed.
    const Image plain = render(compileGlsl(sources, accessPreamble(test::renderer().access())), settings, kProbeBudget);
    EXPECT_EQ(probed.rgb, plain.rgb);
  } catch (const LoopsCut& cut) {
    const std::optional<SourceLocation> location = endlessLoop(probe, cut.count);
    ASSERT_TRUE(location);
    EXPECT_EQ(location->line, placeOfHere(sources).line);
  }
}

}  // namespace
}  // namespace turner::watch
